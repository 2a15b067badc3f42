#pragma once
/// Isoparametric shape functions of all kinds of cells, quads and hexahedra with mid-sides as serendipity elements.
/// Node order and local coordinates as in mesh.hpp and quadrature.hpp.

#include <array>
#include <vector>

#include "mesh/mesh.hpp"

namespace berm::fem {

constexpr int most_nodes = 20;

struct ElementShape {
  int n = 0;
  std::array<double, most_nodes> N{};
  std::array<Vec3, most_nodes> dN;  ///< by the local coordinates; z = 0 in the plane
};

ElementShape element_shape(CellKind kind, const Vec3& xi);

/// A point of a rule, with the functions there.
struct RulePoint {
  Vec3 xi;
  double weight;
  ElementShape shape;
};

/// The usual rule of each kind: tri3 1 point, quad4 2x2, tri6 3, quad8 2x2, tet4 1, tet10 4, hex8 and hex20 2x2x2.
const std::vector<RulePoint>& element_rule(CellKind kind);

}  // namespace berm::fem
