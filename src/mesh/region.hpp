#pragma once
/// The region that a body fills, in the plane or in space: one face for PlaneRegion and SolidRegion.

#include <optional>
#include <variant>
#include <vector>

#include "mesh/mesh.hpp"
#include "mesh/plane_region.hpp"
#include "mesh/solid_region.hpp"
#include "mesh/solid_shape.hpp"

namespace berm {

using Shape = std::variant<PlaneShape, SolidShape>;

/// The part of a cell inside a body.
struct Piece {
  Vec3 centroid = Vec3::Zero();
  double measure = 0.0;  ///< area [m2] or volume [m3]
};

/// A piece of the boundary, outward normal.
struct BoundaryPiece {
  Vec3 centre, normal;
  double measure;              ///< length [m] or area [m2]
  std::array<Vec3, 3> corner;  ///< of the triangle; only in space
};

class Region {
public:
  /// size: edge length of the triangles that stand for curved surfaces in space [m]. Throws InputError for an empty or
  /// broken shape.
  Region(const Shape& shape, double size);

  int dimension() const { return plane_ ? 2 : 3; }
  double measure() const;  ///< area [m2] or volume [m3]
  Vec3 min() const;
  Vec3 max() const;
  bool contains(const Vec3& x) const;  ///< boundary counts as inside

  /// The part of a linear cell inside the region; measure 0 if none.
  Piece clip(CellKind kind, const Corners& cell) const;
  /// The boundary in pieces no longer than `spacing`, with the true normals of curved shapes.
  std::vector<BoundaryPiece> boundary(double spacing) const;
  /// Closest boundary point to x: signed distance (negative inside) and the outward normal there.
  struct Nearest {
    Vec3 point, normal;
    double distance;
  };
  Nearest nearest(const Vec3& x) const;

  const PlaneRegion* plane() const { return plane_ ? &*plane_ : nullptr; }
  const SolidRegion* solid() const { return solid_ ? &*solid_ : nullptr; }

private:
  std::optional<PlaneRegion> plane_;
  std::optional<SolidRegion> solid_;
};

}  // namespace berm
