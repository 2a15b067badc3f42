/// A bar with one weak cell: the cell softens, the rest unloads. delta(s) and the dissipated energy are known exactly.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double E = 35.5e9, ft = 3.05e6, Gf = 100.0;

/// End displacement at the stress s after the peak: (L - l) s/E + l (ft/E) (1 - ln(s/ft)/A), the second term by eq.
/// (16).
double exact_displacement(double s, double L, double l) {
  const double A = 1.0 / (E * Gf / (l * ft * ft) - 0.5);
  return (L - l) * s / E + l * ft / E * (1.0 - std::log(s / ft) / A);
}

/// Only the weak cell can soften.
std::string case_text(double L, double h, const std::string& drive) {
  const int n = static_cast<int>(std::lround(L / h));
  const double a = n / 2 * h, b = a + h;
  auto body = [&](const char* name, double x0, double x1) {
    return fmt::format("[body.{}]\nmaterial = \"{}\"\nshape.box = {{ min = [{}, 0.0], max = [{}, {}] }}\n", name,
                       std::string(name) == "weak" ? "weak" : "strong", x0, x1, h);
  };
  return fmt::format(R"(
[model]
plane = "stress"
kinematics = "small"
[grid]
cell_size = {0}
cells = [{1}, 1]
[boundary.left]
where.box = {{ min = [-1e-6, -1.0], max = [1e-6, 1.0] }}
ux = 0.0
[boundary.bottom]
where.box = {{ min = [-1.0, -1e-6], max = [9.0, 1e-6] }}
uy = 0.0
[gauge.crack]
from = [{2}, {3}]
to = [{4}, {3}]
[gauge.bar]
from = [0.0, {3}]
to = [{5}, {3}]
[material.strong]
law = "linear_elastic"
density = 2400.0
youngs_modulus = {6}
poisson_ratio = 0.0
[material.weak]
law = "rankine"
density = 2400.0
youngs_modulus = {6}
poisson_ratio = 0.0
tensile_strength = {7}
fracture_energy = {8}
)",
                     h, n, a, 0.5 * h, b, L, E, ft, Gf) +
         body("left", 0.0, a) + body("weak", a, b) + body("right", b, L) + drive;
}

std::string pulled_end(double L, double displacement) {
  return fmt::format("[boundary.right]\nwhere.box = {{ min = [{}, -1.0], max = [{}, 1.0] }}\nux = {}\n", L - 1e-6,
                     L + 1e-6, displacement);
}

/// The end is pulled by a traction whose factor is found such that the crack opens steadily.
std::string opened_crack(double L, double opening) {
  return fmt::format(R"(
[pressure.end]
body = "right"
where.box = {{ min = [{}, -1.0], max = [{}, 1.0] }}
value = {}
[control]
kind = "gauge"
gauge = "crack"
target = {}
)",
                     L - 1e-6, L + 1e-6, -ft, opening);
}

/// Share of Gf dissipated when damage has reached its cap of 1 - 1e-5, eqs. (5), (18).
double dissipated_share(double l) {
  const double A = 1.0 / (E * Gf / (l * ft * ft) - 0.5);
  double low = 1.0, high = 1e6;
  for (int k = 0; k < 200; ++k) {
    const double x = 0.5 * (low + high);
    (std::exp(A * (1.0 - x)) / x > 1e-5 ? low : high) = x;
  }
  return 1.0 - (0.5 * low + 1.0 / A) * std::exp(A * (1.0 - low)) / (0.5 + 1.0 / A);
}

struct Curve {
  bool finished = false;
  double worst_displacement = 0.0;  ///< |delta - delta(s)| / delta(s) after the peak
  double dissipated = 0.0;          ///< over Gf times the section
  double backwards = 0.0;           ///< largest decrease of delta in a step [m]
  double peak = 0.0;                ///< largest stress over ft
  int rows = 0;                     ///< points of the curve that were compared
};

/// The curve is compared where the stress is between 2 % of ft and `below` ft.
Curve run(double L, double h, const std::string& drive, const std::vector<std::string>& overrides, double below = 1.0) {
  Model model(case_text(L, h, drive), overrides);
  Curve c;
  double last = 0.0;
  c.finished = model.run([&](const StepResult&) {
    const double s = model.material().stress[0][XX], delta = model.world->boundary->gauges()[1].elongation();
    c.backwards = std::max(c.backwards, last - delta);
    last = delta;
    c.peak = std::max(c.peak, s / ft);
    if (model.material().max_damage() == 0.0 || s < 0.02 * ft || s > below * ft) return;
    ++c.rows;
    c.worst_displacement = std::max(c.worst_displacement, relative(delta, exact_displacement(s, L, h)));
  });
  c.dissipated = model.material().dissipated_energy() / (Gf * h);
  return c;
}

void check(const std::string& name, const Curve& c, double h) {
  SCOPED_TRACE(name);
  EXPECT_TRUE(c.finished);
  EXPECT_GT(c.rows, 50);
  EXPECT_LT(c.worst_displacement, 0.01);
  const double share = dissipated_share(h);
  EXPECT_NEAR(c.dissipated, share, 0.01);
  record({"Softening bar", name + ": largest error of delta(s)", c.worst_displacement, "0", "1 %",
          "theory/damage.md, eq. (16)"});
  record({"Softening bar", name + ": dissipated energy over Gf", c.dissipated, fmt::format("{:.4f}", share), "1 %",
          "theory/damage.md, eqs. (6), (18)"});
}

TEST(SofteningBar, ImplicitUnderDisplacementControl) {
  for (const double L : {0.1, 0.3})
    for (const double h : {0.01, 0.005, 0.0025})
      check(fmt::format("L = {} m, h = {} mm, implicit", L, 1e3 * h),
            run(L, h, pulled_end(L, 4e-4), {L < 0.2 ? "steps.count=2000" : "steps.count=4000"}), h);
}

TEST(SofteningBar, ImplicitUnderGaugeControlThroughSnapBack) {
  for (const double h : {0.01, 0.005, 0.0025}) {
    const Curve c = run(0.6, h, opened_crack(0.6, 4e-4), {"steps.count=800"});
    check(fmt::format("L = 0.6 m, h = {} mm, implicit, gauge control", 1e3 * h), c, h);
    EXPECT_GT(c.backwards, 0.0);  // L > lch + l/2: the end moves back
  }
}

TEST(SofteningBar, ImplExOvershootsThePeakByItsTolerance) {
  const double h = 0.005, L = 0.3;
  double last = infinity;
  for (const double tolerance : {0.02, 0.005}) {
    const Curve c = run(L, h, pulled_end(L, 4e-4),
                        {"solver.integration=\"impl_ex\"", "steps.count=2000", "steps.min_fraction=1e-6",
                         fmt::format("steps.error_tolerance={}", tolerance)},
                        0.5);
    const std::string name = fmt::format("L = {} m, h = {} mm, impl_ex, error tolerance {}", L, 1e3 * h, tolerance);
    check(name + ", s < ft/2", c, h);
    EXPECT_LT(c.peak, 1.06);
    EXPECT_LT(c.peak, last);
    last = c.peak;
    record({"Softening bar", name + ": peak stress over ft", c.peak, "1", "1.06", "strength"});
  }
}

}  // namespace
}  // namespace berm::verify
