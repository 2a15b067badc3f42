#pragma once
/// The nodes that a point talks to.

#include <array>

#include "base/tensor.hpp"

namespace berm {

/// Interpolation at one point: value = sum N[k] field[node[k]]. 20 nodes: quadratic hexahedra of the FEM reference.
struct Stencil {
  int n = 0;
  std::array<int, 20> node{};
  std::array<double, 20> N{};

  template <class Field>
  Vec3 interpolate(const Field& field) const {
    Vec3 value = Vec3::Zero();
    for (int k = 0; k < n; ++k) value += N[k] * field[node[k]];
    return value;
  }
};

}  // namespace berm
