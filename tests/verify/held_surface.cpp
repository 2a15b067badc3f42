/// Displacements prescribed on surfaces that cut the cells of the grid.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr const char* group = "Held surfaces that cut cells";
constexpr double youngs = 1e6, poisson = 0.3;
constexpr double lame_lambda = youngs * poisson / ((1.0 + poisson) * (1.0 - 2.0 * poisson)),
                 lame_mu = youngs / (2.0 * (1.0 + poisson));

std::string material(double poisson_ratio = poisson) {
  return fmt::format("[material.m]\nlaw = \"linear_elastic\"\ndensity = 1000.0\nyoungs_modulus = {}\npoisson_ratio = {}\n",
                     youngs, poisson_ratio);
}

std::string disc(double radius) { return fmt::format("{{ disc = {{ centre = [0.0, 0.0], radius = {} }} }}", radius); }

/// Through 12 points on the circle.
std::string spline(double radius) {
  std::string points;
  for (int i = 0; i < 12; ++i) {
    const double angle = i * std::numbers::pi / 6.0;
    points += fmt::format("[{:.16g}, {:.16g}], ", radius * std::cos(angle), radius * std::sin(angle));
  }
  return fmt::format("{{ spline = [{}] }}", points);
}

/// Radii 1 m and 2 m, the inner one widened by 1 mm: u = A r + B / r, no stress at the outer one.
FieldErrors widen(const std::string& functions, double h, const std::function<std::string(double)>& round = disc) {
  const int half = static_cast<int>(2.2 / h) + 1;
  Model model(fmt::format(R"toml(
[model]
plane = "strain"
kinematics = "small"
[grid]
shape_functions = "{0}"
origin = [{1}, {2}]
cells = [{3}, {3}]
cell_size = {4}
{5}
[body.ring]
material = "m"
shape.difference = [{6}, {7}]
[boundary.inner]
body = "ring"
where.box = {{ min = [-1.1, -1.1], max = [1.1, 1.1] }}
ux = "1e-3*t*x"
uy = "1e-3*t*y"
[steps]
count = 10
adaptive = false
)toml",
                          functions, -(half + 0.37) * h, -(half + 0.21) * h, 2 * half + 1, h, material(), round(2.0), round(1.0)));
  EXPECT_TRUE(model.run());
  // u(1) = 1e-3, 2 (lambda + mu) A = 2 mu B / 4.
  const double B = 1e-3 / (1.0 + 0.25 * lame_mu / (lame_lambda + lame_mu)), A = 1e-3 - B;
  return field_errors(
      model,
      [&](const Vec3& x) {
        const double r2 = x.squaredNorm();
        return Vec3((A + B / r2) * x);
      },
      [&](const Vec3& x) {
        const double r2 = x.squaredNorm(), mean = 2.0 * (lame_lambda + lame_mu) * A, c = x.x() / std::sqrt(r2),
                     s = x.y() / std::sqrt(r2), shear = 2.0 * lame_mu * B / r2;
        Voigt v = Voigt::Zero();
        v[XX] = mean - shear * (c * c - s * s);
        v[YY] = mean + shear * (c * c - s * s);
        v[ZZ] = poisson * 2.0 * mean;
        v[XY] = -2.0 * shear * c * s;
        return v;
      });
}

TEST(HeldSurface, RingIsWidened) {
  struct Demand {
    const char* functions;
    double displacement, stress;  ///< with 20 cells over the wall
  };
  for (const Demand& want : {Demand{"linear", 8e-4, 0.035}, {"quadratic_bspline", 2e-4, 0.01}, {"b2gimp", 2e-4, 0.004},
                             {"cpdi", 8e-4, 0.035}}) {
    const FieldErrors coarse = widen(want.functions, 0.2), fine = widen(want.functions, 0.05);
    const double order = 0.5 * std::log2(coarse.displacement / fine.displacement);
    EXPECT_LT(fine.displacement, want.displacement) << want.functions;
    EXPECT_LT(fine.stress, want.stress) << want.functions;
    EXPECT_GT(order, 1.5) << want.functions;
    const std::string name = fmt::format("ring widened from inside, {}, 20 cells over the wall: ", want.functions);
    record({group, name + "L2 error of the displacement", fine.displacement, "0", fmt::format("{}", want.displacement),
            "Lame's solution"});
    record({group, name + "L2 error of the stress", fine.stress, "0", fmt::format("{}", want.stress), "Lame's solution"});
    record({group, name + "order of the displacement, from 5 cells", order, "2", "> 1.5", "Lame's solution"});
  }
}

