/// Coulomb friction against a rigid plane (docs/theory/boundaries.md), along the grid and across it: a block that is
/// pushed, and one on a plane that is tilted until it slides.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double mu = 0.4, density = 2000.0, gravity = 9.81, width = 1.0, height = 0.5;
constexpr double weight = density * gravity * width * height;

/// A rectangle turned by `angle` about the origin.
std::string turned(double x0, double y0, double x1, double y1, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  std::string text = "[";
  for (const auto& [x, y] : {std::pair(x0, y0), {x1, y0}, {x1, y1}, {x0, y1}})
    text += fmt::format("[{:.16g}, {:.16g}], ", c * x - s * y, s * x + c * y);
  return text + "]";
}

std::string block(const std::string& method, double angle) {
  std::string text = fmt::format("method = \"{}\"\n", method);
  text += fmt::format(
      "[material.m]\nlaw = \"linear_elastic\"\ndensity = {}\nyoungs_modulus = 10e6\npoisson_ratio = 0.3\n", density);
  text += "[grid]\norigin = [-1.0, -1.0]\ncell_size = 0.125\ncells = [24, 24]\n";
  text += "[body.b]\nmaterial = \"m\"\nmesh = { kind = \"quads\", size = 0.125 }\nshape.polygon = " +
          turned(0.0, 0.0, width, height, angle) + "\n";
  text += "[body.plane]\nrigid = true\nshape.polygon = " + turned(-1.0, -0.5, 3.0, 0.0, angle) + "\n";
  text += fmt::format(
      "[contact.base]\nbody = \"b\"\nrigid = \"plane\"\nkind = \"friction\"\nfriction = {}\n"
      "stiffness = 100.0\n",
      mu);
  return text;
}

struct Measured {
  double normal, shear, heat, energy;
};

/// Weight in the first half of the time, then a smooth stamp pushes the block along the plane by 2 mm.
void push(const std::string& method, double degrees) {
  const double a = degrees * std::numbers::pi / 180.0;
  const Vec3 along(std::cos(a), std::sin(a), 0.0), up(-std::sin(a), std::cos(a), 0.0);
  constexpr double way = 2e-3;
  std::string text = block(method, a);
  text += fmt::format("[model]\ngravity = [\"{:.16g}*min(2*t,1)\", \"{:.16g}*min(2*t,1)\"]\n", -gravity * up.x(),
                      -gravity * up.y());
  text += "[body.stamp]\nrigid = true\nshape.polygon = " + turned(-0.3, 0.05, 0.0, 0.45, a);
  text += fmt::format("\ndisplacement = [\"{:.16g}*max(2*t-1,0)\", \"{:.16g}*max(2*t-1,0)\"]\n", way * along.x(),
                      way * along.y());
  text += "[contact.side]\nbody = \"b\"\nrigid = \"stamp\"\nkind = \"frictionless\"\nstiffness = 100.0\n";
  text += "[steps]\ncount = 40\nadaptive = false\n";
  Model model(text);
  std::vector<Measured> history;
  ASSERT_TRUE(model.run([&](const StepResult&) {
    const Balance& b = model.step.balance();
    history.push_back({b.reactions.rigid[1].dot(up), b.reactions.rigid[1].dot(along), b.friction_work,
                       b.external_work - model.material().stored_energy()});
    EXPECT_LT(std::abs(history.back().shear + b.reactions.rigid[2].dot(along)), 1e-6 * weight);
    EXPECT_LE(std::abs(history.back().shear), mu * history.back().normal * (1.0 + 1e-9));
  }));
  ASSERT_EQ(history.size(), 40u);
  // Nothing but the weight.
  EXPECT_LT(relative(history[19].normal, weight), 1e-6);
  // The push has begun and is below the limit, and at the end all slides.
  EXPECT_LT(-history[20].shear, 0.9 * mu * weight);
  EXPECT_GT(-history[20].shear, 0.1 * mu * weight);
  const Measured& end = history.back();
  const double shear = relative(-end.shear, mu * weight);
  EXPECT_LT(shear, 1e-6);
  EXPECT_LT(relative(end.normal, weight), 1e-6);
  const double heat = relative(end.heat - history[38].heat, mu * weight * way / 20.0);
  EXPECT_LT(heat, 1e-3);  // in MPM the pressure shifts as points cross cells
  // What the outside has done is stored or heat.
  EXPECT_LT(std::abs(end.energy - end.heat), 0.02 * end.heat);
  const std::string name = fmt::format("{}, plane at {} degrees: ", method, degrees);
  record({"Coulomb friction", name + "force that pushes a sliding block", shear, "0", "1e-6", "mu N"});
  record({"Coulomb friction", name + "heat of a step of sliding", heat, "0", "1e-3", "mu N d"});
}

