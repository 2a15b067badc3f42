/// A specimen whose outline cuts the cells of the grid anywhere: stiffness and Newton's method must not notice.

#include <fmt/format.h>

#include <algorithm>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double h = 0.0125, youngs = 35.5e9;

/// Offsets of the grid in cells.
const std::vector<double> offsets = {0.0, 1e-9, 1e-6, 1e-3, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 1.0 - 1e-6};

std::string common(double offset, double width, double height, const std::string& law) {
  return fmt::format(R"(
[model]
plane = "stress"
[grid]
origin = [{}, {}]
cell_size = {}
cells = [12, 20]
[material.m]
density = 2400.0
youngs_modulus = {}
poisson_ratio = 0.2
{}
[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [{}, {}] }}
[gauge.height]
from = [0.05, 0.05]
to = [0.05, 0.15]
)",
                     -2 * h - offset * h, -2 * h - offset * h, h, youngs, law, width, height);
}

const std::string elastic = "law = \"linear_elastic\"";

struct Reached {
  double modulus = 0.0;  ///< nominal stress over gauge strain
  int iterations = 0;
  double damage = 0.0;
};

/// Uniaxial pull by equal pressures on top and base: the exact strain is uniform.
Reached pulled(double offset) {
  constexpr double stress = 1e6;
  Model model(common(offset, 8 * h, 16 * h, elastic) + fmt::format(R"(
[pressure.top]
body = "b"
where.box = {{ min = [-1.0, {0}], max = [1.0, {1}] }}
value = {2}
[pressure.base]
body = "b"
where.box = {{ min = [-1.0, -1e-6], max = [1.0, 1e-6] }}
value = {2}
[pin.low]
body = "b"
at = [0.05, 0.05]
fix = "xy"
[pin.high]
body = "b"
at = [0.05, 0.15]
fix = "x"
[steps]
count = 2
adaptive = false
)",
                                                                   16 * h - 1e-6, 16 * h + 1e-6, -stress));
  Reached r;
  for (int k = 0; k < 2; ++k) r.iterations = std::max(r.iterations, model.advance(0.5).iterations);
  r.modulus = stress / (model.world->boundary->gauges()[0].elongation() / 0.1);
  return r;
}

TEST(CutCells, UniaxialStiffnessIsExact) {
  double worst = 0.0;
  int most = 0;
  for (const double offset : offsets) {
    const Reached r = pulled(offset);
    fmt::print("  offset {}: E {:.8g}, {} linear solves\n", offset, r.modulus, r.iterations);
    worst = std::max(worst, relative(r.modulus, youngs));
    most = std::max(most, r.iterations);
  }
  EXPECT_LT(worst, 1e-4);  // the strain is 2.8e-5: finite strain is that much stiffer
  EXPECT_LE(most, 6);
  record({"Cut cells", fmt::format("uniaxial pull, {} grid offsets: largest error of Young's modulus", offsets.size()),
          worst, "0", "1e-4", "uniform stress"});
  record({"Cut cells", "the same: most linear solves in a step", double(most), "few", "<= 6", "Newton's method"});
}

/// Compression between rough platens, tied at both ends: no uniform field, exact stiffness unknown, but it is one
/// number.
Reached between_platens(double offset, const std::string& law, double strain, int steps) {
  Model model(common(offset, 8 * h, 16 * h, law) + fmt::format(R"(
[body.top]
rigid = true
shape.box = {{ min = [0.0, {}], max = [{}, {}] }}
displacement = [0.0, {}]
[body.base]
rigid = true
shape.box = {{ min = [0.0, -0.02], max = [{}, 0.0] }}
[contact.top]
body = "b"
rigid = "top"
[contact.base]
body = "b"
rigid = "base"
[steps]
count = {}
adaptive = false
)",
                                                               16 * h, 8 * h, 16 * h + 0.02, -strain * 16 * h, 8 * h,
                                                               steps));
  Reached r;
  for (int k = 0; k < steps; ++k) r.iterations = std::max(r.iterations, model.advance(1.0 / steps).iterations);
  const int top = 1;  // second body of the case
  r.damage = model.material().max_damage();
  r.modulus = -model.step.balance().reactions.rigid[top].y() / (8 * h) / strain;
  return r;
}

TEST(CutCells, StiffnessBetweenPlatensDoesNotDependOnTheOffset) {
  double low = infinity, high = 0.0;
  int most = 0;
  for (const double offset : offsets) {
    const Reached r = between_platens(offset, elastic, 1e-4, 1);
    fmt::print("  offset {}: stiffness {:.8g}, {} linear solves\n", offset, r.modulus, r.iterations);
    low = std::min(low, r.modulus);
    high = std::max(high, r.modulus);
    most = std::max(most, r.iterations);
  }
  EXPECT_LT(high / low - 1.0, 0.005);
  EXPECT_LE(most, 6);
  record({"Cut cells", fmt::format("rough platens, {} grid offsets: spread of the stiffness", offsets.size()),
          high / low - 1.0, "0", "0.5 %", "the stiffness is a property of the specimen"});
}

TEST(CutCells, DamagingStepsConvergeAtEveryOffset) {
  const std::string damage =
      "law = \"simo_ju\"\ntensile_strength = 3.05e6\nstrength_ratio = 12.3\nfracture_energy = 100.0";
  double low = infinity, high = 0.0, largest = 0.0;
  int most = 0;
  for (const double offset : offsets) {
    // To 85 % of the strain at which uniaxial compression peaks: the edges of the platens are damaged, the rest is not.
    const Reached r = between_platens(offset, damage, 0.9e-3, 20);
    largest = std::max(largest, r.damage);
    fmt::print("  offset {}: {:.6g}, damage {:.4f}, {} linear solves\n", offset, r.modulus, r.damage, r.iterations);
    low = std::min(low, r.modulus);
    high = std::max(high, r.modulus);
    most = std::max(most, r.iterations);
  }
  EXPECT_LT(high / low - 1.0, 0.005);
  EXPECT_GT(largest, 0.1);
  EXPECT_LE(most, 8);
  record({"Cut cells", "rough platens, Simo-Ju, damaged edges: spread of the secant stiffness", high / low - 1.0, "0",
          "0.5 %", "the same"});
  record({"Cut cells", "the same: most linear solves in a step", double(most), "few", "<= 8", "Newton's method"});
}

}  // namespace
}  // namespace berm::verify
