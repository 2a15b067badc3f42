/// Slip boundaries on inclined lines of nodes: a block under its weight in a turned grid against the same one in the
/// grid along the axes.

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double width = 1.0, height = 2.0, unit_weight = 20e3, poisson = 0.3, youngs = 10e6;

struct Turn {
  double angle;
  Vec3 operator()(double x, double y) const {
    const double c = std::cos(angle), s = std::sin(angle);
    return {c * x - s * y, s * x + c * y, 0.0};
  }
};

std::string text_of(const Vec3& x) { return fmt::format("[{:.16g}, {:.16g}]", x.x(), x.y()); }

/// Between rollers on both sides and below; the right-hand one moves inwards by 1 mm.
std::string box(const std::string& method, double angle, int steps, const std::string& more = "") {
  const Turn turn{angle};
  std::string text = fmt::format("method = \"{}\"\n[model]\nplane = \"strain\"\nkinematics = \"small\"\n", method);
  text += "gravity = " + text_of(turn(0.0, -10.0)) + "\n";
  text += fmt::format("[material.m]\nlaw = \"linear_elastic\"\ndensity = {}\nyoungs_modulus = {}\npoisson_ratio = {}\n",
                      unit_weight / 10.0, youngs, poisson);
  text += fmt::format("[grid]\norigin = [0.0, 0.0]\ncell_size = 0.125\ncells = [8, 17]\nangle = {:.16g}\n",
                      angle * 180.0 / std::numbers::pi);
  text += "[body.b]\nmaterial = \"m\"\nmesh = { kind = \"triangles\", size = 0.25, order = 2 }\nshape.polygon = [";
  for (const auto& [x, y] : {std::pair(0.0, 0.0), {width, 0.0}, {width, height}, {0.0, height}})
    text += text_of(turn(x, y)) + ", ";
  text += "]\n";
  const auto side = [&](const char* name, const Vec3& at, const Vec3& normal, double un) {
    text += fmt::format("[boundary.{}]\nwhere.beyond = {{ at = {}, normal = {} }}\nnormal = {}\nun = {}\n", name,
                        text_of(at), text_of(normal), text_of(normal), un);
  };
  side("left", turn(1e-6, 0.0), turn(-1.0, 0.0), 0.0);
  side("right", turn(width - 1e-6, 0.0), turn(1.0, 0.0), -1e-3);
  side("base", turn(0.0, 1e-6), turn(0.0, -1.0), 0.0);
  return text + fmt::format("[steps]\ncount = {}\nadaptive = false\n", steps) + more;
}

