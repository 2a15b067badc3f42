#pragma once
/// The nodes that a point talks to.

#include <vector>

#include "base/tensor.hpp"

namespace berm {

/// Interpolation at one point: value = sum N[k] field[node[k]].
struct Stencil {
  int n = 0;
  std::vector<int> node;
  std::vector<double> N;
  std::vector<Vec3> gradient;  ///< of N [1/m]
  std::vector<double> hoop;    ///< around an axis: hoop strain of a unit radial displacement [1/m]; else 0

  void resize(int nodes) {
    n = nodes;
    node.resize(n);
    N.resize(n);
    gradient.resize(n);
    hoop.assign(n, 0.0);
  }

  template <class Field>
  Vec3 interpolate(const Field& field) const {
    Vec3 value = Vec3::Zero();
    for (int k = 0; k < n; ++k) value += N[k] * field[node[k]];
    return value;
  }
  /// Gradient of a field of vectors, d(field_i)/d(x_j).
  template <class Field>
  Mat3 gradient_of(const Field& field) const {
    Mat3 value = Mat3::Zero();
    for (int k = 0; k < n; ++k) {
      value += field[node[k]] * gradient[k].transpose();
      value(2, 2) += hoop[k] * field[node[k]].x();
    }
    return value;
  }
};

}  // namespace berm
