#pragma once
/// Solid bodies: what is asked of their shapes, in three dimensions.

#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "mesh/convex_cell.hpp"
#include "mesh/surface.hpp"

namespace berm {

/// A piece of a cell inside the body.
struct SolidPiece {
  Vec3 centroid;
  double volume;
};

/// A piece of the boundary, outward normal.
struct SolidBoundaryPiece {
  Vec3 centre, normal;
  double area;
  std::array<Vec3, 3> corner;
};

/// Axis-aligned cells of one size, each divided into equal boxes.
struct BoxGrid {
  Vec3 origin, cell;                         ///< lowest corner; edge lengths of a cell [m]
  std::array<int, 3> cells;                  ///< number of cells in x, y, z
  std::array<int, 3> divisions = {1, 1, 1};  ///< boxes a cell in x, y, z

  /// Coordinate of plane i (0 .. cells * divisions) across the direction d.
  double plane(int d, int i) const { return origin[d] + cell[d] * i / divisions[d]; }
};

/// The body inside a closed surface. All volumes are exact for the triangles, up to rounding.
class SolidRegion {
public:
  /// The surface must be closed and turned outwards, as those of triangulate and read_stl are.
  explicit SolidRegion(TriangleSurface surface);
  ~SolidRegion();
  SolidRegion(SolidRegion&&) noexcept;
  SolidRegion& operator=(SolidRegion&&) noexcept;

  const TriangleSurface& surface() const;
  double volume() const;
  Vec3 min() const;
  Vec3 max() const;
  bool contains(const Vec3& x) const;  ///< boundary (within rounding) counts as inside

  /// The part of the cell inside the body. Volume 0 if none, or less than 1e-12 of the cell.
  SolidPiece clip(const ConvexCell& cell) const;

  /// Calls visit(i, j, k, piece, full) for every box of the grid with a part of the body in it, in an order that is
  /// always the same; i, j, k count boxes, not cells. Much faster than clip for each.
  using VisitBox = std::function<void(int i, int j, int k, const SolidPiece& piece, bool full)>;
  void for_each_box(const BoxGrid& grid, const VisitBox& visit) const;

  /// The boundary in triangles with edges no longer than `spacing`, with the true normals at the centres of the
  /// triangles that they come from.
  std::vector<SolidBoundaryPiece> boundary(double spacing) const;

  /// Closest point of the triangles to x: signed distance (negative inside) and the outward normal there; at edges and
  /// corners the direction of the distance.
  struct Nearest {
    Vec3 point, normal;
    double distance;
  };
  Nearest nearest(const Vec3& x) const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace berm
