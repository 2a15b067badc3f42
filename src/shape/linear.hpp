#pragma once
/// Linear shape functions of triangles and quads at a point in space: position -> nodes, values, gradients.

#include <algorithm>
#include <array>
#include <cmath>

#include "mesh/mesh.hpp"

namespace berm {

/// Shape functions of one cell at one point.
struct Shape4 {
  int n = 0;                 ///< 3 or 4
  std::array<int, 4> nodes;  ///< node numbers
  std::array<double, 4> N;   ///< values [-]
  std::array<Vec2, 4> grad;  ///< gradients by physical coordinates [1/m]
};

namespace linear_detail {

inline double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Bilinear map x = a + b xi + c eta + d xi eta of a quad.
struct Bilinear {
  Vec2 a, b, c, d;
  explicit Bilinear(const std::array<Vec2, 4>& p)
      : a(0.25 * (p[0] + p[1] + p[2] + p[3])),
        b(0.25 * (p[1] - p[0] + p[2] - p[3])),
        c(0.25 * (p[3] - p[0] + p[2] - p[1])),
        d(0.25 * (p[0] - p[1] + p[2] - p[3])) {}
  bool parallelogram() const { return d.squaredNorm() <= 1e-26 * (b.squaredNorm() + c.squaredNorm()); }
};

inline bool solve2(const Vec2& col0, const Vec2& col1, const Vec2& rhs, Vec2& out) {
  const double det = cross(col0, col1);
  if (!(std::abs(det) > 0.0)) return false;
  out = Vec2(cross(rhs, col1), cross(col0, rhs)) / det;
  return true;
}

}  // namespace linear_detail

/// Local coordinates of x: tri3 (0..1, 0..1), quad4 (-1..1, -1..1). False if the map cannot be inverted there
/// (degenerate cell, or x far outside of a strongly distorted quad).
inline bool inverse_map(CellKind kind, const std::array<Vec2, 4>& corners, const Vec2& x, Vec2& xi) {
  using namespace linear_detail;
  if (corners_of(kind) == 3) return solve2(corners[1] - corners[0], corners[2] - corners[0], x - corners[0], xi);
  const Bilinear map(corners);
  if (!solve2(map.b, map.c, x - map.a, xi)) return false;
  if (map.parallelogram()) return true;
  xi = xi.cwiseMax(-1.5).cwiseMin(1.5);
  for (int it = 0; it < 30; ++it) {
    const Vec2 residual = x - map.a - map.b * xi.x() - map.c * xi.y() - map.d * (xi.x() * xi.y());
    Vec2 step;
    if (!solve2(map.b + map.d * xi.y(), map.c + map.d * xi.x(), residual, step)) return false;
    xi += step;
    if (step.squaredNorm() <= 1e-28 * (1.0 + xi.squaredNorm())) return true;
  }
  return false;
}

/// Fills `out` at the physical point x; also valid slightly outside of the cell (the functions are extended).
/// Returns false if the cell's map cannot be inverted at x.
inline bool linear_shape(const Mesh& mesh, int cell, const Vec2& x, Shape4& out) {
  using namespace linear_detail;
  const CellKind kind = mesh.kinds[cell];
  const int* nodes = mesh.cell(cell);
  out.n = corners_of(kind);
  std::array<Vec2, 4> p;
  for (int i = 0; i < out.n; ++i) {
    out.nodes[i] = nodes[i];
    p[i] = mesh.nodes[nodes[i]];
  }
  Vec2 xi;
  if (!inverse_map(kind, p, x, xi)) return false;
  if (out.n == 3) {
    const double det = cross(p[1] - p[0], p[2] - p[0]);
    out.N = {1.0 - xi.x() - xi.y(), xi.x(), xi.y(), 0.0};
    for (int i = 0; i < 3; ++i) {
      const Vec2 edge = p[(i + 2) % 3] - p[(i + 1) % 3];
      out.grad[i] = Vec2(-edge.y(), edge.x()) / det;
    }
    return true;
  }
  const Bilinear map(p);
  const Vec2 j0 = map.b + map.d * xi.y(), j1 = map.c + map.d * xi.x();
  const double det = cross(j0, j1);
  constexpr std::array<double, 4> sx = {-1, 1, 1, -1}, sy = {-1, -1, 1, 1};
  for (int i = 0; i < 4; ++i) {
    const double fx = 1.0 + sx[i] * xi.x(), fy = 1.0 + sy[i] * xi.y();
    out.N[i] = 0.25 * fx * fy;
    const double dxi = 0.25 * sx[i] * fy, deta = 0.25 * sy[i] * fx;
    out.grad[i] = Vec2(dxi * j1.y() - deta * j0.y(), deta * j0.x() - dxi * j1.x()) / det;
  }
  return true;
}

}  // namespace berm
