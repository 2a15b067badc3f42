#include "sim/advice.hpp"

#include <gtest/gtest.h>

#include "case/case.hpp"

namespace berm {
namespace {

Case a_case(AnyLaw law) {
  Case c;
  c.materials.push_back({"m", law});
  c.stages.emplace_back();
  return c;
}

bool says(const std::string& advice, const std::string& word) { return advice.find(word) != std::string::npos; }

/// Remedies that the case would refuse, or has taken already, are no remedies.
TEST(Advice, NamesOnlyWhatTheCaseAccepts) {
  Case concrete = a_case(Rankine{});
  EXPECT_TRUE(says(advice_on_equilibrium(concrete, concrete.stages[0]), "integration = \"impl_ex\""));
  EXPECT_FALSE(says(advice_on_equilibrium(concrete, concrete.stages[0]), "gauge"));  // no pressure to scale
  concrete.pressures.emplace_back();
  EXPECT_TRUE(says(advice_on_equilibrium(concrete, concrete.stages[0]), "gauge"));
  concrete.stages[0].solver.integration = Integration::impl_ex;
  EXPECT_FALSE(says(advice_on_equilibrium(concrete, concrete.stages[0]), "impl_ex"));
  concrete.control.kind = Control::Kind::gauge;
  EXPECT_FALSE(says(advice_on_equilibrium(concrete, concrete.stages[0]), "gauge"));

  const Case soil = a_case(MohrCoulomb{}), elastic = a_case(LinearElastic{});
  EXPECT_FALSE(says(advice_on_equilibrium(soil, soil.stages[0]), "impl_ex"));
  EXPECT_FALSE(says(advice_on_equilibrium(elastic, elastic.stages[0]), "impl_ex"));
}

TEST(Advice, SendsNobodyToTotalLagrangianWhoseBodiesMeet) {
  Case c = a_case(LinearElastic{});
  c.shape_functions = ShapeFunctions::cpgimp;
  EXPECT_FALSE(says(advice_on_energy(c, false), "total_lagrangian"));
  c.shape_functions = ShapeFunctions::linear;
  EXPECT_TRUE(says(advice_on_energy(c, false), "linear"));
  c.volumetric = Volumetric::mixed;
  EXPECT_TRUE(says(advice_on_energy(c, false), "total_lagrangian"));
  c.contacts.emplace_back().other = "b";
  EXPECT_FALSE(says(advice_on_energy(c, false), "total_lagrangian"));
}

TEST(Advice, LoadsThatAreThereFromTheStart) {
  Case c = a_case(LinearElastic{});
  EXPECT_TRUE(says(advice_on_energy(c, true), "grow"));
  c.stages[0].steps.analysis = Analysis::dynamic;  // where a sudden load is one
  EXPECT_FALSE(says(advice_on_energy(c, true), "grow"));
}

}  // namespace
}  // namespace berm
