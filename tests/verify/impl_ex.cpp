/// IMPL-EX keeps its tolerance.

#include <fmt/format.h>

#include <algorithm>

#include "driver.hpp"

namespace berm::verify {
namespace {

/// A bar of 60 cells, of which the middle one softens.
const std::string bar = R"toml(
method = "mpm"
model = { plane = "stress", kinematics = "small" }
grid = { cell_size = 0.005, cells = [60, 1] }
[material.strong]
law = "linear_elastic"
density = 2400.0
youngs_modulus = 35.5e9
poisson_ratio = 0.0
[material.weak]
law = "rankine"
density = 2400.0
youngs_modulus = 35.5e9
poisson_ratio = 0.0
tensile_strength = 3.05e6
fracture_energy = 100.0
[body.left]
material = "strong"
shape.box = { min = [0.0, 0.0], max = [0.15, 0.005] }
[body.weak]
material = "weak"
shape.box = { min = [0.15, 0.0], max = [0.155, 0.005] }
[body.right]
material = "strong"
shape.box = { min = [0.155, 0.0], max = [0.3, 0.005] }
[boundary.left]
where.box = { min = [-1e-6, -1.0], max = [1e-6, 1.0] }
ux = 0.0
[boundary.bottom]
where.box = { min = [-1.0, -1e-6], max = [9.0, 1e-6] }
uy = 0.0
[boundary.right]
where.box = { min = [0.299999, -1.0], max = [0.300001, 1.0] }
ux = 4e-4
[solver]
integration = "impl_ex"
)toml";

/// Steps were taken that were up to four times beyond the tolerance of the damage: the peak was a tenth too high.
TEST(ImplEx, PeakIsTheStrengthByDefault) {
  Model m(bar);
  double peak = 0.0, error = 0.0;
  ASSERT_TRUE(m.run([&](const StepResult& result) {
    peak = std::max(peak, m.material().stress[0][XX]);
    error = std::max(error, result.extrapolation_error);
  }));
  EXPECT_LT(peak, 1.01 * 3.05e6);
  EXPECT_LE(error, 1.1 * m.world->spec.steps.error_tolerance);  // where the bar snaps back no step is small enough, and the run warns
  record({"IMPL-EX", "softening bar, all defaults: peak stress over ft", peak / 3.05e6, "1", "1 %", "strength"});
}

/// What the smallest step does not keep is known.
TEST(ImplEx, ErrorOfStepsThatCannotBeCutIsReported) {
  Model m(bar, {"steps.count=50", "steps.min_fraction=1.0"});
  double error = 0.0;
  ASSERT_TRUE(m.run([&](const StepResult& result) { error = std::max(error, result.extrapolation_error); }));
  EXPECT_GT(error, m.world->spec.steps.error_tolerance);
}

}  // namespace
}  // namespace berm::verify
