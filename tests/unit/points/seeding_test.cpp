#include "points/seeding.hpp"

#include <gtest/gtest.h>

#include <numeric>

#include "base/error.hpp"
#include "mesh/gmsh.hpp"

namespace berm {
namespace {

Grid grid_of(GridKind kind, double h, int n, double angle = 0.0) {
  StructuredGrid s;
  s.kind = kind;
  s.origin = Vec2(-0.5 * n * h, -0.5 * n * h);
  s.cell_size = Vec2(h, h);
  s.nx = s.ny = n;
  s.angle = angle;
  return make_structured_grid(s);
}

double sum(const std::vector<double>& v) { return std::accumulate(v.begin(), v.end(), 0.0); }

TEST(SeedFromGrid, AreasOfADiscAddUpOnEveryGrid) {
  const Region disc(Shape{Disc{Vec2(0.01, -0.02), 0.37}});
  for (GridKind kind : {GridKind::quads, GridKind::triangles_right, GridKind::triangles_left, GridKind::union_jack})
    for (int n : {1, 2, 3})
      for (auto placement : {PointSeeding::Placement::gauss, PointSeeding::Placement::uniform}) {
        PointSeeding seeding;
        seeding.per_direction = n;
        seeding.placement = placement;
        const SeededPoints points = seed_from_grid(disc, grid_of(kind, 0.1, 10, 0.3), seeding, "disc");
        EXPECT_NEAR(sum(points.area) / disc.area(), 1.0, 1e-9);
        Vec2 centre = Vec2::Zero();
        for (std::size_t p = 0; p < points.x.size(); ++p) centre += points.area[p] * points.x[p] / disc.area();
        EXPECT_NEAR((centre - Vec2(0.01, -0.02)).norm(), 0.0, 1e-9);
      }
}

TEST(SeedFromGrid, BodyBeyondTheGridIsRefused) {
  const Region box(Shape{Box{Vec2(-0.2, -0.2), Vec2(0.7, 0.2)}});
  EXPECT_THROW(seed_from_grid(box, grid_of(GridKind::quads, 0.1, 10), {}, "box"), InputError);
}

/// The definition of the fit: per cell the area and the first moment of body and cell (computed by clipping).
TEST(FitToCells, AreaAndCentroidOfEveryCellAreThoseOfTheBodyInIt) {
  const Shape shape{Box{Vec2(-0.23, -0.31), Vec2(0.24, 0.29)}};
  const Region region(shape);
  for (GridKind kind : {GridKind::quads, GridKind::union_jack}) {
    const Grid grid = grid_of(kind, 0.0648148, 14);
    BodyMeshOptions options;
    options.kind = BodyMeshKind::triangles;
    options.size = 0.075;
    options.structured = true;
    SeededPoints points = seed_from_mesh(mesh_shape(shape, options), 3);
    fit_to_cells(points, region, grid);
    EXPECT_NEAR(sum(points.area) / region.area(), 1.0, 1e-9);

    std::vector<double> area(grid.mesh.n_cells(), 0.0);
    std::vector<Vec2> moment(grid.mesh.n_cells(), Vec2::Zero());
    for (std::size_t p = 0; p < points.x.size(); ++p) {
      const int cell = grid.locator->locate(points.x[p], -1);
      area[cell] += points.area[p];
      moment[cell] += points.area[p] * (points.x[p] + points.shift[p]);
    }
    for (int c = 0; c < grid.mesh.n_cells(); ++c) {
      std::vector<Vec2> polygon;
      for (int k = 0; k < nodes_of(grid.mesh.kinds[c]); ++k) polygon.push_back(grid.mesh.nodes[grid.mesh.cell(c)[k]]);
      const Piece piece = region.clip(polygon);
      EXPECT_NEAR(area[c], piece.area, 1e-12);
      EXPECT_NEAR((moment[c] - piece.area * piece.centroid).norm(), 0.0, 1e-12);
    }
  }
}

TEST(SeedFromMesh, EveryRuleKeepsTheArea) {
  const Shape shape{Box{Vec2(0.0, 0.0), Vec2(0.3, 0.2)}};
  BodyMeshOptions options;
  options.size = 0.05;
  options.structured = true;
  for (int n : {1, 4, 9, 16}) {
    const SeededPoints points = seed_from_mesh(mesh_shape(shape, options), n);
    EXPECT_EQ(points.x.size(), 24u * n);
    EXPECT_NEAR(sum(points.area), 0.06, 1e-14);
  }
  EXPECT_THROW(seed_from_mesh(mesh_shape(shape, options), 6), InputError);
  options.kind = BodyMeshKind::triangles;
  EXPECT_THROW(seed_from_mesh(mesh_shape(shape, options), 4), InputError);
  for (int n : {1, 3, 6, 12}) {
    const SeededPoints points = seed_from_mesh(mesh_shape(shape, options), n);
    EXPECT_EQ(points.x.size(), 48u * n);
    EXPECT_NEAR(sum(points.area), 0.06, 1e-14);
  }
}

}  // namespace
}  // namespace berm
