#include "mesh/region.hpp"

#include "mesh/gmsh_solid.hpp"

namespace berm {

Region::Region(const Shape& shape, double size) {
  if (const auto* plane = std::get_if<PlaneShape>(&shape)) {
    plane_.emplace(*plane);
    return;
  }
  solid_.emplace(triangulate(std::get<SolidShape>(shape), size));
}

double Region::measure() const { return plane_ ? plane_->area() : solid_->volume(); }
Vec3 Region::min() const { return plane_ ? in_space(plane_->min()) : solid_->min(); }
Vec3 Region::max() const { return plane_ ? in_space(plane_->max()) : solid_->max(); }

bool Region::contains(const Vec3& x) const { return plane_ ? plane_->contains(in_plane(x)) : solid_->contains(x); }

Piece Region::clip(CellKind kind, const Corners& cell) const {
  if (plane_) {
    std::vector<Vec2> polygon;
    for (int i = 0; i < cell.n; ++i) polygon.push_back(in_plane(cell.x[i]));
    const PlanePiece piece = plane_->clip(polygon);
    return {in_space(piece.centroid), piece.area};
  }
  const std::array<Vec3, 4> first = {cell.x[0], cell.x[1], cell.x[2], cell.x[3]};
  const SolidPiece piece = solid_->clip(is_simplex(kind) ? tetrahedron_cell(first) : hexahedron_cell(cell.x));
  return {piece.centroid, piece.volume};
}

std::vector<BoundaryPiece> Region::boundary(double spacing) const {
  std::vector<BoundaryPiece> out;
  if (plane_)
    for (const PlaneBoundaryPiece& p : plane_->boundary(spacing))
      out.push_back({in_space(p.centre), in_space(p.normal), p.length, {}});
  else
    for (const SolidBoundaryPiece& p : solid_->boundary(spacing)) out.push_back({p.centre, p.normal, p.area, p.corner});
  return out;
}

Region::Nearest Region::nearest(const Vec3& x) const {
  if (plane_) {
    const PlaneRegion::Nearest n = plane_->nearest(in_plane(x));
    return {in_space(n.point), in_space(n.normal), n.distance};
  }
  const auto n = solid_->nearest(x);
  return {n.point, n.normal, n.distance};
}

}  // namespace berm
