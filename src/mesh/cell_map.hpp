#pragma once
/// The map of linear cells from local to physical coordinates, and its inverse.

#include <Eigen/LU>
#include <array>
#include <cmath>

#include "mesh/mesh.hpp"

namespace berm {

/// Local coordinates of the corners of quads and hexahedra [-1, 1].
constexpr double corner_sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                                      {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};

/// Values and derivatives by local coordinates of the shape functions of a linear cell at xi: simplices (0..1),
/// quads and hexahedra (-1..1).
struct LocalShape {
  std::array<double, 8> N;
  std::array<Vec3, 8> dN;
};

inline void local_shape(CellKind kind, const Vec3& xi, LocalShape& s) {
  switch (kind) {
    case CellKind::tri3:
      s.N = {1.0 - xi.x() - xi.y(), xi.x(), xi.y()};
      s.dN[0] = Vec3(-1.0, -1.0, 0.0), s.dN[1] = Vec3::UnitX(), s.dN[2] = Vec3::UnitY();
      return;
    case CellKind::tet4:
      s.N = {1.0 - xi.x() - xi.y() - xi.z(), xi.x(), xi.y(), xi.z()};
      s.dN[0] = Vec3(-1.0, -1.0, -1.0);
      for (int i = 0; i < 3; ++i) s.dN[i + 1] = Vec3::Unit(i);
      return;
    case CellKind::quad4:
      for (int i = 0; i < 4; ++i) {
        const double *c = corner_sign[i], a = 1.0 + c[0] * xi.x(), b = 1.0 + c[1] * xi.y();
        s.N[i] = 0.25 * a * b;
        s.dN[i] = Vec3(0.25 * c[0] * b, 0.25 * c[1] * a, 0.0);
      }
      return;
    default:
      for (int i = 0; i < 8; ++i) {
        const double *c = corner_sign[i], a = 1.0 + c[0] * xi.x(), b = 1.0 + c[1] * xi.y(), d = 1.0 + c[2] * xi.z();
        s.N[i] = 0.125 * a * b * d;
        s.dN[i] = 0.125 * Vec3(c[0] * b * d, c[1] * a * d, c[2] * a * b);
      }
  }
}

/// dx/dxi, columns by local coordinate; in the plane the third column is the unit vector along z.
inline Mat3 cell_jacobian(const Corners& p, int dimension, const LocalShape& s) {
  Mat3 J = Mat3::Zero();
  for (int i = 0; i < p.n; ++i) J.noalias() += p.x[i] * s.dN[i].transpose();
  if (dimension == 2) J.col(2) = Vec3::UnitZ();
  return J;
}

/// Local coordinates of x in a linear cell. False if the map cannot be inverted there (degenerate cell, or x far outside
/// of a strongly distorted cell).
inline bool inverse_map(CellKind kind, const Corners& p, const Vec3& x, Vec3& xi) {
  const int dimension = dimension_of(kind);
  xi = is_simplex(kind) ? Vec3::Constant(1.0 / (dimension + 1.0)) : Vec3::Zero();
  if (dimension == 2) xi.z() = 0.0;
  LocalShape s;
  for (int it = 0; it < 30; ++it) {
    local_shape(kind, xi, s);
    const Mat3 J = cell_jacobian(p, dimension, s);
    const double det = J.determinant();
    if (!(std::abs(det) > 0.0)) return false;
    Vec3 residual = x;
    for (int i = 0; i < p.n; ++i) residual -= s.N[i] * p.x[i];
    if (dimension == 2) residual.z() = 0.0;
    const Vec3 step = J.inverse() * residual;
    xi += step;
    // The error after a step is its square; rounding alone makes steps of 1e-14 in small cells far from the origin.
    if (is_simplex(kind) || step.squaredNorm() <= 1e-20 * (1.0 + xi.squaredNorm())) return true;
    if (it == 0) xi = xi.cwiseMax(-20.0).cwiseMin(20.0);
  }
  return false;
}

/// How far xi lies inside the cell, in local coordinates: negative outside.
inline double local_depth(CellKind kind, const Vec3& xi) {
  const int dimension = dimension_of(kind);
  if (is_simplex(kind)) return std::min(xi.head(dimension).minCoeff(), 1.0 - xi.head(dimension).sum());
  return 0.5 * (1.0 - xi.head(dimension).cwiseAbs().maxCoeff());
}

}  // namespace berm
