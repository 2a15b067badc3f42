/// Bodies that slide on, rest on and hit each other: V32, V34, and two blocks on top of each other.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "driver.hpp"
#include "transfer/mpm.hpp"

namespace berm::verify {
namespace {

const MpmDiscretisation& mpm_of(const Model& model) {
  return dynamic_cast<const MpmDiscretisation&>(*model.world->discretisation);
}

struct Motion {
  double mass = 0.0;
  Vec3 centre = Vec3::Zero(), velocity = Vec3::Zero();
};

/// Of a body, or of all.
Motion motion_of(const Model& model, int body = -1) {
  const MpmDiscretisation& d = mpm_of(model);
  const auto x = d.point_positions(), v = d.point_velocities();
  Motion m;
  for (const Slice& slice : d.material.slices)
    for (int p = slice.begin; p < slice.end; ++p) {
      if (body >= 0 && slice.body != body) continue;
      m.mass += d.point_masses()[p];
      m.centre += d.point_masses()[p] * x[p];
      m.velocity += d.point_masses()[p] * v[p];
    }
  m.centre /= m.mass;
  m.velocity /= m.mass;
  return m;
}

// ---- V32: a block on an incline

/// Gravity first while the block is held in the direction of the slope, then it is let go. `angle` of the slope is put
/// into gravity; the plane of contact has its own angle against the grid.
std::string block_on_incline(double slope, double friction, double turn, double duration, int steps) {
  const double s = std::sin(slope), c = std::cos(slope), ct = std::cos(turn), st = std::sin(turn);
  // Gravity in the axes of the plane is (s, -c) g; the plane is turned counter-clockwise against the grid.
  const double gx = 9.81 * (ct * s + st * c), gy = 9.81 * (st * s - ct * c);
  const auto at = [&](double x, double y) {
    return fmt::format("[{:.15g}, {:.15g}]", ct * x - st * y, st * x + ct * y);
  };
  return fmt::format(R"toml(
[model]
gravity = ["{0:.15g}*min(t/0.1, 1)", "{1:.15g}*min(t/0.1, 1)"]
[grid]
origin = [-2.0, -2.0]
cell_size = 0.25
cells = [28, 28]
[material.block]
law = "linear_elastic"
youngs_modulus = 1e7
poisson_ratio = 0.3
density = 1000
[body.block]
material = "block"
shape.polygon = [{2}, {3}, {4}, {5}]
[body.plane]
rigid = true
shape.polygon = [{6}, {7}, {8}, {9}]
[contact.stuck]
body = "block"
rigid = "plane"
kind = "tie"
stiffness = 100
stages = ["weight"]
[contact.base]
body = "block"
rigid = "plane"
kind = "friction"
friction = {10}
stiffness = 100
stages = ["slide"]
[stage.weight]
duration = 0.1
count = 4
[stage.slide]
analysis = "dynamic"
duration = {11}
count = {12}
[dynamics]
integrator = "bossak"
transfer = "blend"
)toml",
                     gx, gy, at(0.0, 0.0), at(1.0, 0.0), at(1.0, 1.0), at(0.0, 1.0), at(-1.0, -0.5), at(3.5, -0.5),
                     at(3.5, 0.0), at(-1.0, 0.0), friction, duration, steps);
}

/// Way along the slope after `duration` of sliding.
double way(double slope, double friction, double turn, double duration) {
  Model model(block_on_incline(slope, friction, turn, duration, static_cast<int>(200 * duration)));
  EXPECT_TRUE(model.run_stage());
  const Vec3 start = motion_of(model).centre;
  ++model.world->stage;
  model.step.begin_stage();
  EXPECT_TRUE(model.run_stage());
  return (motion_of(model).centre - start).dot(Vec3(std::cos(turn), std::sin(turn), 0.0));
}

TEST(BlockOnIncline, SlidesAndSticksAsCoulombSays) {
  constexpr double degree = std::numbers::pi / 180.0;
  for (const auto& [turn, name] :
       {std::pair{0.0, "plane along the grid"}, std::pair{30.0, "plane at 30 deg to the grid"}}) {
    for (const auto& [slope, friction] : {std::pair{30.0, 0.3}, std::pair{45.0, 0.3}}) {
      const double exact = 0.5 * 9.81 * (std::sin(slope * degree) - friction * std::cos(slope * degree));
      const double reached = way(slope * degree, friction, turn * degree, 1.0);
      EXPECT_NEAR(reached, exact, 0.01 * exact) << name << ", slope " << slope;
      record({"Block on an incline (V32)",
              fmt::format("way after 1 s, slope {} deg, mu = {}, {} [m]", slope, friction, name), reached,
              fmt::format("{:.5f}", exact), "1 %", "g (sin - mu cos) t^2 / 2"});
    }
    const double drift = way(30.0 * degree, 0.6, turn * degree, 1.0);
    // The block was tied before: its elastic shear under its own weight is there already.
    EXPECT_LT(std::abs(drift), 1e-2) << name;
    record({"Block on an incline (V32)", fmt::format("drift in 1 s, slope 30 deg, mu = 0.6, {} [m]", name), drift, "0",
            "reported", "sticks: tan 30 deg < 0.6"});
  }
}

// ---- two blocks

const std::string two_blocks = R"toml(
[model]
gravity = [0.0, -10.0]
kinematics = "finite"
[grid]
origin = [0.0, 0.0]
cell_size = 0.25
cells = [12, 12]
[material.soft]
law = "linear_elastic"
youngs_modulus = 1e7
poisson_ratio = 0.0
density = 1000
[body.lower]
material = "soft"
shape.box = { min = [0.0, 0.0], max = [3.0, 1.0] }
[body.upper]
material = "soft"
shape.box = { min = [1.0, 1.0], max = [2.0, 2.0] }
acceleration = ["t < 1 ? 0 : 2*(t - 1)", 0.0]
[contact.between]
body = "upper"
other = "lower"
kind = "friction"
friction = 0.5
[boundary.base]
where.box.max = [3.0, 1e-6]
ux = 0.0
uy = 0.0
[stage.weight]
count = 4
)toml";

