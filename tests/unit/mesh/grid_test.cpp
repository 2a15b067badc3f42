#include "mesh/grid.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "shape/linear.hpp"

using namespace berm;

namespace {

StructuredGrid spec_of(GridKind kind, double angle = 0.0) {
  StructuredGrid spec;
  spec.kind = kind;
  spec.origin = Vec3(-0.3, 0.2, 0.0);
  spec.cell_size = Vec3(0.1, 0.05, 0.0);
  spec.nx = 7;
  spec.ny = 5;
  spec.angle = angle;
  return spec;
}

const GridKind all_kinds[] = {GridKind::quads, GridKind::triangles_right, GridKind::triangles_left,
                              GridKind::union_jack};

double area_of(const Mesh& mesh) {
  double area = 0.0;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    EXPECT_GT(cell_measure(mesh, c), 0.0);
    area += cell_measure(mesh, c);
  }
  return area;
}

/// Faces with a cell on both sides.
int shared_faces(const Grid& grid) {
  return static_cast<int>(std::count_if(grid.neighbours.begin(), grid.neighbours.end(), [](int c) { return c >= 0; })) /
         2;
}

/// A conforming patch: two distorted quads and two triangles on [0,2] x [0,1] and [0,2] x [1,2].
Mesh patch() {
  Mesh mesh;
  mesh.nodes = {{0, 0, 0}, {0.9, 0, 0}, {2, 0, 0}, {0, 1, 0}, {1.1, 0.8, 0}, {2, 1, 0}, {0, 2, 0}, {2, 2, 0}};
  const int q0[] = {0, 1, 4, 3}, q1[] = {1, 2, 5, 4}, t0[] = {3, 4, 6}, t1[] = {4, 7, 6}, t2[] = {4, 5, 7};
  mesh.add_cell(CellKind::quad4, q0);
  mesh.add_cell(CellKind::quad4, q1);
  mesh.add_cell(CellKind::tri3, t0);
  mesh.add_cell(CellKind::tri3, t1);
  mesh.add_cell(CellKind::tri3, t2);
  return mesh;
}

/// The functions of the located cell must reproduce position, partition of unity and constant gradients.
void expect_consistent(const Grid& grid, const Vec3& x, int hint) {
  const int cell = grid.locator->locate(x, hint);
  ASSERT_GE(cell, 0) << x.transpose();
  Shape8 shape;
  ASSERT_TRUE(linear_shape(grid.mesh, cell, x, shape));
  double sum = 0.0;
  Vec3 back = Vec3::Zero(), grad_sum = Vec3::Zero();
  Mat3 grad_x = Mat3::Zero();
  for (int i = 0; i < shape.n; ++i) {
    EXPECT_GT(shape.N[i], -1e-9);
    sum += shape.N[i];
    back += shape.N[i] * grid.mesh.nodes[shape.nodes[i]];
    grad_sum += shape.grad[i];
    grad_x += grid.mesh.nodes[shape.nodes[i]] * shape.grad[i].transpose();
  }
  EXPECT_NEAR(sum, 1.0, 1e-13);
  EXPECT_LT((back - x).norm(), 1e-12);
  EXPECT_LT(grad_sum.norm(), 1e-10);
  Mat3 identity = Mat3::Identity();
  if (grid.dimension() == 2) identity(2, 2) = 0.0;
  EXPECT_LT((grad_x - identity).norm(), 1e-10);
}

}  // namespace

TEST(StructuredGrid, CellsFillTheRectangle) {
  for (GridKind kind : all_kinds)
    for (double angle : {0.0, 0.4}) {
      const Grid grid = make_structured_grid(spec_of(kind, angle));
      EXPECT_EQ(grid.mesh.n_nodes(), 8 * 6);
      EXPECT_EQ(grid.mesh.n_cells(), kind == GridKind::quads ? 35 : 70);
      EXPECT_NEAR(area_of(grid.mesh), 0.7 * 0.25, 1e-14);
      EXPECT_EQ(boundary_faces(grid.mesh).size(), 24u);
      EXPECT_EQ(shared_faces(grid), kind == GridKind::quads ? 58 : 58 + 35);
      EXPECT_EQ(grid.neighbours, cell_neighbours(grid.mesh));
    }
}

TEST(StructuredGrid, RotatesAboutZero) {
  const Grid grid = make_structured_grid(spec_of(GridKind::quads, std::acos(-1.0) / 2));
  EXPECT_LT((grid.mesh.nodes[0] - Vec3(-0.2, -0.3, 0.0)).norm(), 1e-15);
}

TEST(StructuredGrid, DiagonalsAreWhereTheyShouldBe) {
  const auto has_edge = [](const Mesh& mesh, int a, int b) {
    const std::vector<int> neighbours = cell_neighbours(mesh);
    for (int c = 0; c < mesh.n_cells(); ++c)
      for (int f = 0; f < corners_of(mesh.kinds[c]); ++f) {
        const int from = mesh.cell(c)[f], to = mesh.cell(c)[(f + 1) % corners_of(mesh.kinds[c])];
        if (neighbours[max_faces * c + f] >= 0 && std::minmax(from, to) == std::minmax(a, b)) return true;
      }
    return false;
  };
  const Mesh right = make_structured_grid(spec_of(GridKind::triangles_right)).mesh;
  const Mesh left = make_structured_grid(spec_of(GridKind::triangles_left)).mesh;
  const Mesh jack = make_structured_grid(spec_of(GridKind::union_jack)).mesh;
  EXPECT_TRUE(has_edge(right, 0, 9) && has_edge(right, 1, 10));
  EXPECT_TRUE(has_edge(left, 1, 8) && has_edge(left, 2, 9));
  EXPECT_TRUE(has_edge(jack, 0, 9) && has_edge(jack, 2, 9));
  EXPECT_TRUE(has_edge(jack, 9, 16) && has_edge(jack, 9, 18));
}

