/// Smooth rigid wall of 4 m before a cohesionless backfill that has its weight first and then yields: earth pressure at
/// rest, active and passive (V28).

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double height = 4.0, unit_weight = 18e3, gravity = 9.81, poisson = 0.3;

/// Weight until t = 1, then the wall at x = 0 moves by `way` until t = 2, away from the soil if negative. The base is
/// smooth, so that the state is Rankine's everywhere. rigid: the wall is a rigid body that cuts the cells, else nodes.
std::string wall(const std::string& method, double way, bool rigid) {
  const double h = 0.5, length = rigid ? 14.2 : 14.0;
  std::string text = fmt::format("method = \"{}\"\n[model]\nplane = \"strain\"\nkinematics = \"small\"\n", method);
  text += fmt::format("gravity = [0.0, \"-{}*min(t,1)\"]\n", gravity);
  text += fmt::format("[material.sand]\nlaw = \"mohr_coulomb\"\ndensity = {:.12g}\nyoungs_modulus = 50e6\n",
                      unit_weight / gravity);
  text += fmt::format("poisson_ratio = {}\ncohesion = 0.0\nfriction_angle = 30.0\n", poisson);
  text += fmt::format("[grid]\norigin = [{}, 0.0]\ncell_size = {}\ncells = [29, 9]\n", length - 29 * h, h);
  text += fmt::format("[body.soil]\nmaterial = \"sand\"\nshape.box = {{ min = [0.0, 0.0], max = [{}, {}] }}\n", length,
                      height);
  text += fmt::format("mesh = {{ kind = \"quads\", size = {}, structured = true }}\n", h);
  if (rigid) {
    text += "[body.wall]\nrigid = true\nshape.box = { min = [-0.3, -0.5], max = [0.0, 5.0] }\n";
    text += fmt::format("displacement = [\"{}*max(t-1,0)\", 0.0]\n", way);
    text += "[contact.wall]\nbody = \"soil\"\nrigid = \"wall\"\nkind = \"frictionless\"\n";
  } else {
    text += fmt::format("[boundary.wall]\nwhere.box = {{ max = [1e-6, 100.0] }}\nux = \"{}*max(t-1,0)\"\n", way);
  }
  text += fmt::format("[boundary.far]\nwhere.box = {{ min = [{}, 0.0] }}\nux = 0.0\n", length - 1e-6);
  text += "[boundary.base]\nwhere.box = { max = [100.0, 1e-6] }\nuy = 0.0\n";
  return text + "[steps]\nduration = 2.0\ncount = 40\n";
}

/// Force of the wall on the soil at the end [N/m], after checking the pressure at rest.
double earth_pressure(const std::string& method, double way, bool rigid) {
  Model model(wall(method, way, rigid));
  const auto force = [&] {
    const Reactions& r = model.step.balance().reactions;
    return rigid ? r.rigid[1].x() : r.boundary[0].x();
  };
  double at_rest = 0.0;
  const bool done = model.run([&](const StepResult&) {
    if (model.world->time <= 1.0 + 1e-9) at_rest = force();
  });
  EXPECT_TRUE(done);
  const double K0 = poisson / (1.0 - poisson);
  EXPECT_LT(relative(at_rest, 0.5 * K0 * unit_weight * height * height), 0.005);
  return force();
}

void compare(const std::string& method, bool rigid, double way, double exact) {
  const double force = earth_pressure(method, way, rigid);
  EXPECT_LT(relative(force, exact), 0.03);
  record({"Rankine's earth pressure (V28)",
          fmt::format("{}, {}: {} force on the wall [N/m]", method,
                      rigid ? "rigid body that cuts cells" : "moved nodes", way < 0.0 ? "active" : "passive"),
          force, fmt::format("{:.4g}", exact), "3 %", "Rankine, K gamma H^2/2"});
}

TEST(Rankine, ActiveFem) { compare("fem", false, -0.02, 48.0e3); }
TEST(Rankine, ActiveMpm) { compare("mpm", false, -0.02, 48.0e3); }
TEST(Rankine, ActiveMpmBeforeARigidBody) { compare("mpm", true, -0.02, 48.0e3); }
TEST(Rankine, PassiveFem) { compare("fem", false, 0.15, 432.0e3); }
TEST(Rankine, PassiveMpm) { compare("mpm", false, 0.15, 432.0e3); }
TEST(Rankine, PassiveMpmBeforeARigidBody) { compare("mpm", true, 0.15, 432.0e3); }

}  // namespace
}  // namespace berm::verify
