#include "fem/geometry.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <limits>

#include "mesh/cell_map.hpp"

namespace berm::fem {

Mat3 jacobian(const Mesh& mesh, int element, const ElementShape& shape) {
  const int* node = mesh.cell(element);
  Mat3 J = Mat3::Zero();
  for (int k = 0; k < shape.n; ++k) J.noalias() += mesh.nodes[node[k]] * shape.dN[k].transpose();
  if (mesh.dimension() == 2) J.col(2) = Vec3::UnitZ();
  return J;
}

Vec3 place(const Mesh& mesh, int element, const ElementShape& shape) {
  const int* node = mesh.cell(element);
  Vec3 x = Vec3::Zero();
  for (int k = 0; k < shape.n; ++k) x += shape.N[k] * mesh.nodes[node[k]];
  return x;
}

/// Newton from the middle. Its steps shrink quadratically, so that the last one below 1e-8 leaves nothing but rounding.
bool local_coordinates(const Mesh& mesh, int element, const Vec3& x, Vec3& xi) {
  const CellKind kind = mesh.kinds[element];
  const int dimension = dimension_of(kind);
  xi.setZero();
  if (is_simplex(kind)) xi.head(dimension).setConstant(1.0 / (dimension + 1.0));
  for (int it = 0; it < 30; ++it) {
    const ElementShape shape = element_shape(kind, xi);
    const Mat3 J = jacobian(mesh, element, shape);
    if (!(J.determinant() != 0.0)) return false;
    Vec3 step = J.inverse() * (x - place(mesh, element, shape));
    if (dimension == 2) step.z() = 0.0;
    xi += step;
    if (step.norm() < 1e-8) return true;
    if (!(xi.norm() < 10.0)) return false;
  }
  return false;
}

double distance_outside(const Mesh& mesh, int element, const Vec3& x) {
  Vec3 xi;
  if (!local_coordinates(mesh, element, x, xi)) return std::numeric_limits<double>::infinity();
  return std::max(0.0, -local_depth(mesh.kinds[element], xi));
}

Mesh corner_mesh(const Mesh& mesh) {
  Mesh out;
  out.nodes = mesh.nodes;
  for (int c = 0; c < mesh.n_cells(); ++c) out.add_cell(linear_kind(mesh.kinds[c]), mesh.cell(c));
  return out;
}

}  // namespace berm::fem
