#pragma once
/// Shape functions of all solid cells, written down apart from those of the program, and volumes by them.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "mesh/mesh.hpp"

namespace berm::solid_cells {

/// Local coordinates of the nodes in VTK's order (vtkQuadraticTetra, vtkQuadraticHexahedron mapped to -1 .. 1).
inline Vec3 node_at(CellKind kind, int i) {
  static const double tetrahedron[10][3] = {{0, 0, 0},   {1, 0, 0},  {0, 1, 0},  {0, 0, 1},   {.5, 0, 0},
                                            {.5, .5, 0}, {0, .5, 0}, {0, 0, .5}, {.5, 0, .5}, {0, .5, .5}};
  static const double hexahedron[20][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1},
                                           {1, -1, 1},   {1, 1, 1},   {-1, 1, 1}, {0, -1, -1}, {1, 0, -1},
                                           {0, 1, -1},   {-1, 0, -1}, {0, -1, 1}, {1, 0, 1},   {0, 1, 1},
                                           {-1, 0, 1},   {-1, -1, 0}, {1, -1, 0}, {1, 1, 0},   {-1, 1, 0}};
  const double* x = is_simplex(kind) ? tetrahedron[i] : hexahedron[i];
  return {x[0], x[1], x[2]};
}

inline double shape(CellKind kind, int i, const Vec3& xi) {
  const Vec3 at = node_at(kind, i);
  if (is_simplex(kind)) {
    const double l[4] = {1.0 - xi.sum(), xi.x(), xi.y(), xi.z()};
    if (kind == CellKind::tet4) return l[i];
    if (i < 4) return l[i] * (2.0 * l[i] - 1.0);
    double product = 4.0;
    const double at_l[4] = {1.0 - at.sum(), at.x(), at.y(), at.z()};
    for (int k = 0; k < 4; ++k) product *= at_l[k] > 0.0 ? l[k] : 1.0;
    return product;
  }
  double product = 1.0;
  for (int d = 0; d < 3; ++d) product *= at[d] == 0.0 ? 1.0 - xi[d] * xi[d] : 0.5 * (1.0 + at[d] * xi[d]);
  return kind == CellKind::hex20 && i < 8 ? product * (at.dot(xi) - 2.0) : product;
}

/// Determinant of the Jacobian; central differences are exact for quadratic functions.
inline double jacobian(const Mesh& mesh, int c, const Vec3& xi) {
  const CellKind kind = mesh.kinds[c];
  Mat3 J = Mat3::Zero();
  for (int i = 0; i < nodes_of(kind); ++i)
    for (int d = 0; d < 3; ++d) {
      const Vec3 h = 0.5 * Vec3::Unit(d);
      J.col(d) += (shape(kind, i, xi + h) - shape(kind, i, xi - h)) * mesh.nodes[mesh.cell(c)[i]];
    }
  return J.determinant();
}

/// Gauss points with four a direction; tetrahedra as collapsed cubes.
struct Point {
  Vec3 xi;
  double weight;
};
inline std::vector<Point> fine_rule(CellKind kind) {
  const double s = 2.0 / 7.0 * std::sqrt(1.2), a = std::sqrt(3.0 / 7.0 - s), b = std::sqrt(3.0 / 7.0 + s);
  const double at[4] = {-b, -a, a, b}, wb = (18.0 - std::sqrt(30.0)) / 36.0, weight[4] = {wb, 1 - wb, 1 - wb, wb};
  std::vector<Point> rule;
  for (int i = 0; i < 4; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) {
        const Vec3 x(at[i], at[j], at[k]);
        const double w = weight[i] * weight[j] * weight[k];
        if (is_simplex(kind)) {
          const Vec3 r = 0.5 * (x + Vec3::Ones());
          const double left = 1.0 - r.x(), rest = left * (1.0 - r.y());
          rule.push_back({Vec3(r.x(), left * r.y(), rest * r.z()), w / 8.0 * left * rest});
        } else {
          rule.push_back({x, w});
        }
      }
  return rule;
}

/// Volume of the cell with its curved faces; all Jacobians at Gauss points and nodes must be positive.
inline double volume(const Mesh& mesh, int c) {
  const CellKind kind = mesh.kinds[c];
  double sum = 0.0;
  for (const Point& p : fine_rule(kind)) {
    const double J = jacobian(mesh, c, p.xi);
    EXPECT_GT(J, 0.0);
    sum += p.weight * J;
  }
  for (int i = 0; i < nodes_of(kind); ++i) EXPECT_GT(jacobian(mesh, c, node_at(kind, i)), 0.0);
  return sum;
}

inline double volume(const Mesh& mesh) {
  double sum = 0.0;
  for (int c = 0; c < mesh.n_cells(); ++c) sum += volume(mesh, c);
  return sum;
}

/// Mid-side nodes of straight cells lie half-way between the corners of their edges.
inline void expect_mid_sides(const Mesh& mesh, double tolerance) {
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const CellKind kind = mesh.kinds[c];
    for (int i = corners_of(kind); i < nodes_of(kind); ++i) {
      Vec3 middle = Vec3::Zero();
      for (int k = 0; k < corners_of(kind); ++k)
        middle += shape(linear_kind(kind), k, node_at(kind, i)) * mesh.nodes[mesh.cell(c)[k]];
      EXPECT_LT((mesh.nodes[mesh.cell(c)[i]] - middle).norm(), tolerance);
    }
  }
}

}  // namespace berm::solid_cells
