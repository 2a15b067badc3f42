#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "mesh/cell_map.hpp"
#include "mesh/gmsh.hpp"
#include "mesh/grid.hpp"

using namespace berm;

namespace {

constexpr int nx = 5, ny = 4, nz = 3;
const Vec3 origin(-0.3, 0.2, 0.1), cell_size(0.1, 0.05, 0.2);
const Vec3 extent = Vec3(nx, ny, nz).cwiseProduct(cell_size);
const GridKind solid_kinds[] = {GridKind::hexahedra, GridKind::tetrahedra};

StructuredGrid spec_of(GridKind kind, double angle = 0.0) {
  StructuredGrid spec;
  spec.kind = kind;
  spec.origin = origin;
  spec.cell_size = cell_size;
  spec.nx = nx;
  spec.ny = ny;
  spec.nz = nz;
  spec.angle = angle;
  return spec;
}

/// The structured mesh with nodes moved by up to `amount` of a cell, those of the outer faces not at all.
Mesh shaken(GridKind kind, double amount) {
  Mesh mesh = make_structured_grid(spec_of(kind)).mesh;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-amount, amount);
  for (Vec3& x : mesh.nodes) {
    const Vec3 move(u(random), u(random), u(random));
    const Vec3 inside = (x - origin).cwiseMin(origin + extent - x);
    if (inside.minCoeff() > 1e-9) x += move.cwiseProduct(cell_size);
  }
  return mesh;
}

double depth_in(const Mesh& mesh, int c, const Vec3& x) {
  Vec3 xi;
  return inverse_map(mesh.kinds[c], corners(mesh, c), x, xi) ? local_depth(mesh.kinds[c], xi) : -1e9;
}

/// Cells that hold x by the map alone.
std::vector<int> holders(const Mesh& mesh, const Vec3& x, double margin) {
  std::vector<int> cells;
  for (int c = 0; c < mesh.n_cells(); ++c)
    if (depth_in(mesh, c, x) >= margin) cells.push_back(c);
  return cells;
}

class RandomPoints {
public:
  explicit RandomPoints(unsigned seed) : random_(seed) {}
  Vec3 operator()() { return origin + Vec3(u_(random_), u_(random_), u_(random_)).cwiseProduct(extent); }

private:
  std::mt19937 random_;
  std::uniform_real_distribution<double> u_{0.0, 1.0};
};

void expect_neighbours_symmetric(const Grid& grid) {
  const Mesh& mesh = grid.mesh;
  EXPECT_EQ(grid.neighbours, cell_neighbours(mesh));
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto faces = faces_of(mesh.kinds[c]);
    for (int f = 0; f < max_faces; ++f) {
      const int other = grid.neighbours[max_faces * c + f];
      if (other < 0) continue;
      ASSERT_LT(f, static_cast<int>(faces.size()));
      const auto* back = &grid.neighbours[max_faces * other];
      EXPECT_EQ(std::count(back, back + max_faces, c), 1);
      const auto nodes = mesh.nodes_of_cell(other);
      for (int k = 0; k < faces[f].n; ++k)
        EXPECT_EQ(std::count(nodes.begin(), nodes.end(), mesh.cell(c)[faces[f].corner[k]]), 1);
    }
  }
}

/// Nodes, and middles of edges, faces and cells.
std::vector<Vec3> special_points(const Mesh& mesh) {
  std::vector<Vec3> points = mesh.nodes;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const Corners p = corners(mesh, c);
    points.push_back(cell_centre(mesh, c));
    for (const auto& [a, b] : edges_of(mesh.kinds[c])) points.push_back(0.5 * (p.x[a] + p.x[b]));
    for (const FaceCorners& f : faces_of(mesh.kinds[c])) {
      Vec3 sum = Vec3::Zero();
      for (int k = 0; k < f.n; ++k) sum += p.x[f.corner[k]];
      points.push_back(sum / f.n);
    }
  }
  return points;
}

}  // namespace