TEST(HeldSurface, RingOfSplinesIsWidened) {
  const FieldErrors discs = widen("b2gimp", 0.05), splines = widen("b2gimp", 0.05, spline);
  EXPECT_LT(splines.displacement, 4e-4);
  EXPECT_LT(splines.stress, 0.004);
  EXPECT_NEAR(splines.stress, discs.stress, 0.2 * discs.stress);
  const std::string name = "ring whose rims are B-splines through 12 points, b2gimp, 20 cells over the wall: ";
  record({group, name + "L2 error of the displacement", splines.displacement, "0", "4e-04", "Lame's solution"});
  record({group, name + "L2 error of the stress", splines.stress, "0", "0.004", "Lame's solution"});
}

/// A square of 1 m turned by 30 degrees slides along three rigid walls, one of which pushes by 1 mm: stress in one
/// direction of strain.
TEST(HeldSurface, TurnedBlockBetweenSlidingWalls) {
  constexpr double angle = std::numbers::pi / 6.0;
  const double c = std::cos(angle), s = std::sin(angle);
  const auto turn = [&](double x, double y) { return Vec3(c * x - s * y, s * x + c * y, 0.0); };
  const auto text = [](const Vec3& x) { return fmt::format("[{:.16g}, {:.16g}]", x.x(), x.y()); };
  // Boxes and parallelograms stand for pieces of cut cells that have other outlines.
  for (const auto& [functions, most_displacement, most_stress] :
       {std::tuple{"linear", 5e-4, 1e-3}, {"b2gimp", 1e-3, 0.01}, {"cpdi", 1e-3, 0.005}}) {
    std::string walls;
    const auto wall = [&](const char* name, const Vec3& at, const Vec3& normal, const char* un) {
      walls += fmt::format("[boundary.{}]\nbody = \"block\"\nwhere.beyond = {{ at = {}, normal = {} }}\nun = {}\n", name, text(at),
                           text(normal), un);
    };
    wall("left", turn(1e-6, 0.0), turn(-1.0, 0.0), "0.0");
    wall("right", turn(1.0 - 1e-6, 0.0), turn(1.0, 0.0), "0.0");
    wall("base", turn(0.0, 1e-6), turn(0.0, -1.0), "0.0");
    wall("top", turn(0.0, 1.0 - 1e-6), turn(0.0, 1.0), "\"-1e-3*min(2*t, 1)\"");
    Model model(fmt::format("[model]\nplane = \"strain\"\nkinematics = \"small\"\n[grid]\nshape_functions = \"{}\"\n"
                            "origin = [-0.77, -0.23]\ncell_size = 0.1\ncells = [20, 18]\n{}"
                            "[body.block]\nmaterial = \"m\"\nshape.polygon = [{}, {}, {}, {}]\n{}[steps]\ncount = 8\nadaptive = false\n",
                            functions, material(), text(turn(0, 0)), text(turn(1, 0)), text(turn(1, 1)), text(turn(0, 1)),
                            walls));
    ASSERT_TRUE(model.run());
    const double e = -1e-3, along = (lame_lambda + 2.0 * lame_mu) * e, across = lame_lambda * e;
    const FieldErrors error = field_errors(
        model,
        [&](const Vec3& x) { return Vec3(turn(0.0, e * (-s * x.x() + c * x.y()))); },
        [&](const Vec3&) {
          Voigt v = Voigt::Zero();
          v[XX] = across * c * c + along * s * s;
          v[YY] = across * s * s + along * c * c;
          v[ZZ] = across;
          v[XY] = (across - along) * c * s;
          return v;
        });
    EXPECT_LT(error.displacement, most_displacement) << functions;
    EXPECT_LT(error.stress, most_stress) << functions;
    const Vec3 push = model.step.balance().reactions.boundary[3];
    EXPECT_LT((push - turn(0.0, along)).norm(), 1e-3 * std::abs(along)) << functions;
    // Half of the force times the way, and no more.
    EXPECT_NEAR(model.step.balance().external_work, -0.5 * along * 1e-3, 0.02 * std::abs(0.5 * along * 1e-3)) << functions;
    const std::string name = fmt::format("block turned by 30 deg between sliding walls, {}: ", functions);
    record({group, name + "L2 error of the displacement", error.displacement, "0", fmt::format("{}", most_displacement), "uniform strain"});
    record({group, name + "L2 error of the stress", error.stress, "0", fmt::format("{}", most_stress), "uniform strain"});
    record({group, name + "push of the moving wall [N]", push.norm(), fmt::format("{:.6g}", std::abs(along)), "0.1 %",
            "uniform strain"});
  }
}

