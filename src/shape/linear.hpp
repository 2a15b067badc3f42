#pragma once
/// Linear shape functions of cells at a point in space: position -> nodes, values, gradients.

#include "mesh/cell_map.hpp"

namespace berm {

/// Shape functions of one cell at one point.
struct Shape8 {
  int n = 0;                 ///< 3, 4 or 8
  std::array<int, 8> nodes;  ///< node numbers
  std::array<double, 8> N;   ///< values [-]
  std::array<Vec3, 8> grad;  ///< gradients by physical coordinates [1/m]
};

/// Fills `out` at the physical point x; also valid slightly outside of the cell (the functions are extended).
/// Returns false if the cell's map cannot be inverted at x.
inline bool linear_shape(const Mesh& mesh, int cell, const Vec3& x, Shape8& out) {
  const CellKind kind = mesh.kinds[cell];
  const Corners p = corners(mesh, cell);
  out.n = p.n;
  for (int i = 0; i < p.n; ++i) out.nodes[i] = mesh.cell(cell)[i];
  Vec3 xi;
  if (!inverse_map(kind, p, x, xi)) return false;
  LocalShape s;
  local_shape(kind, xi, s);
  const Mat3 push = cell_jacobian(p, dimension_of(kind), s).inverse().transpose();
  out.N = s.N;
  for (int i = 0; i < p.n; ++i) out.grad[i].noalias() = push * s.dN[i];
  return true;
}

}  // namespace berm