TEST(SolidGrid, CellsFillTheBox) {
  for (GridKind kind : solid_kinds)
    for (double angle : {0.0, 0.4}) {
      const bool hexes = kind == GridKind::hexahedra;
      const Grid grid = make_structured_grid(spec_of(kind, angle));
      EXPECT_EQ(grid.dimension(), 3);
      EXPECT_EQ(grid.mesh.n_nodes(), (nx + 1) * (ny + 1) * (nz + 1));
      EXPECT_EQ(grid.mesh.n_cells(), nx * ny * nz * (hexes ? 1 : 6));
      double volume = 0.0;
      for (int c = 0; c < grid.mesh.n_cells(); ++c) {
        EXPECT_NEAR(cell_measure(grid.mesh, c), cell_size.prod() / (hexes ? 1 : 6), 1e-16);
        volume += cell_measure(grid.mesh, c);
      }
      EXPECT_NEAR(volume, extent.prod(), 1e-14);
      EXPECT_NEAR(edge_length(grid.mesh.kinds[0], cell_measure(grid.mesh, 0)), std::cbrt(cell_size.prod()), 1e-14);
      const auto outer = boundary_faces(grid.mesh);
      EXPECT_EQ(outer.size(), 2u * (nx * ny + ny * nz + nx * nz) * (hexes ? 1 : 2));
      EXPECT_EQ(std::count(grid.neighbours.begin(), grid.neighbours.end(), -1),
                static_cast<long>(outer.size()) + (hexes ? 0 : 2 * grid.mesh.n_cells()));
      expect_neighbours_symmetric(grid);
    }
}

TEST(SolidGrid, BoundaryFacesLookOutside) {
  for (GridKind kind : solid_kinds) {
    const Mesh mesh = shaken(kind, 0.2);
    double volume = 0.0;
    Vec3 sum = Vec3::Zero();
    for (const CellFace& face : boundary_faces(mesh)) {
      const Corners p = face_corners(mesh, face);
      const Vec3 area =
          0.5 * (p.n == 3 ? (p.x[1] - p.x[0]).cross(p.x[2] - p.x[0]) : (p.x[2] - p.x[0]).cross(p.x[3] - p.x[1]));
      Vec3 middle = Vec3::Zero();
      for (int i = 0; i < p.n; ++i) middle += p.x[i] / p.n;
      EXPECT_GT(area.dot(middle - cell_centre(mesh, face.cell)), 0.0);
      sum += area;
      volume += middle.dot(area) / 3.0;
    }
    EXPECT_LT(sum.norm(), 1e-14);
    EXPECT_NEAR(volume, extent.prod(), 1e-14);
  }
}

TEST(SolidGrid, LocatesRandomPoints) {
  for (GridKind kind : solid_kinds)
    for (double angle : {0.0, 0.4}) {
      const Grid grid = make_structured_grid(spec_of(kind, angle));
      const Eigen::AngleAxisd r(angle, Vec3::UnitZ());
      RandomPoints point(1);
      for (int k = 0; k < 2000; ++k) {
        const Vec3 x = r * point();
        const int cell = grid.locator->locate(x, -1);
        ASSERT_GE(cell, 0);
        EXPECT_GT(depth_in(grid.mesh, cell, x), -1e-12);
      }
    }
}

TEST(SolidGrid, LocatesNodesEdgesAndFaces) {
  for (GridKind kind : solid_kinds)
    for (double angle : {0.0, 0.4}) {
      const Grid grid = make_structured_grid(spec_of(kind, angle));
      for (const Vec3& x : special_points(grid.mesh)) {
        const int cell = grid.locator->locate(x, -1);
        ASSERT_GE(cell, 0) << x.transpose();
        EXPECT_GT(depth_in(grid.mesh, cell, x), -1e-11);
      }
    }
}

