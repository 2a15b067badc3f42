/// Bodies too soft for their own weight, or for a pressure.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "bc/case_lookup.hpp"
#include "sim/preflight.hpp"

namespace berm {
namespace {

/// From the lowest to the highest place [m].
double height_along(const Vec3& up, const std::vector<Vec3>& places) {
  double low = infinity, high = -infinity;
  for (const Vec3& x : places) low = std::min(low, up.dot(x)), high = std::max(high, up.dot(x));
  return places.empty() ? 0.0 : high - low;
}

}  // namespace

void warn_of_soft_bodies(World& w, const BuiltBodies& built) {
  constexpr double flat = 0.5;  // strain of what stands on the ground
  const Case& c = w.spec;
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    const double stiffness = stiffness_of(c, static_cast<int>(b));
    const Material* material = material_of(c, static_cast<int>(b));
    if (!material || !(stiffness > 0.0)) continue;
    double worst = 0.0, height = 0.0;
    for (const Stage& stage : c.stages) {
      const Vec3 weight = material->density * c.gravity.at(stage.end());
      if (weight.norm() <= worst) continue;
      worst = weight.norm();
      height = height_along(weight / worst, built.places[b]);
    }
    if (worst * height > flat * stiffness)
      w.warnings.push_back(
          fmt::format("[material.{}]: under its own weight body \"{}\", {:.3g} m high, would be compressed by {:.2g} of its height: its stiffness is {:.3g} Pa. Is "
                      "its unit right (\"30 GPa\", \"50 MPa\")?",
                      material->name, c.bodies[b].name, height, worst * height / stiffness, stiffness));
  }
  for (const Pressure& p : c.pressures) {
    const double stiffness = stiffness_of(c, body_index(c, p.body));
    if (p.value.depends_on_place() || !(stiffness > 0.0)) continue;
    double most = 0.0;
    for (const Stage& stage : c.stages)
      if (acts_in(p.stages, stage.name)) most = std::max(most, std::abs(p.value.at(stage.end())));
    if (most > flat * stiffness)
      w.warnings.push_back(fmt::format("[pressure.{}]: {:.3g} Pa on a body of a stiffness of {:.3g} Pa: is its unit right?", p.name, most, stiffness));
  }
}

}  // namespace berm
