/// What begins, ends and comes back at the change of stages, and how motion begins.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

/// Mean displacement of all points.
Vec3 mean_displacement(const Model& model) {
  Vec3 sum = Vec3::Zero();
  const auto u = model.world->discretisation->point_displacements();
  for (const Vec3& v : u) sum += v;
  return sum / double(u.size());
}

void next_stage(Model& model) {
  ++model.world->stage;
  model.step.begin_stage();
}

const std::string block = R"toml(
[grid]
origin = [-0.5, -0.5]
cell_size = 0.25
cells = [8, 8]
[material.soft]
law = "linear_elastic"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000
[body.block]
material = "soft"
shape = { box = { min = [0.0, 0.0], max = [0.5, 0.5] } }
)toml";

/// A support that has gone does no work, wherever its motion would lead.
TEST(Stages, ASupportThatHasGoneDoesNoWork) {
  const std::string base = R"toml(
[boundary.base]
where.box = { min = [-1.0, -0.001], max = [2.0, 0.001] }
ux = 0.0
uy = 0.0
[stage.press]
count = 2
[stage.free]
count = 2
)toml";
  const std::string node = R"toml(
[boundary.top]
where.box = { min = [-1.0, 0.499], max = [2.0, 0.501] }
uy = "-0.01*t"
stages = ["press"]
)toml";
  const std::string rigid = R"toml(
[body.plate]
rigid = true
shape = { box = { min = [-0.25, 0.5], max = [0.75, 0.7] } }
displacement = [0.0, "-0.01*t"]
[contact.top]
body = "block"
rigid = "plate"
kind = "frictionless"
stages = ["press"]
)toml";
  for (const std::string& top : {node, rigid}) {
    Model model(block + top + base);
    ASSERT_TRUE(model.run_stage());
    const double work = model.step.balance().external_work;
    ASSERT_GT(work, 0.0);
    next_stage(model);
    ASSERT_TRUE(model.run_stage());
    EXPECT_NEAR(model.step.balance().external_work, work, 1e-9 * work) << top;
  }
}

/// Like a boundary, a pin holds its place where it is when it begins to act.
TEST(Stages, APinHoldsWhereItBegins) {
  Model model(block + R"toml(
[boundary.push]
where.box = { min = [-1.0, -1.0], max = [2.0, 2.0] }
ux = "0.1*t"
uy = 0.0
stages = ["push"]
[pin.left]
body = "block"
at = [0.1, 0.1]
fix = "xy"
stages = ["hold"]
[pin.right]
body = "block"
at = [0.4, 0.1]
fix = "y"
stages = ["hold"]
[stage.push]
count = 4
[stage.hold]
count = 2
)toml");
  ASSERT_TRUE(model.run_stage());
  EXPECT_NEAR(mean_displacement(model).x(), 0.1, 1e-12);
  next_stage(model);
  ASSERT_TRUE(model.run_stage());
  EXPECT_NEAR(mean_displacement(model).x(), 0.1, 1e-9);
}

/// What was tied in an earlier stage is tied anew without a force.
TEST(Stages, ATieBeginsAnewWithoutForce) {
  Model model(block + R"toml(
[body.floor]
rigid = true
shape = { box = { min = [-0.25, -0.4], max = [0.75, 0.0] } }
[contact.floor]
body = "block"
rigid = "floor"
kind = "tie"
stiffness = 10.0
stages = ["sheared", "tied"]
[pressure.shear]
body = "block"
where.box = { min = [-1.0, 0.499], max = [2.0, 0.501] }
traction = [1000.0, 0.0]
stages = ["sheared"]
[boundary.all]
where.box = { min = [-1.0, -1.0], max = [2.0, 2.0] }
ux = 0.0
uy = 0.0
stages = ["held"]
[stage.sheared]
count = 2
[stage.held]
count = 1
[stage.tied]
count = 1
)toml");
  // The body is free of load in the last stage; its elastic strain goes, but the floor must not push it back.
  ASSERT_TRUE(model.run());
  const auto& rigid = model.step.balance().reactions.rigid;
  EXPECT_LT(rigid[1].norm(), 1e-3);
  // At the floor it stays where it slipped to: q h / (alpha E) of [boundaries (5)], q = 1 kPa, h = 0.25 m.
  const auto u = model.world->discretisation->point_displacements();
  const auto X = model.world->discretisation->point_origins();
  double lowest = 0.0;
  int n = 0;
  for (std::size_t p = 0; p < u.size(); ++p)
    if (X[p].y() < 0.1) lowest += u[p].x(), ++n;
  EXPECT_GT(lowest / n, 0.5 * 1e3 * 0.25 / (10.0 * 1e6));
}

