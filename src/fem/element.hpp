#pragma once
/// Isoparametric shape functions: tri3, quad4, tri6, quad8 (serendipity). Node order as in mesh.hpp.

#include <array>
#include <vector>

#include "mesh/mesh.hpp"
#include "shape/quadrature.hpp"

namespace berm::fem {

struct ElementShape {
  int n = 0;
  std::array<double, 8> N{};
  std::array<Vec2, 8> dN{};  ///< by the local coordinates
};

ElementShape element_shape(CellKind kind, const Vec2& xi);

/// The usual rule of each kind: tri3 1 point, quad4 2x2, tri6 3 points, quad8 2x2.
std::vector<QuadraturePoint> element_rule(CellKind kind);

/// Shape functions at local coordinate s in [-1, 1] of edge `local` of a cell: local coordinates of that point.
Vec2 edge_point(CellKind kind, int local, double s);

}  // namespace berm::fem