TEST(SolidGrid, OutsideIsOutsideButForRounding) {
  for (GridKind kind : solid_kinds)
    for (bool structured : {true, false}) {
      Grid grid = make_structured_grid(spec_of(kind));
      if (!structured) grid = make_unstructured_grid(std::move(grid.mesh));
      const Vec3 middle = origin + 0.47 * extent;
      for (int d = 0; d < 3; ++d)
        for (double side : {-1.0, 1.0}) {
          Vec3 x = middle;
          x[d] = side < 0.0 ? origin[d] : origin[d] + extent[d];
          EXPECT_GE(grid.locator->locate(x, -1), 0);
          EXPECT_GE(grid.locator->locate(x + side * 1e-13 * Vec3::Unit(d), -1), 0);
          EXPECT_EQ(grid.locator->locate(x + side * 1e-10 * Vec3::Unit(d), -1), -1);
          EXPECT_EQ(grid.locator->locate(x + side * 10.0 * Vec3::Unit(d), 0), -1);
          x[d] = std::nan("");
          EXPECT_EQ(grid.locator->locate(x, -1), -1);
        }
    }
}

TEST(SolidGrid, UnstructuredAgreesWithStructured) {
  for (GridKind kind : solid_kinds) {
    const Grid a = make_structured_grid(spec_of(kind, 0.3));
    const Grid b = make_unstructured_grid(a.mesh);
    EXPECT_EQ(a.neighbours, b.neighbours);
    const Eigen::AngleAxisd r(0.3, Vec3::UnitZ());
    RandomPoints point(2);
    for (int k = 0; k < 3000; ++k) {
      const Vec3 x = r * Vec3(origin + 1.2 * (point() - origin) - 0.1 * extent);
      EXPECT_EQ(a.locator->locate(x, -1), b.locator->locate(x, k % a.mesh.n_cells()));
    }
  }
}

TEST(SolidGrid, DistortedCellsFillTheBoxAndAreFound) {
  for (GridKind kind : solid_kinds)
    for (double amount : {0.1, 0.22}) {
      const Grid grid = make_unstructured_grid(shaken(kind, amount));
      double volume = 0.0;
      for (int c = 0; c < grid.mesh.n_cells(); ++c) volume += cell_measure(grid.mesh, c);
      EXPECT_NEAR(volume, extent.prod(), 1e-14);
      expect_neighbours_symmetric(grid);
      RandomPoints point(3);
      int hint = -1;
      for (int k = 0; k < 300; ++k) {
        const Vec3 x = point();
        const int cell = grid.locator->locate(x, hint);
        ASSERT_GE(cell, 0) << x.transpose();
        EXPECT_EQ(cell, grid.locator->locate(x, -1));
        const std::vector<int> all = holders(grid.mesh, x, -1e-11);
        EXPECT_EQ(cell, all.at(0));
        EXPECT_LE(std::count_if(all.begin(), all.end(), [&](int c) { return depth_in(grid.mesh, c, x) >= 1e-9; }), 1);
        hint = cell;
      }
    }
}

TEST(SolidGrid, PointsBetweenCellsDoNotDependOnTheHint) {
  for (GridKind kind : solid_kinds) {
    const Grid grid = make_unstructured_grid(shaken(kind, 0.2));
    const std::vector<Vec3> points = special_points(grid.mesh);
    for (std::size_t i = 0; i < points.size(); i += 7) {
      const int cell = grid.locator->locate(points[i], -1);
      ASSERT_GE(cell, 0);
      EXPECT_GT(depth_in(grid.mesh, cell, points[i]), -1e-11);
      for (int hint : holders(grid.mesh, points[i], -1e-9)) EXPECT_EQ(grid.locator->locate(points[i], hint), cell);
    }
  }
}

TEST(SolidGrid, TetrahedraOfAnyShape) {
  BodyMeshOptions options;
  options.kind = BodyMeshKind::tetrahedra;
  options.size = 0.15;
  const SolidShape box{SolidBox{origin, origin + extent}};
  const Grid grid = make_unstructured_grid(mesh_shape(box, options));
  expect_neighbours_symmetric(grid);
  RandomPoints point(4);
  for (int k = 0; k < 300; ++k) {
    const Vec3 x = point();
    const int cell = grid.locator->locate(x, -1);
    ASSERT_GE(cell, 0);
    EXPECT_GT(depth_in(grid.mesh, cell, x), -1e-11);
    EXPECT_LE(holders(grid.mesh, x, 1e-9).size(), 1u);
  }
  for (const Vec3& x : special_points(grid.mesh)) EXPECT_GE(grid.locator->locate(x, -1), 0);
}

