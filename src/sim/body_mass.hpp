#pragma once
/// How much of a body's mass the nodes have.

#include <vector>

#include "method/discretisation.hpp"

namespace berm {

/// Of a body of the case, at the nodes that this process owns [kg]; nodes of splines may have a negative share. Collective.
inline std::vector<double> mass_at_nodes(const Discretisation& d, int body) {
  NodalVector f(d.n_nodes(), Vec3::Zero());
  d.add_body_force([body](int b, const Vec3&) { return Vec3(b == body ? 1.0 : 0.0, 0.0, 0.0); }, f);
  d.halo.add_to_owners(f.data()->data(), 3);
  std::vector<double> mass;
  for (int node = 0; node < d.halo.n_owned; ++node) mass.push_back(f[node].x());
  return mass;
}

}  // namespace berm