void compare(const std::string& method, double degrees, int steps) {
  SCOPED_TRACE(fmt::format("{} {}", method, degrees));
  const double angle = degrees * std::numbers::pi / 180.0;
  const Turn turn{angle};
  Model model(box(method, angle, steps));
  ASSERT_TRUE(model.run());
  // Side pressure q from the weight above and from the squeeze e_x = -1 mm; s_y = -gamma (H - y):
  // e_x = (1 + nu)/E ((1 - nu) s_x - nu s_y).
  const double k = (1.0 + poisson) / youngs, ex = -1e-3 / width;
  const Discretisation& d = *model.world->discretisation;
  const MaterialState& m = model.material();
  const std::vector<Vec3> X = d.point_origins(), u = d.point_displacements();
  double error_u = 0.0, error_s = 0.0;
  const double largest = unit_weight * height;
  for (std::size_t i = 0; i < X.size(); ++i) {
    const Vec3 x = Turn{-angle}(X[i].x(), X[i].y());
    const double sy = -unit_weight * (height - x.y()), sx = (ex / k + poisson * sy) / (1.0 - poisson);
    // e_y = k ((1 - nu) s_y - nu s_x), integrated from the base.
    const double constant = -poisson * ex / (1.0 - poisson);
    const double slope = k * ((1.0 - poisson) - poisson * poisson / (1.0 - poisson));
    const double uy = constant * x.y() - slope * unit_weight * (height * x.y() - 0.5 * x.y() * x.y());
    error_u = std::max(error_u, (u[i] - turn(ex * x.x(), uy)).norm() / 1e-3);
    if (method == "mpm") continue;  // piecewise constant gradients
    Mat3 exact = Mat3::Zero();
    const Mat3 R = (Mat3() << turn(1, 0), turn(0, 1), Vec3::UnitZ()).finished();
    exact(0, 0) = sx, exact(1, 1) = sy, exact(2, 2) = poisson * (sx + sy);
    const Mat3 s = response_detail::tensor(m.stress[i]);
    error_s = std::max(error_s, (s - R * exact * R.transpose()).norm() / largest);
  }
  const double tolerance = method == "fem" ? 1e-5 : 0.01;
  EXPECT_LT(error_u, tolerance);
  EXPECT_LT(error_s, 1e-5);
  // Reactions: the base carries the weight, the sides push with the integral of s_x.
  const auto& reactions = model.step.balance().reactions.boundary;
  const double weight = unit_weight * width * height;
  const double push = -(ex / k * height - poisson * unit_weight * height * height / 2.0) / (1.0 - poisson);
  EXPECT_LT((reactions[2] - turn(0.0, weight)).norm() / weight, 1e-6);
  EXPECT_LT((reactions[0] - turn(push, 0.0)).norm() / push, method == "fem" ? 1e-5 : 0.01);
  EXPECT_LT((reactions[0] + reactions[1]).norm() / push, 1e-6);
  // Work of the moved side and of gravity is stored (one step: the trapezoid is exact).
  EXPECT_LT(relative(model.step.balance().external_work, model.material().stored_energy()), 1e-4);
  record({"Inclined slip boundary",
          fmt::format("{}, turned by {} degrees, {} steps: displacement", method, degrees, steps), error_u, "0",
          fmt::format("{}", tolerance), "one-dimensional compression"});
}

TEST(InclinedBoundary, BlockUnderItsWeightFem) {
  compare("fem", 30.0, 1);
  compare("fem", -52.0, 10);
}
TEST(InclinedBoundary, BlockUnderItsWeightMpm) { compare("mpm", 30.0, 10); }

/// Point by point as in the grid along the axes.
TEST(InclinedBoundary, TurnedGridEqualsStraightOne) {
  Model straight(box("mpm", 0.0, 4)), turned(box("mpm", 0.6, 4));
  ASSERT_TRUE(straight.run());
  ASSERT_TRUE(turned.run());
  const std::vector<Vec3> a = straight.world->discretisation->point_displacements(),
                          b = turned.world->discretisation->point_displacements();
  ASSERT_EQ(a.size(), b.size());
  double worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i)
    worst = std::max(worst, (b[i] - Turn{0.6}(a[i].x(), a[i].y())).norm() / 1e-3);
  EXPECT_LT(worst, 1e-6);
  record({"Inclined slip boundary", "mpm, grid turned by 0.6 rad against the straight one: displacement", worst, "0",
          "1e-6", "the same grid along the axes"});
  // Exact supports of the axes' own nodes instead of penalties.
  const std::string fixed = box("mpm", 0.0, 4);
  std::string exact = fixed.substr(0, fixed.find("[boundary.left]"));
  exact +=
      "[boundary.left]\nwhere.box.max = [1e-6, 9.0]\nux = 0.0\n[boundary.right]\nwhere.box.min = [0.999999, 0.0]\n"
      "ux = -1e-3\n[boundary.base]\nwhere.box.max = [9.0, 1e-6]\nuy = 0.0\n[steps]\ncount = 4\nadaptive = false\n";
  Model held(exact);
  ASSERT_TRUE(held.run());
  const std::vector<Vec3> c = held.world->discretisation->point_displacements();
  worst = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) worst = std::max(worst, (a[i] - c[i]).norm() / 1e-3);
  EXPECT_LT(worst, 1e-5);
  record({"Inclined slip boundary", "mpm, penalty against prescribed nodes: displacement", worst, "0", "1e-5",
          "prescribed components"});
}

}  // namespace
}  // namespace berm::verify
