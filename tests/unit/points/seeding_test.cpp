#include "points/seeding.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "base/error.hpp"
#include "mesh/cell_map.hpp"
#include "mesh/gmsh.hpp"

namespace berm {
namespace {

using Placement = PointSeeding::Placement;

PlaneShape plane(const auto& form) { return PlaneShape{form}; }
SolidShape solid(const auto& form) { return SolidShape{form}; }

/// A square or cubic grid about the origin.
Grid grid_of(GridKind kind, double h, int n, double angle = 0.0) {
  StructuredGrid s;
  s.kind = kind;
  s.cell_size = Vec3(h, h, h);
  s.nx = s.ny = n;
  if (dimension_of(kind) == 3) s.nz = n;
  s.origin = -0.5 * h * Vec3(s.nx, s.ny, s.nz);
  s.angle = angle;
  return make_structured_grid(s);
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

Vec3 first_moment(const SeededPoints& points) {
  Vec3 m = Vec3::Zero();
  for (std::size_t p = 0; p < points.x.size(); ++p) m += points.measure[p] * points.x[p];
  return m;
}

PointSeeding seeding_of(int n, Placement placement) {
  PointSeeding seeding;
  seeding.per_direction = n;
  seeding.placement = placement;
  return seeding;
}

TEST(SeedFromGrid, AreasOfADiscAddUpOnEveryGrid) {
  const Region disc(plane(Disc{Vec2(0.01, -0.02), 0.37}), 0.1);
  for (GridKind kind : {GridKind::quads, GridKind::triangles_right, GridKind::triangles_left, GridKind::union_jack})
    for (int n : {1, 2, 3})
      for (auto placement : {Placement::gauss, Placement::uniform}) {
        const SeededPoints points = seed_from_grid(disc, grid_of(kind, 0.1, 10, 0.3), seeding_of(n, placement), "disc");
        EXPECT_NEAR(sum(points.measure) / disc.measure(), 1.0, 1e-9);
        const Vec3 centre = first_moment(points) / disc.measure();
        EXPECT_NEAR((centre - Vec3(0.01, -0.02, 0.0)).norm(), 0.0, 1e-9);
      }
}

TEST(SeedFromGrid, BodyBeyondTheGridIsRefused) {
  const Region box(plane(Box{Vec2(-0.2, -0.2), Vec2(0.7, 0.2)}), 0.1);
  EXPECT_THROW(seed_from_grid(box, grid_of(GridKind::quads, 0.1, 10), {}, "box"), InputError);
}

// ---- in space

/// A body with its volume and centroid.
struct Solid {
  const char* name;
  SolidShape shape;
  double volume;
  Vec3 centroid;
};

std::vector<Solid> solids() {
  const double pi = std::numbers::pi;
  const Vec3 tilt = Vec3(0.13, 0.05, 0.31);
  return {{"box", solid(SolidBox{Vec3(-0.23, -0.31, -0.12), Vec3(0.24, 0.29, 0.27)}), 0.47 * 0.6 * 0.39,
           Vec3(0.005, -0.01, 0.075)},
          {"box on the cells", solid(SolidBox{Vec3(-0.3, -0.3, -0.1), Vec3(0.3, 0.1, 0.3)}), 0.6 * 0.4 * 0.4,
           Vec3(0.0, -0.1, 0.1)},
          {"cylinder", solid(Cylinder{Vec3(0.01, 0.02, -0.21), Vec3(0.01, 0.02, 0.26), 0.27}), pi * 0.27 * 0.27 * 0.47,
           Vec3(0.01, 0.02, 0.025)},
          {"tilted cylinder", solid(Cylinder{Vec3(-0.02, 0.01, 0.0) - tilt, Vec3(-0.02, 0.01, 0.0) + tilt, 0.2}),
           pi * 0.04 * 2.0 * tilt.norm(), Vec3(-0.02, 0.01, 0.0)},
          {"sphere", solid(Sphere{Vec3(0.01, -0.02, 0.03), 0.33}), 4.0 / 3.0 * pi * std::pow(0.33, 3),
           Vec3(0.01, -0.02, 0.03)}};
}

/// Centroid of the region by its own clipping, in one piece.
Piece whole_of(const Region& region) {
  Corners all{8, {}};
  for (int c = 0; c < 8; ++c) all.x[c] = Vec3(corner_sign[c][0], corner_sign[c][1], corner_sign[c][2]);
  return region.clip(CellKind::hex8, all);
}

TEST(SeedFromGrid, VolumesAndFirstMomentsAddUpOnEverySolidGrid) {
  for (const Solid& body : solids()) {
    SCOPED_TRACE(body.name);
    const Region region(body.shape, 0.1);
    EXPECT_NEAR(region.measure(), body.volume, 1e-9 * body.volume);
    const Piece piece = whole_of(region);
    ASSERT_NEAR(piece.measure, region.measure(), 1e-12);
    EXPECT_LT((piece.centroid - body.centroid).norm(), 1e-3);
    for (GridKind kind : {GridKind::hexahedra, GridKind::tetrahedra})
      for (double angle : {0.0, 0.3})
        for (int n : {1, 2, 3}) {
          if (angle > 0.0 && n == 3) continue;
          const auto placement = n == 3 ? Placement::uniform : Placement::gauss;
          const Grid grid = kind == GridKind::hexahedra ? grid_of(kind, 0.1, 10, angle) : grid_of(kind, 0.2, 5, angle);
          const SeededPoints points = seed_from_grid(region, grid, seeding_of(n, placement), body.name);
          ASSERT_EQ(points.x.size(), points.measure.size());
          EXPECT_TRUE(points.shift.empty());
          EXPECT_NEAR(sum(points.measure) / region.measure(), 1.0, 1e-10);
          EXPECT_LT((first_moment(points) / region.measure() - piece.centroid).norm(), 1e-10);
          EXPECT_GT(*std::min_element(points.measure.begin(), points.measure.end()), 0.0);
        }
  }
}

/// Gauss or evenly spaced points in whole cells, at most n^3 (tetrahedra: 8^k) in cut ones, all in the cell they count
/// for.
TEST(SeedFromGrid, WholeCellsGetTheirRuleAndCutCellsNoMorePoints) {
  const Region region(solids().back().shape, 0.1);
  const double g = 0.5 / std::sqrt(3.0), t = (5.0 - std::sqrt(5.0)) / 20.0;
  for (GridKind kind : {GridKind::hexahedra, GridKind::tetrahedra})
    for (auto placement : {Placement::gauss, Placement::uniform}) {
      const bool hexes = kind == GridKind::hexahedra, gauss = placement == Placement::gauss;
      const Grid grid = hexes ? grid_of(kind, 0.1, 10) : grid_of(kind, 0.125, 8);
      const SeededPoints points = seed_from_grid(region, grid, seeding_of(2, placement), "ball");
      std::map<int, std::vector<int>> in_cell;
      for (std::size_t p = 0; p < points.x.size(); ++p)
        in_cell[grid.locator->locate(points.x[p], -1)].push_back(static_cast<int>(p));
      EXPECT_FALSE(in_cell.contains(-1));
      int whole = 0, cut = 0, touched = 0;
      for (int c = 0; c < grid.mesh.n_cells(); ++c) {
        const CellKind cell = grid.mesh.kinds[c];
        const double volume = cell_measure(grid.mesh, c), inside = region.clip(cell, corners(grid.mesh, c)).measure;
        touched += inside > 0.0;
        if (!in_cell.contains(c)) {
          EXPECT_LT(inside, 1e-9 * volume);
          continue;
        }
        double total = 0.0;
        for (int p : in_cell[c]) total += points.measure[p];
        EXPECT_NEAR(total, inside, 1e-10 * volume);
        if (inside < (1.0 - 1e-9) * volume) {
          ++cut;
          EXPECT_LE(in_cell[c].size(), 8u);
          continue;
        }
        ++whole;
        ASSERT_EQ(in_cell[c].size(), hexes || !gauss ? 8u : 4u);
        for (int p : in_cell[c]) {
          EXPECT_NEAR(points.measure[p], volume / in_cell[c].size(), 1e-12 * volume);
          Vec3 xi;
          ASSERT_TRUE(inverse_map(cell, corners(grid.mesh, c), points.x[p], xi));
          if (hexes) {
            for (double x : xi) EXPECT_NEAR(std::abs(x), gauss ? 2.0 * g : 0.5, 1e-10);
          } else if (gauss) {
            const double l[4] = {1.0 - xi.sum(), xi.x(), xi.y(), xi.z()};
            EXPECT_EQ(std::count_if(l, l + 4, [&](double x) { return std::abs(x - t) < 1e-10; }), 3);
          }
        }
      }
      EXPECT_GT(whole, 20);
      EXPECT_GT(cut, 20);
      EXPECT_EQ(static_cast<int>(in_cell.size()), whole + cut);
      EXPECT_GE(touched, whole + cut);
    }
}

/// Boxes take a path of their own; without it the same points come out, in the same order.
TEST(SeedFromGrid, BoxesAgreeWithTheGeneralPath) {
  for (const Solid& body : solids()) {
    SCOPED_TRACE(body.name);
    const Region region(body.shape, 0.1);
    for (int n : {1, 2, 3})
      for (auto placement : {Placement::gauss, Placement::uniform}) {
        if (n == 3 && placement == Placement::uniform) continue;
        Grid grid = grid_of(GridKind::hexahedra, 0.1, 10);
        ASSERT_NE(grid.boxes, nullptr);
        const SeededPoints fast = seed_from_grid(region, grid, seeding_of(n, placement), body.name);
        grid.boxes.reset();
        const SeededPoints slow = seed_from_grid(region, grid, seeding_of(n, placement), body.name);
        ASSERT_EQ(fast.x.size(), slow.x.size());
        // Cells one after the other in both; the parts of a cut cell may come in another order.
        const auto cells = [&](const SeededPoints& points) {
          std::vector<int> list;
          for (const Vec3& x : points.x) list.push_back(grid.locator->locate(x, -1));
          EXPECT_TRUE(std::is_sorted(list.begin(), list.end()));
          return list;
        };
        EXPECT_EQ(cells(fast), cells(slow));
        const double scale = std::pow(0.1 / n, 3);
        std::vector<char> used(slow.x.size(), 0);
        for (std::size_t p = 0; p < fast.x.size(); ++p) {
          const auto twin = [&](std::size_t q) {
            return !used[q] && std::abs(slow.measure[q] - fast.measure[p]) < 1e-11 * scale &&
                   fast.measure[p] * (slow.x[q] - fast.x[p]).norm() < 1e-11 * scale;
          };
          const std::size_t first = p < 27 ? 0 : p - 27, last = std::min(slow.x.size(), p + 28);
          std::size_t q = first;
          while (q < last && !twin(q)) ++q;
          ASSERT_LT(q, last) << "no twin of point " << p;
          used[q] = 1;
        }
      }
  }
}

TEST(SeedFromGrid, SolidBeyondTheGridIsRefused) {
  for (GridKind kind : {GridKind::hexahedra, GridKind::tetrahedra})
    for (const SolidShape& shape :
         {solid(SolidBox{Vec3(-0.2, -0.2, -0.2), Vec3(0.2, 0.2, 0.51)}), solid(Sphere{Vec3(0.3, 0.0, 0.0), 0.25}),
          solid(Sphere{Vec3(3.0, 0.0, 0.0), 0.25})}) {
      try {
        seed_from_grid(Region(shape, 0.1), grid_of(kind, 0.25, 4), {}, "stray");
        FAIL() << "no error";
      } catch (const InputError& error) {
        const std::string text = error.what();
        EXPECT_NE(text.find("body \"stray\" has a volume of"), std::string::npos) << text;
        EXPECT_NE(text.find("m3 lie inside the background grid: make the grid larger"), std::string::npos) << text;
      }
    }
}

// ---- fitted quadrature

/// The definition of the fit: per cell the measure and the first moment of body and cell (computed by clipping).
void expect_fitted(const SeededPoints& points, const Region& region, const Grid& grid, double tolerance) {
  EXPECT_NEAR(sum(points.measure) / region.measure(), 1.0, 1e-9);
  ASSERT_EQ(points.shift.size(), points.x.size());
  std::vector<double> measure(grid.mesh.n_cells(), 0.0);
  std::vector<Vec3> moment(grid.mesh.n_cells(), Vec3::Zero());
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    const int cell = grid.locator->locate(points.x[p], -1);
    measure[cell] += points.measure[p];
    moment[cell] += points.measure[p] * (points.x[p] + points.shift[p]);
  }
  for (int c = 0; c < grid.mesh.n_cells(); ++c) {
    const Piece piece = region.clip(grid.mesh.kinds[c], corners(grid.mesh, c));
    EXPECT_NEAR(measure[c], piece.measure, tolerance);
    EXPECT_NEAR((moment[c] - piece.measure * piece.centroid).norm(), 0.0, tolerance);
  }
}

TEST(FitToCells, AreaAndCentroidOfEveryCellAreThoseOfTheBodyInIt) {
  const PlaneShape shape = plane(Box{Vec2(-0.23, -0.31), Vec2(0.24, 0.29)});
  const Region region(shape, 0.1);
  for (GridKind kind : {GridKind::quads, GridKind::union_jack}) {
    const Grid grid = grid_of(kind, 0.0648148, 14);
    BodyMeshOptions options;
    options.kind = BodyMeshKind::triangles;
    options.size = 0.075;
    options.structured = true;
    SeededPoints points = seed_from_mesh(mesh_shape(shape, options), 3);
    fit_to_cells(points, region, grid);
    expect_fitted(points, region, grid, 1e-12);
  }
}

TEST(FitToCells, VolumeAndCentroidOfEveryCellAreThoseOfTheBodyInIt) {
  const Solid body = solids()[0];
  const Region region(body.shape, 0.1);
  for (GridKind kind : {GridKind::hexahedra, GridKind::tetrahedra})
    for (BodyMeshKind mesh : {BodyMeshKind::hexahedra, BodyMeshKind::tetrahedra}) {
      const Grid grid = grid_of(kind, 0.0948148, 8);
      BodyMeshOptions options;
      options.kind = mesh;
      options.size = 0.12;
      options.structured = true;
      SeededPoints points = seed_from_mesh(mesh_shape(body.shape, options), mesh == BodyMeshKind::hexahedra ? 8 : 4);
      const std::size_t before = points.x.size();
      fit_to_cells(points, region, grid);
      EXPECT_GE(points.x.size(), before);  // cells without a point got one
      expect_fitted(points, region, grid, 1e-12);
    }
}

/// In a cell full of points the mean products of two local coordinates are those of the cell too: zero. Before the fit
/// they are not.
TEST(FitToCells, FullHexahedraHaveNoMeanProducts) {
  const Solid body = solids()[0];
  const Region region(body.shape, 0.1);
  const Grid grid = grid_of(GridKind::hexahedra, 0.0948148, 8);
  BodyMeshOptions options;
  options.kind = BodyMeshKind::tetrahedra;
  options.size = 0.06;
  options.structured = true;
  SeededPoints points = seed_from_mesh(mesh_shape(body.shape, options), 4);
  const auto largest_product = [&](int cell, bool fitted) {
    const Corners box = corners(grid.mesh, cell);
    const Vec3 edge = box.x[6] - box.x[0], centre = 0.5 * (box.x[0] + box.x[6]);
    Mat3 products = Mat3::Zero();
    double measure = 0.0;
    for (std::size_t p = 0; p < points.x.size(); ++p) {
      if (grid.locator->locate(points.x[p], -1) != cell) continue;
      const Vec3 x = fitted ? Vec3(points.x[p] + points.shift[p]) : points.x[p];
      const Vec3 xi = 2.0 * (x - centre).cwiseQuotient(edge);
      products += points.measure[p] * xi * xi.transpose();
      measure += points.measure[p];
    }
    products /= measure;
    return std::max({std::abs(products(0, 1)), std::abs(products(1, 2)), std::abs(products(2, 0))});
  };
  std::vector<int> full;
  for (int c = 0; c < grid.mesh.n_cells(); ++c)
    if (region.clip(grid.mesh.kinds[c], corners(grid.mesh, c)).measure > (1.0 - 1e-9) * cell_measure(grid.mesh, c))
      full.push_back(c);
  ASSERT_GE(full.size(), 8u);
  double before = 0.0, after = 0.0;
  for (int c : full) before = std::max(before, largest_product(c, false));
  fit_to_cells(points, region, grid);
  for (int c : full) after = std::max(after, largest_product(c, true));
  EXPECT_GT(before, 1e-3);
  EXPECT_LT(after, 1e-12);
}

// ---- Gauss points of body meshes

TEST(SeedFromMesh, EveryRuleKeepsTheArea) {
  const PlaneShape shape = plane(Box{Vec2(0.0, 0.0), Vec2(0.3, 0.2)});
  BodyMeshOptions options;
  options.size = 0.05;
  options.structured = true;
  for (int n : {1, 4, 9, 16}) {
    const SeededPoints points = seed_from_mesh(mesh_shape(shape, options), n);
    EXPECT_EQ(points.x.size(), 24u * n);
    EXPECT_NEAR(sum(points.measure), 0.06, 1e-14);
  }
  EXPECT_THROW(seed_from_mesh(mesh_shape(shape, options), 6), InputError);
  options.kind = BodyMeshKind::triangles;
  EXPECT_THROW(seed_from_mesh(mesh_shape(shape, options), 4), InputError);
  for (int n : {1, 3, 6, 12}) {
    const SeededPoints points = seed_from_mesh(mesh_shape(shape, options), n);
    EXPECT_EQ(points.x.size(), 48u * n);
    EXPECT_NEAR(sum(points.measure), 0.06, 1e-14);
  }
}

TEST(SeedFromMesh, EveryRuleKeepsVolumeAndCentroid) {
  const SolidShape shape = solid(SolidBox{Vec3(0.0, 0.0, 1.0), Vec3(0.3, 0.2, 1.1)});
  BodyMeshOptions options;
  options.size = 0.05;
  options.structured = true;
  for (const BodyMeshKind kind : {BodyMeshKind::hexahedra, BodyMeshKind::tetrahedra}) {
    options.kind = kind;
    const bool hexes = kind == BodyMeshKind::hexahedra;
    const Mesh mesh = mesh_shape(shape, options);
    const unsigned cells = 6 * 4 * 2 * (hexes ? 1 : 6);
    for (int n : hexes ? std::vector<int>{1, 8, 27} : std::vector<int>{1, 4}) {
      const SeededPoints points = seed_from_mesh(mesh, n);
      EXPECT_EQ(points.x.size(), cells * n);
      EXPECT_NEAR(sum(points.measure), 0.006, 1e-15);
      EXPECT_LT((first_moment(points) / 0.006 - Vec3(0.15, 0.1, 1.05)).norm(), 1e-13);
      if (n == 1) continue;
      double second = 0.0;  // of degree 2: int x^2 dV
      for (std::size_t p = 0; p < points.x.size(); ++p) second += points.measure[p] * std::pow(points.x[p].x(), 2);
      EXPECT_NEAR(second, 0.02 * std::pow(0.3, 3) / 3.0, 1e-15);
    }
    for (int n : hexes ? std::vector<int>{0, 4, 64} : std::vector<int>{3, 8}) {
      EXPECT_THROW(seed_from_mesh(mesh, n), InputError) << n;
    }
  }
}

/// Cells that are no boxes: the weights carry the Jacobian.
TEST(SeedFromMesh, VolumeOfACylinderOfDistortedCells) {
  const SolidShape shape = solid(Cylinder{Vec3(0.1, 0.2, 0.3), Vec3(0.1, 0.2, 0.7), 0.25});
  BodyMeshOptions options;
  options.size = 0.1;
  options.structured = true;
  for (const BodyMeshKind kind : {BodyMeshKind::hexahedra, BodyMeshKind::tetrahedra}) {
    options.kind = kind;
    const Mesh mesh = mesh_shape(shape, options);
    double volume = 0.0;
    for (int c = 0; c < mesh.n_cells(); ++c) volume += cell_measure(mesh, c);
    const SeededPoints points = seed_from_mesh(mesh, kind == BodyMeshKind::hexahedra ? 8 : 4);
    EXPECT_NEAR(sum(points.measure) / volume, 1.0, 1e-12);
    EXPECT_LT((first_moment(points) / volume - Vec3(0.1, 0.2, 0.5)).norm(), 1e-12);
  }
}

}  // namespace
}  // namespace berm
