#pragma once
/// What the checks before a run have in common.

#include <algorithm>
#include <map>

#include "base/groups.hpp"
#include "case/case.hpp"
#include "sim/body_mass.hpp"
#include "sim/preflight.hpp"

namespace berm {

/// By body of the case.
inline std::map<int, Region> regions_of_shapes(const Case& c, double size) {
  std::map<int, Region> regions;
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].shape) regions.try_emplace(static_cast<int>(b), *c.bodies[b].shape, size);
  return regions;
}

/// Sizes of the masses that the owned nodes have of each body of the case; none of rigid ones. Collective.
inline std::vector<std::vector<double>> shares_of_nodes(const World& w) {
  std::vector<std::vector<double>> share(w.spec.bodies.size());
  for (std::size_t b = 0; b < share.size(); ++b) {
    if (w.spec.bodies[b].rigid) continue;
    share[b] = mass_at_nodes(*w.discretisation, static_cast<int>(b));
    for (double& mass : share[b]) mass = std::abs(mass);
  }
  return share;
}

/// Bodies that count as touching at the start, and stay together; every body touches itself.
inline bool are_joined(const World& w, int first, int second) {
  return first == second || std::any_of(w.neighbours.joints.begin(), w.neighbours.joints.end(), [&](const Joint& j) {
    return std::minmax(j.body, j.other) == std::minmax(first, second);
  });
}

/// Motions of a rigid body that the space allows: displacements along x, y, z and turns about them.
inline std::vector<int> motions_of(Space space) {
  if (space == Space::axisymmetric) return {1};
  if (space == Space::solid) return {0, 1, 2, 3, 4, 5};
  return {0, 1, 5};
}

// preflight_start.cpp: each throws InputError, or warns, and is collective.
void refuse_few_points(const World& w, const MpmDiscretisation& mpm, const std::vector<std::vector<double>>& share);
void refuse_jumps(const World& w);
void warn_of_depth(World& w);

}  // namespace berm
