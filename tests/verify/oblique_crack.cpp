/// A notched plate pulled apart on grids turned against it. A crack along a row of cells dissipates the fracture energy
/// per area; across the rows it is wider than one cell and dissipates more. How much more is reported.

#include <fmt/format.h>

#include <algorithm>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double Gf = 100.0, ligament = 0.08;

std::string case_text(double angle) {
  return fmt::format(R"(
[model]
plane = "stress"
kinematics = "small"
[grid]
origin = [-0.1625, -0.1625]
cell_size = 0.005
cells = [65, 65]
angle = {}
[material.concrete]
law = "rankine"
density = 2400.0
youngs_modulus = 35.5e9
poisson_ratio = 0.2
tensile_strength = 3.05e6
fracture_energy = {}
[body.plate]
material = "concrete"
shape.difference = [{{ box = {{ min = [-0.075, -0.05], max = [0.075, 0.05] }} }},
                    {{ box = {{ min = [-0.0025, 0.04], max = [0.0025, 0.06] }} }},
                    {{ box = {{ min = [-0.0025, -0.06], max = [0.0025, -0.04] }} }}]
[body.left]
rigid = true
shape.box = {{ min = [-0.1, -0.05], max = [-0.075, 0.05] }}
[body.right]
rigid = true
shape.box = {{ min = [0.075, -0.05], max = [0.1, 0.05] }}
displacement = [3e-4, 0.0]
[contact.left]
body = "plate"
rigid = "left"
[contact.right]
body = "plate"
rigid = "right"
[steps]
count = 300
min_fraction = 0.1
error_tolerance = 0.05
[solver]
integration = "impl_ex"
)",
                     angle, Gf);
}

TEST(ObliqueCrack, DissipatedEnergyOverFractureEnergy) {
  for (const double angle : {0.0, 15.0, 30.0, 45.0}) {
    Model model(case_text(angle));
    constexpr int pulled = 2;  // third body of the case
    auto force = [&] { return model.step.balance().reactions.rigid[pulled].x(); };
    double peak = 0.0;
    EXPECT_TRUE(model.run([&](const StepResult&) { peak = std::max(peak, force()); }));
    EXPECT_LT(force(), 0.05 * peak);  // broken
    const double energy = model.material().dissipated_energy() / (Gf * ligament);
    const bool aligned = angle == 0.0;
    EXPECT_GT(energy, 0.95);
    EXPECT_LT(energy, aligned ? 1.05 : 1.9);
    record({"Oblique crack",
            fmt::format("crack at {} deg to the rows of cells: dissipated energy over Gf times ligament", angle),
            energy, "1", aligned ? "5 %" : "reported, 0.95 to 1.9", "fracture energy of the case"});
  }
}

}  // namespace
}  // namespace berm::verify