/// Forces between bodies are forgotten when their contact ends.
TEST(Stages, ContactBetweenBodiesForgetsItsForces) {
  Model model(R"toml(
[model]
gravity = [0.0, -9.81]
[grid]
origin = [-0.5, -0.5]
cell_size = 0.25
cells = [8, 8]
[material.soft]
law = "linear_elastic"
youngs_modulus = 1e6
poisson_ratio = 0.3
density = 1000
[body.lower]
material = "soft"
shape = { box = { min = [0.0, 0.0], max = [0.5, 0.5] } }
[body.upper]
material = "soft"
shape = { box = { min = [0.0, 0.5], max = [0.5, 1.0] } }
[contact.joint]
body = "lower"
other = "upper"
kind = "friction"
friction = 0.5
stages = ["laid"]
[boundary.base]
where.box = { min = [-1.0, -0.001], max = [2.0, 0.001] }
ux = 0.0
uy = 0.0
[boundary.side]
where.box = { min = [-1.0, 0.0], max = [2.0, 1.6] }
ux = 0.0
[boundary.all]
where.box = { min = [-1.0, 0.5], max = [2.0, 2.0] }
uy = 0.0
stages = ["held"]
[stage.laid]
count = 4
[stage.held]
count = 1
)toml");
  ASSERT_TRUE(model.run_stage());
  EXPECT_FALSE(model.world->boundary->grid_contact().rows().empty());
  next_stage(model);
  ASSERT_TRUE(model.run_stage());
  EXPECT_TRUE(model.world->boundary->grid_contact().rows().empty());
}

/// A block in equilibrium under its weight stays at rest when the analysis becomes a dynamic one, on nodes that are held and
/// on a surface that is.
TEST(Motion, BeginsAtRest) {
  for (const char* kinematics : {"small", "finite"})
    for (const char* body : {"", "body = \"b\"\n"})
      for (const char* transfer : {"flip", "blend", "apic"}) {
        Model model(fmt::format(R"toml(
[model]
plane = "strain"
kinematics = "{}"
gravity = [0.0, "-10*min(t, 1)"]
[grid]
origin = [-0.5, -0.5]
cell_size = 0.1
cells = [20, 20]
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e7
poisson_ratio = 0.0
[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [0.5, 1.0] }}
[boundary.base]
{}where.box.max = [10.0, 1e-6]
ux = 0.0
uy = 0.0
[stage.load]
count = 4
adaptive = false
[stage.move]
analysis = "dynamic"
count = 50
duration = 0.05
adaptive = false
dynamics.transfer = "{}"
)toml",
                                kinematics, body, transfer));
        double kinetic = 0.0, off = 0.0;
        ASSERT_TRUE(model.run([&](const StepResult&) {
          if (model.world->time <= 1.0) return;
          kinetic = std::max(kinetic, model.step.balance().kinetic);
          off = std::max(off, std::abs(model.step.balance().reactions.boundary[0].y() - 5000.0));
        }));
        EXPECT_LT(kinetic, 1e-6) << kinematics << ' ' << body << transfer;  // of 0.83 J of elastic energy
        EXPECT_LT(off, 10.0) << kinematics << ' ' << body << transfer;
      }
}