TEST(Friction, PushedBlockFem) { push("fem", 0.0); }
TEST(Friction, PushedBlockMpm) { push("mpm", 0.0); }
TEST(Friction, PushedBlockObliqueFem) { push("fem", 20.0); }
TEST(Friction, PushedBlockObliqueMpm) { push("mpm", 20.0); }

/// Gravity turns by t [rad]: equilibrium ends at the angle of friction.
void tilt(const std::string& method, double degrees) {
  const double a = degrees * std::numbers::pi / 180.0;
  std::string text = block(method, a);
  text += fmt::format("[model]\ngravity = [\"{0}*sin(t+{1:.16g})\", \"-{0}*cos(t+{1:.16g})\"]\n", gravity, a);
  text += "[steps]\nduration = 0.5\ncount = 25\nmin_fraction = 1e-3\n";
  Model model(text);
  EXPECT_FALSE(model.run());  // no equilibrium beyond
  const double error = relative(model.world->time, std::atan(mu));
  EXPECT_LT(error, 2e-3);
  record({"Coulomb friction", fmt::format("{}, plane at {} degrees: angle at which a block slides", method, degrees),
          error, "0", "2e-3", "atan mu"});
}

TEST(Friction, TiltedBlockFem) { tilt("fem", 0.0); }
TEST(Friction, TiltedBlockMpm) { tilt("mpm", 0.0); }
TEST(Friction, TiltedBlockObliqueMpm) { tilt("mpm", 25.0); }

/// A disc between rough platens spreads: all places slide, some this way and some that. Johnson (1985), (5.57).
TEST(Friction, DiscBetweenPlatens) {
  constexpr double youngs = 1e8, poisson = 0.2, radius = 0.5, way = 0.01, size = 0.025;
  const auto closer = [&](double force) {
    const double c = (1.0 - poisson * poisson) / (std::numbers::pi * youngs);
    return 2.0 * force * c * (2.0 * std::log(4.0 * radius / std::sqrt(4.0 * force * radius * c)) - 1.0);
  };
  double low = 1e3, high = 1e6;
  while (high - low > 1.0) (closer(0.5 * (low + high)) < way ? low : high) = 0.5 * (low + high);
  std::string text = fmt::format(
      "[material.m]\nlaw = \"linear_elastic\"\ndensity = 2000.0\nyoungs_modulus = {}\npoisson_ratio = {}\n"
      "[grid]\norigin = [-1.0, -0.5]\ncell_size = {}\ncells = [80, 80]\n"
      "[body.disc]\nmaterial = \"m\"\nshape.disc = {{ centre = [0.0, 0.5], radius = {} }}\n",
      youngs, poisson, size, radius);
  text += "[body.floor]\nrigid = true\nshape.box = { min = [-0.9, -0.4], max = [0.9, 0.0] }\n";
  text += fmt::format("[body.top]\nrigid = true\nshape.box = {{ min = [-0.9, 1.0], max = [0.9, 1.3] }}\ndisplacement = [0.0, {}]\n", -way);
  for (const char* rigid : {"floor", "top"})
    text += fmt::format("[contact.{0}]\nbody = \"disc\"\nrigid = \"{0}\"\nkind = \"friction\"\nfriction = 0.3\n", rigid);
  for (const int count : {5, 20}) {
    Model model(text + fmt::format("[steps]\ncount = {}\n", count));
    ASSERT_TRUE(model.run()) << count;
    const double load = model.step.balance().reactions.rigid[2].y(), wrong = std::abs(load) / low - 1.0;
    EXPECT_LT(std::abs(wrong), 0.05) << count;
    record({"Coulomb friction", fmt::format("disc pressed between rough platens, 40 cells across, {} steps: load, less 1", count), wrong, "0", "0.05", "Johnson 1985"});
  }
}