/// 4 m by 2 m, no line of which is one of the bodies', and a solid without lateral strain.
const std::string wide_grid =
    "origin = [-0.53, -0.53]\ncell_size = 0.1\ncells = [40, 20]\n" + material(0.0);

/// A block under its weight on a held base, which carries it through ten cells in 400 steps: the stress stays that of the
/// weight. What held it was once carried from step to step, and grew without end.
TEST(HeldSurface, CarriesABlockThroughTheGrid) {
  for (const char* functions : {"linear", "quadratic_bspline", "cpgimp", "b2gimp", "cpdi"}) {
    Model model(fmt::format(R"toml(
[model]
plane = "strain"
gravity = [0.0, "-10*min(t, 1)"]
[grid]
shape_functions = "{}"
{}[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [1.0, 0.5] }}
[boundary.base]
body = "b"
where.box.max = [10.0, 1e-6]
ux = "max(t - 1, 0)"
uy = 0.0
[stage.load]
count = 10
adaptive = false
[stage.carry]
count = 400
adaptive = false
)toml",
                            functions, wide_grid));
    ASSERT_TRUE(model.run()) << functions;
    const std::vector<Vec3> X = model.world->discretisation->point_origins();
    const MaterialState& m = model.material();
    double mean = 0.0, exact = 0.0, volume = 0.0;  // over the middle of the height
    for (std::size_t p = 0; p < X.size(); ++p) {
      if (std::abs(X[p].y() - 0.25) > 0.1) continue;
      mean += m.volume[p] * m.stress[p][YY];
      exact -= m.volume[p] * 1e4 * (0.5 - X[p].y());
      volume += m.volume[p];
    }
    EXPECT_NEAR(mean / exact, 1.0, 0.02) << functions;
    EXPECT_NEAR(model.step.balance().reactions.boundary[0].y(), 5000.0, 0.5) << functions;
    record({group, fmt::format("block carried through ten cells in 400 steps, {}: mean stress in the middle [Pa]", functions),
            mean / volume, fmt::format("{:.5g}", exact / volume), "2 %", "weight of what is above"});
  }
}

/// A bar of 1 m that is held at one end is let go under gravity along it: the end moves by twice rho g L^2 / (2 E) within
/// four travel times of the wave, and the support carries twice the weight. With a force that was carried from step to step
/// this was unstable with any step length.
TEST(HeldSurface, BarInMotion) {
  for (const char* method : {"mpm", "fem"})
    for (const char* functions : {"linear", "b2gimp", "cpdi"})
      for (const auto& [steps, duration] : {std::pair{1000, 0.2}, {400, 0.5}}) {
        if (std::string(method) == "fem" && std::string(functions) != "linear") continue;
        Model model(fmt::format(R"toml(
method = "{}"
[model]
plane = "strain"
gravity = [1.0, 0.0]
[grid]
shape_functions = "{}"
{}[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [1.0, 0.2] }}
mesh = {{ kind = "quads", size = 0.1, structured = true }}
[boundary.left]
body = "b"
where.box.max = [1e-6, 10.0]
ux = 0.0
uy = 0.0
[gauge.tip]
from = [1e-3, 0.1]
to = [0.999, 0.1]
[steps]
analysis = "dynamic"
adaptive = false
duration = {}
count = {}
)toml",
                                method, functions, wide_grid, duration, steps));
        double furthest = 0.0, most = 0.0;
        ASSERT_TRUE(model.run([&](const StepResult&) {
          furthest = std::max(furthest, model.gauge_end().x());
          most = std::max(most, std::abs(model.step.balance().reactions.boundary[0].x()));
        })) << method << ' ' << functions;
        EXPECT_NEAR(furthest, 1e-3, 0.05e-3) << method << ' ' << functions;
        EXPECT_NEAR(most, 400.0, 40.0) << method << ' ' << functions;
        record({group, fmt::format("bar in motion, {} {}, {} steps in {} s: most displacement of the end [mm]", method, functions, steps, duration),
                1e3 * furthest, "1", "5 %", "wave equation"});
      }
}

}  // namespace
}  // namespace berm::verify