/// The pressure between them carries the upper one.
TEST(TwoBlocks, RestOnEachOther) {
  Model model(two_blocks);
  ASSERT_TRUE(model.run());
  double force = 0.0;
  const std::vector<double> rows = model.world->boundary->grid_contact().rows();
  for (std::size_t k = 0; k < rows.size(); k += 5) force += rows[k + 3];
  // The lower body is the second one of the contact: fields are numbered as contacts name their bodies.
  EXPECT_NEAR(std::abs(force), 1000.0 * 10.0, 1e-3 * 1e4);
  record({"Contact on the grid", "force between two blocks, weight of the upper one 10 kN, quasi-static [N]",
          std::abs(force), "10000", "0.1 %", "equilibrium"});
}

/// A force of its own on the upper block: it sticks until mu of its weight, then slides.
TEST(TwoBlocks, SlideAtTheAngleOfFriction) {
  Model model(two_blocks + R"toml(
[stage.push]
analysis = "dynamic"
duration = 3.2
count = 320
[dynamics]
integrator = "bossak"
transfer = "blend"
)toml");
  double at_slip = 0.0, start = 0.0;
  ASSERT_TRUE(model.run([&](const StepResult&) {
    if (model.world->time <= 1.0 + 1e-9) start = motion_of(model, 1).centre.x();
    if (at_slip == 0.0 && motion_of(model, 1).centre.x() - start > 0.02) at_slip = model.world->time;
  }));
  // It slips at a = 5 m/s2 (t = 3.5 s); then x = (t - 3.5)^3 / 3: 0.02 m are reached 0.39 s later.
  const double expected = 3.5 + std::cbrt(3.0 * 0.02);
  EXPECT_NEAR(at_slip, expected, 0.01 * expected);
  record({"Contact on the grid", "time at which a pushed block has slid 2 cm, mu = 0.5 [s]", at_slip,
          fmt::format("{:.3f}", expected), "1 %", "a = mu g, then a - mu g"});
}

// ---- a wedge that slides on another between smooth planes

std::string wedges(const std::string& grid, const std::string& shape_of_lower, const std::string& shape_of_upper) {
  return grid + R"toml(
[material.rock]
law = "linear_elastic"
youngs_modulus = "1 MPa"
poisson_ratio = 0.2
density = 1000
[body.lower]
material = "rock"
)toml" + shape_of_lower +
         R"toml(
[body.upper]
material = "rock"
)toml" + shape_of_upper +
         R"toml(
[contact.between]
body = "upper"
other = "lower"
kind = "friction"
friction = 0.1
[steps]
analysis = "dynamic"
duration = 0.4
count = 40
)toml";
}