TEST(StructuredGrid, LocatesAndInterpolates) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  for (GridKind kind : all_kinds)
    for (double angle : {0.0, 0.4}) {
      const StructuredGrid spec = spec_of(kind, angle);
      const Grid grid = make_structured_grid(spec);
      const Eigen::AngleAxisd r(angle, Vec3::UnitZ());
      for (int k = 0; k < 300; ++k)
        expect_consistent(grid, r * (spec.origin + Vec3(0.7 * u(random), 0.25 * u(random), 0.0)), -1);
    }
}

TEST(StructuredGrid, OuterBoundaryIsInsideWithinRounding) {
  for (GridKind kind : all_kinds) {
    const Grid grid = make_structured_grid(spec_of(kind));
    const int last = grid.mesh.n_cells() - 1;
    EXPECT_EQ(grid.locator->locate(Vec3(0.4, 0.45, 0.0), -1), last);
    EXPECT_EQ(grid.locator->locate(Vec3(0.4 + 3e-13, 0.45 + 3e-13, 0.0), -1), last);
    EXPECT_EQ(grid.locator->locate(Vec3(0.4 + 1e-11, 0.4, 0.0), -1), -1);
    EXPECT_EQ(grid.locator->locate(Vec3(-0.3 - 1e-11, 0.4, 0.0), -1), -1);
    EXPECT_EQ(grid.locator->locate(Vec3(0.0, std::nan(""), 0.0), -1), -1);
    for (const Vec3& x : grid.mesh.nodes) EXPECT_GE(grid.locator->locate(x, -1), 0);
  }
}

TEST(StructuredGrid, RefusesNonsense) {
  StructuredGrid spec = spec_of(GridKind::quads);
  spec.nx = 0;
  EXPECT_THROW(make_structured_grid(spec), InputError);
  spec = spec_of(GridKind::quads);
  spec.cell_size.y() = -1.0;
  EXPECT_THROW(make_structured_grid(spec), InputError);
}

TEST(StructuredGrid, LargeGridIsFast) {
  StructuredGrid spec = spec_of(GridKind::quads);
  spec.nx = spec.ny = 280;
  const auto start = std::chrono::steady_clock::now();
  const Grid grid = make_structured_grid(spec);
  EXPECT_EQ(shared_faces(grid), 2 * 280 * 279);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 2.0);
}

TEST(UnstructuredGrid, LocatesAndInterpolates) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(0.0, 2.0);
  const Grid grid = make_unstructured_grid(patch());
  EXPECT_NEAR(area_of(grid.mesh), 4.0, 1e-14);
  int hint = -1;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 x(u(random), u(random), 0.0);
    expect_consistent(grid, x, hint);
    hint = grid.locator->locate(x, -1);
    EXPECT_EQ(hint, grid.locator->locate(x, hint));
  }
  EXPECT_EQ(grid.locator->locate(Vec3(2.001, 1.0, 0.0), hint), -1);
}

TEST(UnstructuredGrid, PointOnALineDoesNotDependOnTheHint) {
  const Grid grid = make_unstructured_grid(patch());
  for (const Vec3& x : grid.mesh.nodes) {
    const int cell = grid.locator->locate(x, -1);
    ASSERT_GE(cell, 0);
    for (int hint = 0; hint < grid.mesh.n_cells(); ++hint) EXPECT_EQ(grid.locator->locate(x, hint), cell);
  }
}

TEST(UnstructuredGrid, AgreesWithStructured) {
  const Grid a = make_structured_grid(spec_of(GridKind::union_jack, 0.3));
  const Grid b = make_unstructured_grid(a.mesh);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> u(-0.6, 0.6);
  for (int k = 0; k < 5000; ++k) {
    const Vec3 x(u(random), u(random), 0.0);
    EXPECT_EQ(a.locator->locate(x, -1), b.locator->locate(x, k % 70));
  }
}

TEST(UnstructuredGrid, RefusesBadCells) {
  Mesh inverted = patch();
  std::swap(inverted.connectivity[0], inverted.connectivity[1]);
  EXPECT_THROW(make_unstructured_grid(inverted), InputError);

  Mesh not_convex = patch();
  not_convex.nodes[4] = Vec3(0.3, 0.3, 0.0);
  EXPECT_THROW(make_unstructured_grid(not_convex), InputError);

  Mesh thrice = patch();
  const int again[] = {4, 5, 7};
  thrice.add_cell(CellKind::tri3, again);
  thrice.add_cell(CellKind::tri3, again);
  EXPECT_THROW(make_unstructured_grid(thrice), InputError);

  EXPECT_THROW(make_unstructured_grid(Mesh()), InputError);
}

TEST(LinearShape, ExtendsSlightlyOutside) {
  const Grid grid = make_unstructured_grid(patch());
  Shape8 shape;
  ASSERT_TRUE(linear_shape(grid.mesh, 0, Vec3(-0.05, -0.02, 0.0), shape));
  Vec3 back = Vec3::Zero();
  for (int i = 0; i < 4; ++i) back += shape.N[i] * grid.mesh.nodes[shape.nodes[i]];
  EXPECT_LT((back - Vec3(-0.05, -0.02, 0.0)).norm(), 1e-13);
}
