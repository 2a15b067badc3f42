/// Traction on a surface: resultant, and the same as a pressure where it is normal (docs/theory/boundaries.md, (6),
/// (6a)).

#include <fmt/format.h>

#include "driver.hpp"

namespace berm::verify {
namespace {

/// A block of 1 x 1 m whose top cuts cells, held below, with `load` on its top.
std::string block(const std::string& method, const std::string& load) {
  std::string text = fmt::format("method = \"{}\"\n[model]\nkinematics = \"small\"\nthickness = 0.5\n", method);
  text += "[grid]\norigin = [-0.25, 0.0]\ncell_size = 0.25\ncells = [6, 5]\n";
  text += "[material.m]\nlaw = \"linear_elastic\"\ndensity = 1.0\nyoungs_modulus = 1e6\npoisson_ratio = 0.3\n";
  text += "[body.b]\nmaterial = \"m\"\nshape.box = { min = [0.1, 0.0], max = [1.1, 1.1] }\n";
  text += "mesh = { kind = \"quads\", size = 0.25, structured = true }\n";
  text += "[boundary.base]\nwhere.box.max = [2.0, 1e-6]\nux = 0.0\nuy = 0.0\n";
  text += "[gauge.g]\nfrom = [0.5, 0.5]\nto = [0.9, 0.9]\n[steps]\ncount = 2\nadaptive = false\n";
  return text + "[pressure.top]\nbody = \"b\"\nwhere.box.min = [-1.0, 1.0999]\n" + load + "\n";
}

TEST(Traction, ANormalOneIsAPressure) {
  for (const char* method : {"mpm", "fem"}) {
    Model pressure(block(method, "value = 1000.0")), traction(block(method, "traction = [0.0, -1000.0]"));
    EXPECT_TRUE(pressure.run());
    EXPECT_TRUE(traction.run());
    const Vec3 u = pressure.gauge_end();
    EXPECT_GT(u.norm(), 1e-5);
    EXPECT_LT((traction.gauge_end() - u).norm(), 1e-12 * u.norm()) << method;
  }
}

TEST(Traction, ResultantFollowsTimeAndPlace) {
  for (const char* method : {"mpm", "fem"}) {
    // int_0.1^1.1 x dx = 0.6
    Model model(block(method, "traction = [\"1000*x*t\", \"500*t^2\"]"));
    const Balance& balance = model.step.balance();
    double worst = 0.0;
    EXPECT_TRUE(model.run([&](const StepResult&) {
      const double t = model.world->time;
      const Vec3 exact(0.5 * 600.0 * t, 0.5 * 500.0 * t * t, 0.0);
      worst = std::max(worst, (balance.pressure_force[0] - exact).norm() / exact.norm());
      // The base holds it.
      EXPECT_LT((balance.reactions.boundary[0] + balance.pressure_force[0]).norm(), 1e-7 * exact.norm());
    }));
    EXPECT_LT(worst, 1e-9) << method;
  }
}

}  // namespace
}  // namespace berm::verify
