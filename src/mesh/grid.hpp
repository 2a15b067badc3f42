#pragma once
/// Background grids: a mesh of linear cells and a fast answer to "which cell holds this point?".

#include <memory>
#include <optional>
#include <utility>
#include <string>

#include "mesh/mesh.hpp"

namespace berm {

enum class GridKind { quads, triangles_right, triangles_left, union_jack, hexahedra, tetrahedra };

constexpr int dimension_of(GridKind kind) { return kind >= GridKind::hexahedra ? 3 : 2; }

struct StructuredGrid {
  GridKind kind = GridKind::quads;
  Vec3 origin = Vec3::Zero();  ///< lower left (front) corner before rotation [m]
  Vec3 cell_size = Vec3::Zero();
  /// Cells by direction, nz = 0 in the plane. A triangle grid has two triangles a cell, one of tetrahedra six, around the
  /// diagonal from the lowest to the highest corner (Kuhn).
  int nx = 0, ny = 0, nz = 0;
  double angle = 0.0;  ///< counter-clockwise rotation about the z axis through the point 0 [rad]
};

/// Finds cells. Structured grids by arithmetic, unstructured ones by a uniform bin table: both O(1) per point.
class CellLocator {
public:
  virtual ~CellLocator() = default;
  /// Cell that holds x (hint: where the point was before, or -1), or -1 if x lies outside of the grid.
  virtual int locate(const Vec3& x, int hint) const = 0;
};

struct Grid {
  Mesh mesh;                    ///< tri3 and quad4, or tet4 and hex8, only
  std::vector<int> neighbours;  ///< see cell_neighbours
  std::unique_ptr<CellLocator> locator;
  /// Axis-parallel boxes of equal size: the grid's own description, which clips bodies and finds cells faster.
  std::unique_ptr<StructuredGrid> boxes;
  std::unique_ptr<StructuredGrid> structure;  ///< what a structured grid was made from

  int dimension() const { return mesh.dimension(); }
};

Grid make_structured_grid(const StructuredGrid& spec);
/// Any conforming mesh of linear cells. Throws InputError if a cell is inverted or not linear.
Grid make_unstructured_grid(Mesh mesh);

/// Two cells of which one holds the middle of the other, or a place near a corner of it; none in a mesh whose cells lie beside
/// each other. Edges count as straight.
std::optional<std::pair<int, int>> overlapping_cells(const Mesh& mesh);

}  // namespace berm
