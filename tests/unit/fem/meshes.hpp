#pragma once
/// Small meshes of every kind of element for the tests.

#include <cmath>
#include <map>
#include <utility>

#include "mesh/grid.hpp"

namespace berm {

constexpr CellKind all_kinds[] = {CellKind::tri3, CellKind::quad4, CellKind::tri6,  CellKind::quad8,
                                  CellKind::tet4, CellKind::hex8,  CellKind::tet10, CellKind::hex20};

/// Ends of the edges with a mid-side node, in VTK's order.
inline std::vector<std::pair<int, int>> edge_ends(CellKind kind) {
  switch (linear_kind(kind)) {
    case CellKind::tri3:
      return {{0, 1}, {1, 2}, {2, 0}};
    case CellKind::quad4:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
    case CellKind::tet4:
      return {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
    default:
      return {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6}, {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};
  }
}

inline CellKind quadratic_kind(CellKind kind) {
  switch (kind) {
    case CellKind::tri3:
      return CellKind::tri6;
    case CellKind::quad4:
      return CellKind::quad8;
    case CellKind::tet4:
      return CellKind::tet10;
    default:
      return CellKind::hex20;
  }
}

/// Mid-side nodes for a linear mesh.
inline Mesh quadratic(const Mesh& mesh) {
  Mesh out;
  out.nodes = mesh.nodes;
  std::map<std::pair<int, int>, int> middle;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    std::vector<int> list(mesh.cell(c), mesh.cell(c) + nodes_of(mesh.kinds[c]));
    const std::vector<int> corner = list;
    for (const auto& [a, b] : edge_ends(mesh.kinds[c])) {
      const auto [at, added] = middle.try_emplace(std::minmax(corner[a], corner[b]), out.n_nodes());
      if (added) out.nodes.push_back(0.5 * (mesh.nodes[corner[a]] + mesh.nodes[corner[b]]));
      list.push_back(at->second);
    }
    out.add_cell(quadratic_kind(mesh.kinds[c]), list.data());
  }
  return out;
}

/// The unit square or cube at `origin` in n cells a direction.
inline Mesh unit_mesh(CellKind kind, int n, const Vec3& origin = Vec3::Zero()) {
  StructuredGrid spec;
  const bool solid = dimension_of(kind) == 3;
  spec.kind = solid ? (is_simplex(kind) ? GridKind::tetrahedra : GridKind::hexahedra)
                    : (is_simplex(kind) ? GridKind::union_jack : GridKind::quads);
  spec.origin = origin;
  spec.nx = spec.ny = n;
  spec.nz = solid ? n : 0;
  spec.cell_size = Vec3(1.0, 1.0, solid ? 1.0 : 0.0) / n;
  Mesh mesh = make_structured_grid(spec).mesh;
  return nodes_of(kind) == corners_of(kind) ? mesh : quadratic(mesh);
}

/// Is a node on the surface of the unit square or cube at `origin`?
inline bool on_surface(const Vec3& x, int dimension, const Vec3& origin = Vec3::Zero()) {
  const Vec3 y = x - origin;
  for (int i = 0; i < dimension; ++i)
    if (y[i] < 1e-9 || y[i] > 1.0 - 1e-9) return true;
  return false;
}

/// Moves inner nodes about by up to `size`, the corners first and mid-sides along, the same way in every run.
inline Mesh distorted(CellKind kind, int n, double size, const Vec3& origin = Vec3::Zero()) {
  Mesh mesh = unit_mesh(linear_kind(kind), n, origin);
  for (Vec3& x : mesh.nodes) {
    if (on_surface(x, mesh.dimension(), origin)) continue;
    const Vec3 shift(std::sin(31.0 * x.x() + 17.0 * x.y() + 5.0 * x.z()), std::sin(13.0 * x.x() - 29.0 * x.y() + x.z()),
                     std::sin(7.0 * x.x() + 3.0 * x.y() - 23.0 * x.z()));
    x.head(mesh.dimension()) += size * shift.head(mesh.dimension());
  }
  return nodes_of(kind) == corners_of(kind) ? mesh : quadratic(mesh);
}

}  // namespace berm