/// v = v0 exp(-a_R t): damping acts from the first instant.   [dynamics (10), (14)]
TEST(Motion, DampingActsFromTheStart) {
  Model model(block + R"toml(
velocity = [0.1, 0.0]
[steps]
analysis = "dynamic"
count = 20
adaptive = false
[dynamics]
rayleigh_mass = 2.0
)toml");
  ASSERT_TRUE(model.run());
  Vec3 v = Vec3::Zero();
  const auto all = model.world->discretisation->point_velocities();
  for (const Vec3& one : all) v += one / double(all.size());
  // The rule of the trapezoid: relative error a_R^3 t dt^2 / 12 = 0.17 %.
  const double off = relative(v.x(), 0.1 * std::exp(-2.0));
  EXPECT_LT(off, 0.002);
  record({"Damping of free motion", "velocity after 1 s, rayleigh_mass = 2 / s", v.x(),
          fmt::format("{:.6g}", 0.1 * std::exp(-2.0)), "0.2 %", "v = v0 exp(-a t)"});
}

/// A layer of viscous fluid between two walls whose shear flow dies away: v = V sin(pi y / H) exp(-nu pi^2 t / H^2).
class ShearFlow : public testing::TestWithParam<const char*> {};

TEST_P(ShearFlow, DiesAwayByViscosityAlone) {
  std::string text = R"toml(
[model]
plane = "strain"
[grid]
origin = [-0.1, 0.0]
cell_size = 0.05
cells = [8, 20]
[material.oil]
law = "newtonian"
bulk_modulus = 1e5
viscosity = 10.0
density = 1000
[body.layer]
material = "oil"
shape = { box = { min = [0.0, 0.0], max = [0.2, 1.0] } }
velocity = ["1e-4*sin(3.14159265358979*y)", 0.0]
[boundary.level]
where.box = { min = [-1.0, -0.001], max = [2.0, 1.001] }
uy = 0.0
[boundary.bottom]
where.box = { min = [-1.0, -0.001], max = [2.0, 0.001] }
ux = 0.0
[boundary.top]
where.box = { min = [-1.0, 0.999], max = [2.0, 1.001] }
ux = 0.0
[steps]
analysis = "dynamic"
duration = 10.0
count = 40
adaptive = false
)toml";
  Model model(text + "[dynamics]\n" + GetParam() + "\n");
  const auto middle = [&] {
    double sum = 0.0;
    const auto v = model.world->discretisation->point_velocities();
    const auto X = model.world->discretisation->point_origins();
    for (std::size_t p = 0; p < v.size(); ++p) sum += v[p].x() * std::sin(std::numbers::pi * X[p].y());
    return sum;
  };
  const double before = middle();
  ASSERT_TRUE(model.run());
  const double rate = -std::log(middle() / before) / 10.0, exact = 0.01 * std::numbers::pi * std::numbers::pi;
  // Twenty cells a half wave: (k h)^2 / 12 = 0.2 % of the lumped mass, as much of the smoothed acceleration. Rayleigh's
  // damping of a mode that dies away without vibrating is of the order b_R times its rate, 0.2 %.
  // A viscous stress is that of the mean rate of its step; Newmark's mean of two of them lags by half a step, 1.2 % here.
  EXPECT_LT(relative(rate, exact), 0.02);
  std::string name = GetParam();
  std::replace(name.begin(), name.end(), '\n', ',');  // a row of a table
  record({"Viscous shear flow", "rate of decay, " + name + " [1/s]", rate, fmt::format("{:.6g}", exact),
          "2 %", "nu pi^2 / H^2"});
}

INSTANTIATE_TEST_SUITE_P(Integrators, ShearFlow,
                         testing::Values("integrator = \"newmark\"", "integrator = \"hht\"\nalpha = -0.3",
                                         "integrator = \"bossak\"\nalpha = -0.3", "rayleigh_stiffness = 0.02"));

}  // namespace
}  // namespace berm::verify
