#include "mesh/solid_region.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <mutex>
#include <optional>

#include "base/error.hpp"
#include "mesh/solid_bins.hpp"
#include "mesh/triangle_tree.hpp"

namespace berm {

namespace {

constexpr double sliver = 1e-12;  ///< parts of a cell smaller than this fraction are rounding errors

SolidMoments moments_of(const ConvexCell& cell, const Vec3& origin) {
  SolidMoments moments;
  for (const std::vector<int>& face : cell.faces)
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
      moments.add(cell.vertices[face[0]] - origin, cell.vertices[face[i]] - origin,
                  cell.vertices[face[i + 1]] - origin);
  return moments;
}

Vec3 centre_of(const ConvexCell& cell) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& x : cell.vertices) sum += x;
  return sum / static_cast<double>(cell.vertices.size());
}

/// No vertex lies before a face, but for rounding.
bool convex(const ConvexCell& cell, const Vec3& centre) {
  double size = 0.0;
  for (const Vec3& x : cell.vertices) size = std::max(size, (x - centre).norm());
  const double tolerance = 1e-11 * size + 1e-14 * centre.norm();
  for (const std::vector<int>& face : cell.faces) {
    const Vec3& a = cell.vertices[face[0]];
    const Vec3& c = cell.vertices[face[2]];
    const Vec3 normal = face.size() == 3 ? (cell.vertices[face[1]] - a).cross(c - a).normalized()
                                         : (c - a).cross(cell.vertices[face[3]] - cell.vertices[face[1]]).normalized();
    for (const Vec3& x : cell.vertices)
      if (normal.dot(x - a) > tolerance) return false;
  }
  return true;
}

/// A cell with edges that turn inwards is the sum of the tetrahedra from its centre to its faces. Those shared with a
/// neighbour are the same triangles there, so that the parts of a mesh add up.
SolidMoments clip_by_parts(const SolidBins& bins, const ConvexCell& cell, const Vec3& centre) {
  SolidMoments sum;
  for (const std::vector<int>& face : cell.faces)
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
      std::array<Vec3, 4> x = {centre, cell.vertices[face[0]], cell.vertices[face[i]], cell.vertices[face[i + 1]]};
      const double six = (x[1] - x[0]).dot((x[2] - x[0]).cross(x[3] - x[0]));
      if (six == 0.0) continue;
      if (six < 0.0) std::swap(x[2], x[3]);
      const SolidMoments part = bins.clip(tetrahedron_cell(x), centre);
      sum.volume += six < 0.0 ? -part.volume : part.volume;
      sum.first += six < 0.0 ? Vec3(-part.first) : part.first;
    }
  return sum;
}

}  // namespace

struct SolidRegion::Impl {
  TriangleSurface surface;
  Vec3 low, high;
  double volume;
  TriangleTree tree;

  explicit Impl(TriangleSurface s)
      : surface(std::move(s)),
        low(low_corner(surface)),
        high(high_corner(surface)),
        volume(berm::volume(surface)),
        tree(surface) {}

  /// Made when first needed: whole grids do without.
  const SolidBins& bins() const {
    std::call_once(once_, [this] { bins_.emplace(surface); });
    return *bins_;
  }

private:
  mutable std::once_flag once_;
  mutable std::optional<SolidBins> bins_;
};

SolidRegion::SolidRegion(TriangleSurface surface) {
  if (surface.triangles.empty()) throw InputError("solid: its surface has no triangles");
  impl_ = std::make_unique<Impl>(std::move(surface));
}
SolidRegion::~SolidRegion() = default;
SolidRegion::SolidRegion(SolidRegion&&) noexcept = default;
SolidRegion& SolidRegion::operator=(SolidRegion&&) noexcept = default;

const TriangleSurface& SolidRegion::surface() const { return impl_->surface; }
double SolidRegion::volume() const { return impl_->volume; }
Vec3 SolidRegion::min() const { return impl_->low; }
Vec3 SolidRegion::max() const { return impl_->high; }

bool SolidRegion::contains(const Vec3& x) const { return impl_->bins().contains(x); }

SolidPiece SolidRegion::clip(const ConvexCell& cell) const {
  const Vec3 centre = centre_of(cell);
  const SolidMoments whole = moments_of(cell, centre);
  const SolidBins& bins = impl_->bins();
  const SolidMoments part = convex(cell, centre) ? bins.clip(cell, centre) : clip_by_parts(bins, cell, centre);
  if (part.volume <= sliver * whole.volume) return {centre, 0.0};
  if (part.volume >= (1.0 - sliver) * whole.volume) return {centre + whole.first / whole.volume, whole.volume};
  return {centre + part.first / part.volume, part.volume};
}

void SolidRegion::for_each_box(const BoxGrid& grid, const VisitBox& visit) const {
  GridPlanes planes;
  Vec3 box;
  for (int d = 0; d < 3; ++d) {
    box[d] = grid.cell[d] / grid.divisions[d];
    for (int i = 0; i <= grid.cells[d] * grid.divisions[d]; ++i) planes[d].push_back(grid.plane(d, i));
  }
  const auto full = [&](const BoxRange& range) {
    for (int k = range.first[2]; k < range.last[2]; ++k)
      for (int j = range.first[1]; j < range.last[1]; ++j)
        for (int i = range.first[0]; i < range.last[0]; ++i) {
          const BoxRange one{{i, j, k}, {i + 1, j + 1, k + 1}};
          visit(i, j, k, {0.5 * (one.low(planes) + one.high(planes)), box.prod()}, true);
        }
  };
  const auto part = [&](const BoxRange& range, const Soup& soup) {
    const Vec3 centre = 0.5 * (range.low(planes) + range.high(planes));
    SolidMoments moments;
    moments.add(soup, centre);
    visit(range.first[0], range.first[1], range.first[2], {centre + moments.first / moments.volume, moments.volume},
          false);
  };
  bisect(soup_of(impl_->surface), planes, sliver * box.prod(), full, part);
}

std::vector<SolidBoundaryPiece> SolidRegion::boundary(double spacing) const {
  const TriangleSurface fine = split(impl_->surface, spacing);
  std::vector<SolidBoundaryPiece> pieces;
  pieces.reserve(fine.triangles.size());
  for (int t = 0; t < fine.n_triangles(); ++t)
    pieces.push_back({(fine.corner(t, 0) + fine.corner(t, 1) + fine.corner(t, 2)) / 3.0, fine.normals[t],
                      area_vector(fine, t).norm(), {fine.corner(t, 0), fine.corner(t, 1), fine.corner(t, 2)}});
  return pieces;
}

SolidRegion::Nearest SolidRegion::nearest(const Vec3& x) const {
  const TriangleTree::Hit hit = impl_->tree.nearest(x);
  const Vec3 offset = x - hit.point;
  const double distance = offset.norm(), sign = contains(x) ? -1.0 : 1.0;
  // At an edge the normal is the direction of the distance, as long as there is one.
  if (!hit.interior && distance > 1e-12 * (impl_->high - impl_->low).maxCoeff())
    return {hit.point, sign / distance * offset, sign * distance};
  return {hit.point, impl_->surface.normals[hit.triangle], sign * distance};
}

}  // namespace berm
