#include "shape/linear.hpp"

#include <gtest/gtest.h>

#include <random>

using namespace berm;

namespace {

const CellKind linear_kinds[] = {CellKind::tri3, CellKind::quad4, CellKind::tet4, CellKind::hex8};

class LinearShape : public testing::Test {
protected:
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  Vec3 vector(double size, int dimension) {
    Vec3 v = Vec3::Zero();
    for (int d = 0; d < dimension; ++d) v[d] = between(-size, size);
    return v;
  }

  /// One cell: the reference cell, sheared, with corners moved by up to `distortion` (edges are 1 or 2 long).
  Mesh cell_of(CellKind kind, double distortion) {
    const int dimension = dimension_of(kind);
    Mat3 shear = Mat3::Identity();
    for (int d = 0; d < dimension; ++d) shear.col(d) += vector(0.25, dimension);
    Mesh mesh;
    for (int i = 0; i < nodes_of(kind); ++i) {
      Vec3 corner(corner_sign[i][0], corner_sign[i][1], dimension == 3 ? corner_sign[i][2] : 0.0);
      if (is_simplex(kind)) corner = i == 0 ? Vec3(Vec3::Zero()) : Vec3(Vec3::Unit(i - 1));
      mesh.nodes.push_back(shear * corner + vector(distortion, dimension));
    }
    const int nodes[] = {0, 1, 2, 3, 4, 5, 6, 7};
    mesh.add_cell(kind, nodes);
    return mesh;
  }

  /// A point of the cell, or up to `outside` in local coordinates beyond it.
  Vec3 point_of(const Mesh& mesh, double outside = 0.0) {
    const CellKind kind = mesh.kinds[0];
    const int dimension = dimension_of(kind);
    Vec3 xi = vector(1.0 + outside, dimension);
    if (is_simplex(kind)) do {
        for (int d = 0; d < dimension; ++d) xi[d] = between(-outside, 1.0 + outside);
      } while (xi.head(dimension).sum() > 1.0 + outside);
    LocalShape s;
    local_shape(kind, xi, s);
    Vec3 x = Vec3::Zero();
    for (int i = 0; i < nodes_of(kind); ++i) x += s.N[i] * mesh.nodes[i];
    return x;
  }

  std::mt19937 random_{7};
};

}  // namespace

TEST_F(LinearShape, PartitionOfUnityAndLinearFields) {
  for (CellKind kind : linear_kinds)
    for (int trial = 0; trial < 300; ++trial) {
      const int dimension = dimension_of(kind);
      const Mesh mesh = cell_of(kind, is_simplex(kind) ? 0.1 : 0.3);
      const Vec3 x = point_of(mesh, 0.1), slope = vector(1.0, dimension);
      const double offset = between(-1.0, 1.0);
      Shape8 shape;
      ASSERT_TRUE(linear_shape(mesh, 0, x, shape));
      ASSERT_EQ(shape.n, nodes_of(kind));
      double sum = 0.0, value = 0.0;
      Vec3 gradient = Vec3::Zero(), gradient_sum = Vec3::Zero(), back = Vec3::Zero();
      for (int i = 0; i < shape.n; ++i) {
        const double field = offset + slope.dot(mesh.nodes[i]);
        EXPECT_EQ(shape.nodes[i], i);
        sum += shape.N[i];
        value += shape.N[i] * field;
        gradient += shape.grad[i] * field;
        gradient_sum += shape.grad[i];
        back += shape.N[i] * mesh.nodes[i];
      }
      EXPECT_NEAR(sum, 1.0, 1e-13);
      EXPECT_NEAR(value, offset + slope.dot(x), 1e-12);
      EXPECT_LT((gradient - slope).norm(), 1e-11);
      EXPECT_LT(gradient_sum.norm(), 1e-11);
      EXPECT_LT((back - x).norm(), 1e-12);
    }
}

TEST_F(LinearShape, GradientsAgainstFiniteDifferences) {
  const double h = 1e-5;
  for (CellKind kind : linear_kinds)
    for (int trial = 0; trial < 50; ++trial) {
      const Mesh mesh = cell_of(kind, is_simplex(kind) ? 0.1 : 0.3);
      const Vec3 x = point_of(mesh);
      Shape8 shape, ahead, behind;
      ASSERT_TRUE(linear_shape(mesh, 0, x, shape));
      for (int d = 0; d < dimension_of(kind); ++d) {
        ASSERT_TRUE(linear_shape(mesh, 0, x + h * Vec3::Unit(d), ahead));
        ASSERT_TRUE(linear_shape(mesh, 0, x - h * Vec3::Unit(d), behind));
        for (int i = 0; i < shape.n; ++i) EXPECT_NEAR(shape.grad[i][d], (ahead.N[i] - behind.N[i]) / (2.0 * h), 1e-7);
      }
      if (dimension_of(kind) == 2) {
        for (int i = 0; i < shape.n; ++i) EXPECT_EQ(shape.grad[i].z(), 0.0);
      }
    }
}

TEST_F(LinearShape, OneAtItsCornerAndPositiveInside) {
  for (CellKind kind : linear_kinds) {
    const Mesh mesh = cell_of(kind, 0.1);
    Shape8 shape;
    for (int i = 0; i < nodes_of(kind); ++i) {
      ASSERT_TRUE(linear_shape(mesh, 0, mesh.nodes[i], shape));
      for (int j = 0; j < shape.n; ++j) EXPECT_NEAR(shape.N[j], i == j ? 1.0 : 0.0, 1e-13);
    }
    for (int trial = 0; trial < 100; ++trial) {
      ASSERT_TRUE(linear_shape(mesh, 0, point_of(mesh), shape));
      for (int j = 0; j < shape.n; ++j) EXPECT_GT(shape.N[j], -1e-13);
    }
  }
}

TEST_F(LinearShape, InverseMapFindsLocalCoordinates) {
  for (CellKind kind : linear_kinds)
    for (int trial = 0; trial < 300; ++trial) {
      const Mesh mesh = cell_of(kind, is_simplex(kind) ? 0.1 : 0.3);
      const Corners p = corners(mesh, 0);
      const Vec3 x = point_of(mesh);
      Vec3 xi;
      ASSERT_TRUE(inverse_map(kind, p, x, xi));
      EXPECT_GT(local_depth(kind, xi), -1e-12);
      LocalShape s;
      local_shape(kind, xi, s);
      Vec3 back = Vec3::Zero();
      for (int i = 0; i < p.n; ++i) back += s.N[i] * p.x[i];
      EXPECT_LT((back - x).norm(), 1e-13);
    }
}

TEST_F(LinearShape, FlatCellsHaveNone) {
  for (CellKind kind : linear_kinds) {
    Mesh mesh = cell_of(kind, 0.0);
    const int flat = dimension_of(kind) - 1;
    for (Vec3& x : mesh.nodes) x[flat] = 0.0;
    Shape8 shape;
    EXPECT_FALSE(linear_shape(mesh, 0, Vec3(0.1, 0.1, 0.0), shape));
  }
}
