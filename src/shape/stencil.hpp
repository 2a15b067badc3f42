#pragma once
/// The nodes that a point talks to.

#include <array>

#include "base/tensor.hpp"

namespace berm {

/// Interpolation at one point: value = sum N[k] field[node[k]].
struct Stencil {
  int n = 0;
  std::array<int, 8> node{};
  std::array<double, 8> N{};

  template <class Field>
  Vec2 interpolate(const Field& field) const {
    Vec2 value = Vec2::Zero();
    for (int k = 0; k < n; ++k) value += N[k] * field[node[k]];
    return value;
  }
};

}  // namespace berm
