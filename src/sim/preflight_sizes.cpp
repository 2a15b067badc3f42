/// What is out of proportion: weights and pressures to a stiffness, motions to the bodies, bodies to the cells.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>

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

constexpr double flat = 0.5;  ///< strain of what stands on the ground

void warn_of_weights(World& w, const BuiltBodies& built) {
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
}

void warn_of_pressures(World& w) {
  const Case& c = w.spec;
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

/// Of supports and rigid bodies in quasi-static stages: a body is pressed to nothing, or drawn to four times its length.
void warn_of_motions(World& w, double size) {
  constexpr double most = 3.0;
  const Case& c = w.spec;
  const auto farthest = [&](const TimeFunction& u, const Stages& stages) {
    double far = 0.0;
    for (const Stage& stage : c.stages)
      if (stage.steps.analysis == Analysis::quasi_static && acts_in(stages, stage.name) && !u.depends_on_place()) far = std::max(far, std::abs(u.at(stage.end())));
    return far;
  };
  const auto tell = [&](const std::string& what, double far) {
    if (far > most * size) w.warnings.push_back(fmt::format("[{}] moves by {:.4g} m, {:.2g} times as far as all bodies are long: did you mean mm?", what, far, far / size));
  };
  for (const NodeBoundary& b : c.boundaries) {
    double far = farthest(b.un, b.stages);
    for (const std::optional<TimeFunction>& u : b.u)
      if (u) far = std::max(far, farthest(*u, b.stages));
    tell("boundary." + b.name, far);
  }
  for (const Body& b : c.bodies) {
    double far = 0.0;
    for (const TimeFunction& u : b.displacement.component) far = std::max(far, farthest(u, {}));
    tell("body." + b.name, far);
  }
}

/// Points of a mesh file that leave cells inside the body empty.
void warn_of_sparse_points(World& w, const BuiltBodies& built) {
  const double cell = w.discretisation->cell_size();
  for (std::size_t b = 0; b < w.spec.bodies.size(); ++b) {
    const Body& body = w.spec.bodies[b];
    if (body.rigid || body.shape || body.mesh_file.empty()) continue;
    const std::vector<double>& measures = built.measures[b];
    const double mean = std::accumulate(measures.begin(), measures.end(), 0.0) / static_cast<double>(measures.size());
    const double apart = std::pow(mean, 1.0 / w.spec.dimension());
    if (apart > 1.05 * cell)
      w.warnings.push_back(fmt::format("[body.{}]: the points of its file are {:.3g} m apart and the cells {:.3g} m wide: some have no point, and the body is too soft (a block "
                                       "under pressure by 7 % at 1.25 times the width). Take more points.per_element, or cells of {:.2g} m",
                                       body.name, apart, cell, apart));
  }
}

}  // namespace

void warn_of_proportions(World& w, const BuiltBodies& built) {
  constexpr double whole = 1.0 - 1e-6;  // cells
  warn_of_weights(w, built);
  warn_of_pressures(w);
  Eigen::AlignedBox3d all;
  std::vector<Eigen::AlignedBox3d> bodies(w.spec.bodies.size());
  for (const SurfacePoint& s : built.surface) look_at_piece(s, [&](const Vec3& x) { all.extend(x), bodies[s.body].extend(x); });
  w.comm.agree([&] { warn_of_motions(w, all.diagonal().norm()); });
  if (w.spec.method != Method::mpm) return;
  warn_of_sparse_points(w, built);
  const double h = w.discretisation->cell_size();
  if (!std::holds_alternative<StructuredGrid>(w.spec.grid)) return;
  for (std::size_t b = 0; b < bodies.size(); ++b)
    if (const double longest = bodies[b].diagonal().maxCoeff(); !bodies[b].isEmpty() && longest < whole * h)
      w.thin_parts.push_back(fmt::format("body {} is {:.3g} m long, {:.2g} of a cell: the grid sees no more of it than a point, and it is as wide as the functions of "
                                         "its nodes; take cells of {:.2g} m or smaller",
                                         w.spec.bodies[b].name, longest, longest / h, 0.25 * longest));
}

}  // namespace berm