/// Stiffness of sliding, sticking and open points against differences.
TEST(Friction, MatrixAgainstDifferences) {
  for (const bool solid : {false, true}) {
    SCOPED_TRACE(solid ? "space" : "plane");
    std::string text = solid ? "[model]\ndimension = 3\n" : "";
    text += "[material.m]\nlaw = \"linear_elastic\"\ndensity = 1.0\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\n";
    text += solid ? "[grid]\norigin = [-1.0, -1.0, -1.0]\ncell_size = 0.5\ncells = [6, 6, 6]\n"
                    "[body.b]\nmaterial = \"m\"\nshape.box = { min = [0.0, 0.0, 0.0], max = [1.0, 0.5, 0.5] }\n"
                    "[body.plane]\nrigid = true\nshape.box = { min = [-1.0, -1.0, -1.0], max = [2.0, 0.0, 2.0] }\n"
                  : "[grid]\norigin = [-1.0, -1.0]\ncell_size = 0.5\ncells = [6, 6]\n"
                    "[body.b]\nmaterial = \"m\"\nshape.box = { min = [0.0, 0.0], max = [1.0, 0.5] }\n"
                    "[body.plane]\nrigid = true\nshape.box = { min = [-1.0, -1.0], max = [2.0, 0.0] }\n";
    text += "[contact.base]\nbody = \"b\"\nrigid = \"plane\"\nkind = \"friction\"\nfriction = 0.5\n";
    Model model(text);
    const Discretisation& d = *model.world->discretisation;
    const BoundaryConditions& bc = *model.world->boundary;
    EXPECT_FALSE(bc.symmetric());
    const int dimension = d.dimension(), n = dimension * d.n_nodes();
    NodalVector du(d.n_nodes(), Vec3::Zero());
    for (int k = 0; k < n; ++k) du[k / dimension][k % dimension] = 1e-3 * std::sin(3.7 * k + 0.4);
    BlockAssembler assembler;
    assembler.build(d.blocks, d.n_nodes(), dimension);
    assembler.zero(std::vector<char>(n, 0), d.n_nodes(), 1.0);
    NodalVector unused(d.n_nodes(), Vec3::Zero());
    bc.add_forces(d, du, 0.0, 1.0, unused, &assembler);
    EXPECT_GT(bc.contact_work(du, 0.0, 1.0).heat, 0.0);
    const CsrMatrix& m = assembler.matrix();
    double worst = 0.0, largest = 0.0;
    for (int column = 0; column < n; ++column) {
      constexpr double h = 1e-9;
      NodalVector f[2];
      for (int side = 0; side < 2; ++side) {
        NodalVector moved = du;
        moved[column / dimension][column % dimension] += side == 0 ? h : -h;
        f[side].assign(d.n_nodes(), Vec3::Zero());
        bc.add_forces(d, moved, 0.0, 1.0, f[side], nullptr);
      }
      for (int row = 0; row < n; ++row) {
        double value = 0.0;
        for (int k = m.row_begin[row]; k < m.row_begin[row + 1]; ++k)
          if (m.column[k] == column) value = m.value[k];
        const int i = row / dimension, c = row % dimension;
        const double slope = (f[0][i][c] - f[1][i][c]) / (2.0 * h);
        worst = std::max(worst, std::abs(value - slope));
        largest = std::max(largest, std::abs(slope));
      }
    }
    EXPECT_LT(worst, 1e-5 * largest);
  }
}

}  // namespace
}  // namespace berm::verify
