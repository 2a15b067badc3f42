/// Newton's method converges with order 2 in damaging steps: the tangents of laws and kernels are consistent.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "driver.hpp"

namespace berm::verify {
namespace {

/// A block of 8 x 8 cells whose lower side is clamped along its left half and whose upper side is pulled up without
/// sideways motion: damage grows from the end of the clamp, a tough material keeps it from localising in a row of
/// cells.
std::string case_text(const std::string& method, const std::string& law, const std::string& kinematics) {
  return fmt::format(R"(
method = "{}"
[model]
plane = "strain"
kinematics = "{}"
[grid]
cells = [8, 8]
cell_size = 0.0125
[material.m]
density = 2400.0
youngs_modulus = 35.5e9
poisson_ratio = 0.2
tensile_strength = 3.05e6
fracture_energy = 4000.0
law = "{}"
{}
[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [0.1, 0.1] }}
mesh = {{ kind = "quads", size = 0.0125, structured = true }}
[boundary.base]
where.box = {{ min = [-1.0, -1e-6], max = [0.050001, 1e-6] }}
ux = 0.0
uy = 0.0
[boundary.top]
where.box = {{ min = [-1.0, 0.099999], max = [1.0, 0.100001] }}
ux = 0.0
uy = 1.2e-5
[steps]
count = 20
adaptive = false
[solver]
relative_tolerance = 1e-9
absolute_tolerance = 1e-14
)",
                     method, kinematics, law, law == "simo_ju" ? "strength_ratio = 12.3" : "");
}

TEST(NewtonOrder, QuadraticInDamagingSteps) {
  constexpr int steps = 20;
  for (const std::string method : {"mpm", "fem"})
    for (const std::string law : {"simo_ju", "rankine"})
      for (const std::string kinematics : {"small", "finite"}) {
        Model model(case_text(method, law, kinematics));
        std::vector<double> found = newton_orders(model, steps);
        ASSERT_GE(found.size(), 3u) << method << " " << law << " " << kinematics;
        EXPECT_GT(model.material().max_damage(), 0.05);
        std::nth_element(found.begin(), found.begin() + found.size() / 2, found.end());
        const double median = found[found.size() / 2];
        EXPECT_GT(median, 1.7) << method << " " << law << " " << kinematics;
        record({"Newton", fmt::format("{}, {}, {} strain: median order in damaging steps", method, law, kinematics),
                median, "2", "> 1.7", "quadratic convergence of Newton's method"});
      }
}

}  // namespace
}  // namespace berm::verify