TEST(SolidGrid, SweptCylinderAsGrid) {
  BodyMeshOptions options;
  options.kind = BodyMeshKind::hexahedra;
  options.size = 0.12;
  options.structured = true;
  const SolidShape rod{Cylinder{Vec3(0, 0, 0), Vec3(0.3, 0.6, 0.6), 0.4}};
  const Grid grid = make_unstructured_grid(mesh_shape(rod, options));
  std::mt19937 random(6);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  const Vec3 axis = Vec3(0.3, 0.6, 0.6) / 0.9, across = axis.unitOrthogonal(), third = axis.cross(across);
  for (int k = 0; k < 1000; ++k) {
    const Vec2 disc = 0.38 * Vec2(u(random), u(random));
    const Vec3 x = (0.45 + 0.45 * u(random)) * axis + disc.x() * across + disc.y() * third;
    const int cell = grid.locator->locate(x, -1);
    if (disc.norm() < 0.38) {
      EXPECT_GE(cell, 0);
    }
    if (disc.norm() > 0.4) {
      EXPECT_EQ(cell, -1);
    }
    if (cell >= 0) {
      EXPECT_GT(depth_in(grid.mesh, cell, x), -1e-11);
    }
  }
}

TEST(SolidGrid, RefusesNonsense) {
  for (int StructuredGrid::*n : {&StructuredGrid::nx, &StructuredGrid::ny, &StructuredGrid::nz}) {
    StructuredGrid spec = spec_of(GridKind::hexahedra);
    spec.*n = 0;
    EXPECT_THROW(make_structured_grid(spec), InputError);
    spec.*n = 100000000;
    EXPECT_THROW(make_structured_grid(spec), InputError);
  }
  StructuredGrid spec = spec_of(GridKind::tetrahedra);
  spec.cell_size.z() = 0.0;
  EXPECT_THROW(make_structured_grid(spec), InputError);
}

TEST(SolidGrid, RefusesBadCells) {
  for (GridKind kind : solid_kinds) {
    Mesh inverted = shaken(kind, 0.1);
    std::swap(inverted.connectivity[0], inverted.connectivity[1]);
    EXPECT_THROW(make_unstructured_grid(inverted), InputError);
    Mesh thrice = shaken(kind, 0.1);
    const std::vector<int> again(thrice.cell(0), thrice.cell(1));
    for (int k = 0; k < 2; ++k) thrice.add_cell(thrice.kinds[0], again.data());
    EXPECT_THROW(make_unstructured_grid(thrice), InputError);
    Mesh mixed = shaken(kind, 0.1);
    mixed.add_cell(CellKind::tri3, again.data());
    EXPECT_THROW(make_unstructured_grid(mixed), InputError);
    EXPECT_THROW(make_unstructured_grid(shaken(kind, 5.0)), InputError);
  }
  BodyMeshOptions options;
  options.kind = BodyMeshKind::hexahedra;
  options.size = 0.5;
  options.order = 2;
  options.structured = true;
  EXPECT_THROW(make_unstructured_grid(mesh_shape(SolidShape{SolidBox{Vec3::Zero(), Vec3::Ones()}}, options)),
               InputError);
}

TEST(SolidGrid, LargeGridIsFast) {
  StructuredGrid spec = spec_of(GridKind::hexahedra);
  spec.nx = spec.ny = spec.nz = 60;
  const auto start = std::chrono::steady_clock::now();
  const Grid grid = make_structured_grid(spec);
  EXPECT_EQ(std::count(grid.neighbours.begin(), grid.neighbours.end(), -1), 6 * 60 * 60);
  EXPECT_LT(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count(), 2.0);
}