/// Planes of symmetry end both bodies, but are no surface of one against the other.
TEST(Wedges, SlideBetweenSmoothPlanesAsInThePlane) {
  const std::string lower = "[[0.0, 0.0], [2.0, 0.0], [2.0, 0.4], [0.0, 0.9]]",
                    upper = "[[0.3, 0.825], [1.2, 0.6], [1.2, 1.3], [0.3, 1.3]]";
  Model plane(wedges(R"toml(
model.plane = "strain"
model.gravity = [0.0, -10.0]
grid = { origin = [-0.25, 0.0], cell_size = 0.25, cells = [10, 6] }
boundary.base = { where.box.max = [10.0, 1e-6], ux = 0.0, uy = 0.0 })toml",
                     "shape.polygon = " + lower, "shape.polygon = " + upper));
  Model solid(wedges(R"toml(
model.dimension = 3
model.gravity = [0.0, -10.0, 0.0]
grid = { kind = "hexahedra", origin = [-0.25, 0.0, 0.0], cell_size = 0.25, cells = [10, 6, 2] }
boundary.base = { where.box.max = [10.0, 1e-6, 10.0], ux = 0.0, uy = 0.0 }
boundary.front = { where.box.max = [10.0, 10.0, 1e-6], uz = 0.0 }
boundary.back = { where.box.min = [-10.0, -10.0, 0.499999], uz = 0.0 })toml",
                     "shape.extrusion = { polygon = " + lower + ", from = 0.0, to = 0.5 }",
                     "shape.extrusion = { polygon = " + upper + ", from = 0.0, to = 0.5 }"));
  const Vec3 start = motion_of(plane, 1).centre;
  ASSERT_TRUE(plane.run());
  ASSERT_TRUE(solid.run());
  const Vec3 a = motion_of(plane, 1).centre - start, b = motion_of(solid, 1).centre - Vec3(start.x(), start.y(), 0.25);
  // The interface lies across the grid: tan = 1/4, a = g (sin - mu cos).
  const double slope = std::atan(0.25), way = 0.5 * 10.0 * (std::sin(slope) - 0.1 * std::cos(slope)) * 0.4 * 0.4;
  EXPECT_NEAR(a.x(), way * std::cos(slope), 0.06 * way);
  record({"Contact on the grid",
          "way of a wedge down another of slope 1 : 4 across the grid, mu = 0.1, after 0.4 s [m]", a.x(),
          fmt::format("{:.4f}", way * std::cos(slope)), "6 %", "g (sin - mu cos) t^2 / 2, rigid"});
  // Surface points stand in other places in space (three a cell instead of ten), and gaps are measured from them.
  EXPECT_LT((a - b).norm(), 1e-2 * a.norm());
  record({"Contact on the grid",
          "wedge that slides between smooth planes: distance from that of the plane model, over its way",
          (a - b).norm() / a.norm(), "0", "1e-2", "plane strain"});
}

// ---- V34: two discs collide

TEST(CollidingDiscs, KeepMomentumAndPart) {
  Model model(R"toml(
[grid]
origin = [0.0, 0.0]
cell_size = 0.05
cells = [20, 20]
[material.soft]
law = "linear_elastic"
youngs_modulus = 1000
poisson_ratio = 0.3
density = 1000
[body.left]
material = "soft"
shape.disc = { centre = [0.2, 0.2], radius = 0.2 }
velocity = [0.1, 0.1]
[body.right]
material = "soft"
shape.disc = { centre = [0.8, 0.8], radius = 0.2 }
velocity = [-0.1, -0.1]
[contact.discs]
body = "left"
other = "right"
kind = "frictionless"
[steps]
analysis = "dynamic"
duration = 3.5
count = 700
)toml");
  const double start = model.step.balance().kinetic;
  double touch = 0.0, sum = 0.0;
  ASSERT_TRUE(model.run([&](const StepResult&) {
    if (touch == 0.0 && model.material().stored_energy() > 1e-3 * start) touch = model.world->time;
    sum = std::max(sum, motion_of(model).velocity.norm());
  }));
  const Motion left = motion_of(model, 0), right = motion_of(model, 1);
  const double end = model.step.balance().kinetic + model.material().stored_energy();
  EXPECT_NEAR(start, 2.51327, 0.01 * 2.51327);
  EXPECT_LT(sum, 1e-10);
  EXPECT_LT(left.velocity.x(), -0.05);
  EXPECT_GT(right.velocity.x(), 0.05);
  EXPECT_LT(end / start, 1.0 + 1e-3);
  record({"Colliding discs (V34)", "kinetic energy at the start [J]", start, "2.51327", "1 %", "circles"});
  record({"Colliding discs (V34)", "largest velocity of the common centre [m/s]", sum, "0", "1e-10", "momentum"});
  record({"Colliding discs (V34)", "first touch [s]", touch, "1.58579", "reported",
          "of the circles; on one grid without fields 1.2 to 1.4"});
  record({"Colliding discs (V34)", "energy at 3.5 s over that at the start", end / start, "1", "reported",
          "elastic; the shock sets the discs vibrating"});
}

}  // namespace
}  // namespace berm::verify
