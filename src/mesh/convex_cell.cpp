#include "mesh/convex_cell.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace berm {

namespace {

constexpr double flat = 1e-12;  ///< out of plane by less than this part of its size: a plane face

bool plane(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
  const Vec3 normal = (c - a).cross(d - b);
  const double size = std::max((c - a).norm(), (d - b).norm());
  // The distance of the diagonals: 0 in a plane face. The second term: rounding far from the origin.
  return std::abs(normal.dot(b - a)) <= normal.norm() * (flat * size + 1e-15 * a.norm());
}

void add_quad(ConvexCell& cell, const std::array<int, 4>& q) {
  std::vector<Vec3>& x = cell.vertices;
  if (plane(x[q[0]], x[q[1]], x[q[2]], x[q[3]])) {
    cell.faces.push_back({q[0], q[1], q[2], q[3]});
    return;
  }
  // In this order neighbours find the same mean to the last bit.
  std::array<int, 4> s = q;
  std::sort(s.begin(), s.end(), [&](int a, int b) {
    return std::lexicographical_compare(x[a].data(), x[a].data() + 3, x[b].data(), x[b].data() + 3);
  });
  const int middle = static_cast<int>(x.size());
  x.push_back(0.25 * (x[s[0]] + x[s[1]] + x[s[2]] + x[s[3]]));
  for (int i = 0; i < 4; ++i) cell.faces.push_back({middle, q[i], q[(i + 1) % 4]});
}

}  // namespace

ConvexCell hexahedron_cell(const std::array<Vec3, 8>& corners) {
  ConvexCell cell;
  cell.vertices.assign(corners.begin(), corners.end());
  cell.faces.reserve(6);
  constexpr std::array<std::array<int, 4>, 6> faces = {
      {{0, 3, 2, 1}, {4, 5, 6, 7}, {0, 1, 5, 4}, {1, 2, 6, 5}, {2, 3, 7, 6}, {3, 0, 4, 7}}};
  for (const std::array<int, 4>& face : faces) add_quad(cell, face);
  return cell;
}

ConvexCell tetrahedron_cell(const std::array<Vec3, 4>& corners) {
  return {{corners.begin(), corners.end()}, {{0, 2, 1}, {0, 1, 3}, {1, 2, 3}, {0, 3, 2}}};
}

}  // namespace berm
