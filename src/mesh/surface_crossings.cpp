/// Surfaces that pass through themselves: what is inside has no meaning there.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <boost/geometry/geometries/box.hpp>
#include <boost/geometry/geometries/point.hpp>
#include <boost/geometry/index/rtree.hpp>
#include <iterator>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/place_text.hpp"
#include "mesh/surface.hpp"

namespace berm {
namespace {

namespace bgi = boost::geometry::index;
using Place = boost::geometry::model::point<double, 3, boost::geometry::cs::cartesian>;
using Bounds = boost::geometry::model::box<Place>;

Bounds bounds_of(std::initializer_list<Vec3> places) {
  Vec3 low = *places.begin(), high = low;
  for (const Vec3& x : places) low = low.cwiseMin(x), high = high.cwiseMax(x);
  return {Place(low.x(), low.y(), low.z()), Place(high.x(), high.y(), high.z())};
}

/// Six times the volume of the tetrahedron; positive if d is on the side from which a, b, c run counter-clockwise.
double volume_on(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) { return (b - a).cross(c - a).dot(d - a); }

/// Whether the edge pq passes through the inside of the triangle; one that touches it does not.
bool passes_through(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t) {
  const double size = std::max({(q - p).norm(), (t[1] - t[0]).norm(), (t[2] - t[0]).norm(), (p - t[0]).norm()}), rounding = 1e-9 * size * size * size;
  const double before = volume_on(t[0], t[1], t[2], p), behind = volume_on(t[0], t[1], t[2], q);
  if (std::min(before, behind) > -rounding || std::max(before, behind) < rounding) return false;
  int left = 0, right = 0;
  for (int i = 0; i < 3; ++i) {
    const double side = volume_on(p, q, t[i], t[(i + 1) % 3]);
    left += side > rounding, right += side < -rounding;
  }
  return left == 3 || right == 3;
}

}  // namespace

void refuse_crossings(const TriangleSurface& surface, const std::string& subject) {
  std::vector<std::pair<Bounds, int>> boxes;
  for (int t = 0; t < surface.n_triangles(); ++t) boxes.emplace_back(bounds_of({surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2)}), t);
  const bgi::rtree<std::pair<Bounds, int>, bgi::rstar<16>> tree(boxes);
  int crossings = 0;
  Vec3 first = Vec3::Zero();
  std::vector<std::pair<Bounds, int>> near;
  for (int t = 0; t < surface.n_triangles(); ++t)
    for (int i = 0; i < 3; ++i) {
      const int a = surface.triangles[t][i], b = surface.triangles[t][(i + 1) % 3];
      if (a > b) continue;  // the neighbour's turn
      const Vec3 &p = surface.vertices[a], &q = surface.vertices[b];
      near.clear();
      tree.query(bgi::intersects(bounds_of({p, q})), std::back_inserter(near));
      for (const auto& [box, other] : near) {
        const std::array<int, 3>& corners = surface.triangles[other];
        if (std::find(corners.begin(), corners.end(), a) != corners.end() || std::find(corners.begin(), corners.end(), b) != corners.end()) continue;
        if (passes_through(p, q, {surface.corner(other, 0), surface.corner(other, 1), surface.corner(other, 2)}) && crossings++ == 0) first = 0.5 * (p + q);
      }
    }
  if (crossings > 0)
    throw InputError(fmt::format("{}: the surface passes through itself: {} edge(s) run through a triangle, the first one about {} (mend it in the program that made it)", subject,
                                 crossings, place_text(first, 3)));
}

}  // namespace berm
