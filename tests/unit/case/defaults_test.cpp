/// What a case gets that says nothing of the way it is computed.   [docs/adr/0016]

#include "case_files.hpp"

namespace berm {
namespace {

const std::string head = "[grid]\ncells = [4, 4]\ncell_size = 0.5\n";
const std::string body = "[body.b]\nmaterial = \"m\"\nshape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }\n";

std::string material(const std::string& law, double nu = 0.3) {
  return "[material.m]\nlaw = \"" + law + "\"\ndensity = 2000.0\nyoungs_modulus = 1e9\npoisson_ratio = " +
         std::to_string(nu) + "\n";
}
const std::string brittle = material("rankine") + "tensile_strength = 1e6\nfracture_energy = 1000.0\n";
const std::string tresca = material("mohr_coulomb") + "cohesion = 1e4\nfriction_angle = 0.0\n";

struct Chosen {
  Formulation formulation;
  ShapeFunctions functions;
  Volumetric volumetric;
  friend bool operator==(const Chosen&, const Chosen&) = default;
};

class ChosenDefaults : public CaseFiles {
protected:
  Chosen chosen(const std::string& text, const std::vector<std::string>& overrides = {}) const {
    const Case c = read(text, overrides);
    return {c.formulation, c.shape_functions, c.volumetric};
  }
};

using enum Formulation;
using enum ShapeFunctions;
using enum Volumetric;

TEST_F(ChosenDefaults, BodiesThatMoveGetDomains) {
  EXPECT_EQ(chosen(head + material("linear_elastic") + body), (Chosen{updated_lagrangian, cpgimp, standard}));
  EXPECT_EQ(chosen(head + material("linear_elastic") + body, {"grid.kind=union_jack"}),
            (Chosen{updated_lagrangian, cpdi, standard}));
}

TEST_F(ChosenDefaults, LinearFunctionsWhereNoPointCrossesACell) {
  const std::string text = head + material("linear_elastic") + body;
  EXPECT_EQ(chosen(text, {"model.kinematics=small"}), (Chosen{updated_lagrangian, linear, standard}));
  EXPECT_EQ(chosen(text, {"model.formulation=total_lagrangian"}), (Chosen{total_lagrangian, linear, standard}));
}

TEST_F(ChosenDefaults, BrittleSpecimensAreTotalLagrangian) {
  EXPECT_EQ(chosen(head + brittle + body), (Chosen{total_lagrangian, linear, standard}));
  EXPECT_EQ(chosen(head + brittle + body, {"steps.analysis=dynamic"}), (Chosen{updated_lagrangian, cpgimp, standard}));
}

TEST_F(ChosenDefaults, FBarWhereALawLocks) {
  EXPECT_EQ(chosen(head + tresca + body), (Chosen{updated_lagrangian, ugimp, f_bar}));
  EXPECT_EQ(chosen(head + tresca + body, {"model.kinematics=small"}), (Chosen{updated_lagrangian, linear, f_bar}));
  EXPECT_EQ(chosen(head + material("linear_elastic", 0.49) + body), (Chosen{updated_lagrangian, cpgimp, f_bar}));
  EXPECT_EQ(chosen(head + material("linear_elastic", 0.49) + body, {"model.plane=stress"}),
            (Chosen{updated_lagrangian, cpgimp, standard}));
  EXPECT_EQ(chosen(head + tresca + body, {"grid.kind=union_jack"}), (Chosen{updated_lagrangian, cpdi, standard}));
}

TEST_F(ChosenDefaults, EveryKeyOverrides) {
  const std::string text = head + tresca + body;
  EXPECT_EQ(chosen(text, {"grid.shape_functions=linear"}), (Chosen{updated_lagrangian, linear, f_bar}));
  EXPECT_EQ(chosen(text, {"model.volumetric=standard"}), (Chosen{updated_lagrangian, ugimp, standard}));
  EXPECT_EQ(chosen(head + brittle + body, {"model.formulation=updated_lagrangian"}),
            (Chosen{updated_lagrangian, cpgimp, standard}));
}

/// What was chosen stands in the resolved case, which gives the same case again, and is told.
TEST_F(ChosenDefaults, AreWrittenOutAndTold) {
  const Case c = read(head + tresca + body);
  EXPECT_NE(c.resolved.find("shape_functions = \"ugimp\""), std::string::npos);
  EXPECT_NE(c.resolved.find("volumetric = \"f_bar\""), std::string::npos);
  EXPECT_EQ(c.choices.size(), 2u);
  const Case again = read(c.resolved);
  EXPECT_TRUE(again.choices.empty());
  EXPECT_EQ(again.shape_functions, c.shape_functions);
}

}  // namespace
}  // namespace berm
