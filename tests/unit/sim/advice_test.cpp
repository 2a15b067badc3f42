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
  EXPECT_FALSE(says(advice_on_energy(c, {}), "total_lagrangian"));
  c.shape_functions = ShapeFunctions::linear;
  EXPECT_TRUE(says(advice_on_energy(c, {}), "linear"));
  c.volumetric = Volumetric::mixed;
  EXPECT_TRUE(says(advice_on_energy(c, {}), "total_lagrangian"));
  c.contacts.emplace_back().other = "b";
  EXPECT_FALSE(says(advice_on_energy(c, {}), "total_lagrangian"));
}

TEST(Advice, LoadsThatAreThereFromTheStart) {
  Case c = a_case(LinearElastic{});
  EXPECT_FALSE(says(advice_on_energy(c, {.first = 0.5}), "grow"));  // there are none
  c.pressures.emplace_back().value = TimeFunction("1e5 + 0*t");
  EXPECT_TRUE(says(advice_on_energy(c, {.first = 0.5}), "grow"));
  c.stages[0].steps.analysis = Analysis::dynamic;  // where a sudden load is one
  EXPECT_FALSE(says(advice_on_energy(c, {.first = 0.5}), "grow"));
}

/// Brittle structures that let go in one step are no matter of its size.
TEST(Advice, SnapBackThatWasJumpedOver) {
  const Case concrete = a_case(Rankine{}), steel = a_case(LinearElastic{});
  EXPECT_TRUE(says(advice_on_energy(concrete, {.largest = 0.9, .time = 0.3}), "step to time 0.3"));
  EXPECT_FALSE(says(advice_on_energy(concrete, {.largest = 0.1, .time = 0.3}), "snaps back"));
  EXPECT_FALSE(says(advice_on_energy(steel, {.largest = 0.9, .time = 0.3}), "snaps back"));
}

}  // namespace
}  // namespace berm
