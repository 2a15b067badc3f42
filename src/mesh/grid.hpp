#pragma once
/// Background grids: a mesh of linear cells and a fast answer to "which cell holds this point?".

#include <memory>
#include <string>

#include "mesh/mesh.hpp"

namespace berm {

enum class GridKind { quads, triangles_right, triangles_left, union_jack };

struct StructuredGrid {
  GridKind kind = GridKind::quads;
  Vec2 origin = Vec2::Zero();  ///< lower left corner before rotation [m]
  Vec2 cell_size = Vec2::Zero();
  int nx = 0, ny = 0;  ///< cells (a triangle grid has two triangles per cell)
  double angle = 0.0;  ///< counter-clockwise rotation about the point (0, 0) [rad]
};

/// Finds cells. Structured grids by arithmetic, unstructured ones by a uniform bin table: both O(1) per point.
class CellLocator {
public:
  virtual ~CellLocator() = default;
  /// Cell that holds x (hint: where the point was before, or -1), or -1 if x lies outside of the grid.
  virtual int locate(const Vec2& x, int hint) const = 0;
};

struct Grid {
  Mesh mesh;  ///< tri3 and quad4 only
  std::unique_ptr<CellLocator> locator;
};

Grid make_structured_grid(const StructuredGrid& spec);
/// Any conforming mesh of triangles and quads. Throws InputError if a cell is inverted or not linear.
Grid make_unstructured_grid(Mesh mesh);

}  // namespace berm
