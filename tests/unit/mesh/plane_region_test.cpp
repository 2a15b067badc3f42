#include "mesh/plane_region.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <random>

#include "base/error.hpp"

using namespace berm;

namespace {

const double pi = std::acos(-1.0);

PlaneShape box(double x0, double y0, double x1, double y1) { return {Box{Vec2(x0, y0), Vec2(x1, y1)}}; }
PlaneShape disc(double x, double y, double r) { return {Disc{Vec2(x, y), r}}; }
PlaneShape join(std::vector<PlaneShape> parts) { return {Combination{Combination::Kind::join, std::move(parts)}}; }
PlaneShape minus(std::vector<PlaneShape> parts) {
  return {Combination{Combination::Kind::difference, std::move(parts)}};
}

/// A plate with four slits of 5 mm, open to its edges.
PlaneShape slit_specimen() {
  return minus({box(-0.15, 0, 0.15, 0.15), box(-0.0775, 0, -0.0725, 0.02), box(0.0725, 0, 0.0775, 0.02),
                box(-0.0775, 0.13, -0.0725, 0.15), box(0.0725, 0.13, 0.0775, 0.15)});
}

double boundary_length(const PlaneRegion& region, double spacing) {
  double length = 0.0;
  for (const PlaneBoundaryPiece& p : region.boundary(spacing)) {
    EXPECT_LE(p.length, spacing * (1 + 1e-9));
    EXPECT_NEAR(p.normal.norm(), 1.0, 1e-14);
    length += p.length;
  }
  return length;
}

/// Divergence theorem: the integral of x.n over the boundary is twice the area.
double area_by_boundary(const PlaneRegion& region, double spacing) {
  double sum = 0.0;
  for (const PlaneBoundaryPiece& p : region.boundary(spacing)) sum += 0.5 * p.centre.dot(p.normal) * p.length;
  return sum;
}

std::vector<std::vector<Vec2>> cells(const Vec2& low, const Vec2& high, int n, double angle = 0.0) {
  std::vector<std::vector<Vec2>> out;
  const Vec2 h = (high - low) / n;
  const auto at = [&](int i, int j) {
    const Vec2 x = low + Vec2(i * h.x(), j * h.y());
    return Vec2(std::cos(angle) * x.x() - std::sin(angle) * x.y(), std::sin(angle) * x.x() + std::cos(angle) * x.y());
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) out.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  return out;
}

/// Clips over a grid must add up to the region, and agree with the classes.
void expect_clips_add_up(const PlaneRegion& region, const Vec2& centroid, double extent, int n, double angle) {
  const auto polygons = cells(Vec2(-extent, -extent), Vec2(extent, extent), n, angle);
  const auto classes = region.classify(polygons);
  ASSERT_EQ(classes.size(), polygons.size());
  const double cell = std::pow(2 * extent / n, 2);
  double area = 0.0;
  Vec2 moment = Vec2::Zero();
  for (std::size_t k = 0; k < polygons.size(); ++k) {
    const PlanePiece piece = region.clip(polygons[k]);
    area += piece.area;
    moment += piece.area * piece.centroid;
    if (classes[k] == 1) {
      EXPECT_NEAR(piece.area, cell, 1e-11 * cell);
    }
    if (classes[k] == 0) {
      EXPECT_EQ(piece.area, 0.0);
    }
    if (classes[k] == -1) {
      EXPECT_TRUE(piece.area > 0.0 && piece.area < cell) << piece.area;
    }
  }
  EXPECT_NEAR(area, region.area(), 1e-12 * region.area());
  EXPECT_LT((moment / area - centroid).norm(), 1e-12 * extent + 1e-12);
}

}  // namespace

TEST(PlaneRegion, AreasAndExtents) {
  EXPECT_NEAR(PlaneRegion(disc(0.1, -0.2, 0.075)).area(), pi * 0.075 * 0.075, 1e-14);
  EXPECT_NEAR(PlaneRegion(box(-1, 2, 3, 4)).area(), 8.0, 1e-14);
  const PlaneShape clockwise{Polygon{{{0, 0}, {0, 2}, {1, 2}, {1, 1}, {3, 1}, {3, 0}}}};
  EXPECT_NEAR(PlaneRegion(clockwise).area(), 4.0, 1e-14);
  const PlaneRegion ring(minus({disc(0, 0, 2), disc(0, 0, 1)}));
  EXPECT_NEAR(ring.area(), 3 * pi, 1e-12);
  EXPECT_LT((ring.min() - Vec2(-2, -2)).norm(), 1e-14);
  EXPECT_LT((ring.max() - Vec2(2, 2)).norm(), 1e-14);
  EXPECT_EQ(ring.rings().size(), 2u);
  EXPECT_NEAR(PlaneRegion(slit_specimen()).area(), 0.3 * 0.15 - 4 * 0.005 * 0.02, 1e-15);
  EXPECT_NEAR(PlaneRegion(join({box(0, 0, 1, 1), box(1, 0, 2, 1), box(0.5, 0.5, 1.5, 2)})).area(), 3.0, 1e-14);
}

TEST(PlaneRegion, HalfDiscExtents) {
  const PlaneRegion half(minus({disc(0, 0, 1), box(-2, -2, 2, 0)}));
  EXPECT_LT((half.min() - Vec2(-1, 0)).norm(), 1e-4);
  EXPECT_LT((half.max() - Vec2(1, 1)).norm(), 1e-14 + 1e-4);
  EXPECT_NEAR(half.area(), pi / 2, 1e-12);
}

TEST(PlaneRegion, RefusesBadShapes) {
  EXPECT_THROW(PlaneRegion(PlaneShape{Polygon{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}}}), InputError);
  EXPECT_THROW(PlaneRegion(PlaneShape{Polygon{{{0, 0}, {1, 1}, {2, 2}}}}), InputError);
  EXPECT_THROW(PlaneRegion(PlaneShape{Polygon{{{0, 0}, {1, 1}}}}), InputError);
  EXPECT_THROW(PlaneRegion(PlaneShape{Polygon{{{0, 0}, {1, 0}, {std::nan(""), 1}}}}), InputError);
  EXPECT_THROW(PlaneRegion(box(0, 0, 0, 1)), InputError);
  EXPECT_THROW(PlaneRegion(disc(0, 0, -1)), InputError);
  EXPECT_THROW(PlaneRegion(minus({box(0, 0, 1, 1), box(-1, -1, 2, 2)})), InputError);
  EXPECT_THROW(PlaneRegion(join({})), InputError);
}

TEST(PlaneRegion, ContainsCountsTheBoundary) {
  const PlaneRegion region(slit_specimen());
  EXPECT_TRUE(region.contains(Vec2(0, 0)));
  EXPECT_TRUE(region.contains(Vec2(-0.15, 0.15)));
  EXPECT_TRUE(region.contains(Vec2(-0.0775, 0.01)));
  EXPECT_TRUE(region.contains(Vec2(0.075, 0.02)));
  EXPECT_TRUE(region.contains(Vec2(0.1, 0.13)));
  EXPECT_FALSE(region.contains(Vec2(0.075, 0.0199)));
  EXPECT_FALSE(region.contains(Vec2(0.15 + 1e-9, 0.05)));
  const PlaneRegion ring(minus({disc(0, 0, 2), disc(0, 0, 1)}));
  EXPECT_FALSE(ring.contains(Vec2(0.5, 0.5)));
  EXPECT_TRUE(ring.contains(Vec2(1.2, 0.5)));
}

TEST(PlaneRegion, ClipsAddUp) {
  for (double angle : {0.0, 0.37})
    for (int n : {1, 7, 40}) {
      expect_clips_add_up(PlaneRegion(disc(0.01, 0.02, 0.075)), Vec2(0.01, 0.02), 0.2, n, angle);
      expect_clips_add_up(PlaneRegion(slit_specimen()), Vec2(0, 0.075), 0.3, n, angle);
      expect_clips_add_up(PlaneRegion(minus({disc(0, 0, 0.1), disc(0, 0, 0.03)})), Vec2(0, 0), 0.2, n, angle);
      expect_clips_add_up(PlaneRegion(minus({box(-0.1, -0.1, 0.1, 0.1), disc(0, 0, 0.05)})), Vec2(0, 0), 0.2, n, angle);
    }
}

TEST(PlaneRegion, GridAlignedBoxCutsNothing) {
  const PlaneRegion region(box(0, 0, 0.1, 0.3));
  int inside = 0;
  for (signed char c : region.classify(cells(Vec2(-0.1, -0.1), Vec2(0.4, 0.4), 50))) {
    EXPECT_NE(c, -1);
    inside += c == 1;
  }
  EXPECT_EQ(inside, 300);
}

TEST(PlaneRegion, ClassifyIsFast) {
  const PlaneRegion region(disc(0, 0, 0.075));
  const auto polygons = cells(Vec2(-0.1, -0.1), Vec2(0.1, 0.1), 283);
  const auto start = std::chrono::steady_clock::now();
  const auto classes = region.classify(polygons);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  RecordProperty("milliseconds", static_cast<int>(1000 * seconds));
  EXPECT_LT(seconds, 1.0);
  EXPECT_EQ(classes.size(), 80089u);
}

TEST(PlaneRegion, CircleBoundaryIsTheTrueCircle) {
  const Vec2 centre(0.3, -0.1);
  const PlaneRegion region(disc(0.3, -0.1, 0.075));
  const auto pieces = region.boundary(0.002);
  EXPECT_EQ(pieces.size() % 4, 0u);
  double length = 0.0;
  for (const PlaneBoundaryPiece& p : pieces) {
    EXPECT_NEAR((p.centre - centre).norm(), 0.075, 1e-15);
    EXPECT_LT((p.normal - (p.centre - centre) / 0.075).norm(), 1e-13);
    EXPECT_NEAR(p.length, pieces[0].length, 1e-16);
    length += p.length;
  }
  EXPECT_NEAR(length, 2 * pi * 0.075, 1e-14);
}

TEST(PlaneRegion, BoundaryLengthsAndNormals) {
  const PlaneRegion specimen(slit_specimen());
  EXPECT_NEAR(boundary_length(specimen, 0.003), 0.9 + 8 * 0.02, 1e-13);
  EXPECT_NEAR(area_by_boundary(specimen, 0.003), specimen.area(), 1e-15);

  const PlaneRegion ring(minus({disc(0, 0, 2), disc(0, 0, 1)}));
  EXPECT_NEAR(boundary_length(ring, 0.05), 6 * pi, 1e-12);
  EXPECT_NEAR(area_by_boundary(ring, 0.05), ring.area(), 1e-12);

  const PlaneRegion half(minus({disc(0, 0, 1), box(-2, -2, 2, 0)}));
  EXPECT_NEAR(boundary_length(half, 0.01), pi + 2, 1e-12);
  EXPECT_NEAR(area_by_boundary(half, 0.01), half.area(), 2e-5);
  int straight = 0;
  for (const PlaneBoundaryPiece& p : half.boundary(0.01))
    if (p.centre.y() < 1e-12) {
      EXPECT_LT((p.normal - Vec2(0, -1)).norm(), 1e-12);
      ++straight;
    } else {
      EXPECT_NEAR(p.centre.norm(), 1.0, 1e-12);
    }
  EXPECT_NEAR(straight, 200, 1);
}

TEST(PlaneRegion, CollinearSidesAreOneSide) {
  const PlaneShape with_extra{Polygon{{{0, 0}, {0.3, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0.4}}}};
  EXPECT_EQ(PlaneRegion(with_extra).boundary(0.5).size(), 8u);
  EXPECT_EQ(PlaneRegion(join({box(0, 0, 1, 1), box(1, 0, 2, 1)})).boundary(10.0).size(), 4u);
}

TEST(PlaneRegion, NearestOnBox) {
  const PlaneRegion region(box(0, 0, 2, 1));
  const auto below = region.nearest(Vec2(0.7, -0.2));
  EXPECT_NEAR(below.distance, 0.2, 1e-15);
  EXPECT_LT((below.point - Vec2(0.7, 0)).norm(), 1e-15);
  EXPECT_LT((below.normal - Vec2(0, -1)).norm(), 1e-15);
  const auto inside = region.nearest(Vec2(0.7, 0.2));
  EXPECT_NEAR(inside.distance, -0.2, 1e-15);
  EXPECT_LT((inside.normal - Vec2(0, -1)).norm(), 1e-15);
  const auto corner = region.nearest(Vec2(2.3, 1.4));
  EXPECT_NEAR(corner.distance, 0.5, 1e-15);
  EXPECT_LT((corner.normal - Vec2(0.6, 0.8)).norm(), 1e-14);
  EXPECT_NEAR(region.nearest(Vec2(2, 1)).distance, 0.0, 1e-15);
}

TEST(PlaneRegion, NearestIsTheSignedDistance) {
  const PlaneRegion ring(minus({disc(0, 0, 2), disc(0, 0, 1)}));
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-3, 3);
  for (int k = 0; k < 500; ++k) {
    const Vec2 x(u(random), u(random));
    const double r = x.norm(), exact = std::max(r - 2, 1 - r);
    const auto nearest = ring.nearest(x);
    EXPECT_NEAR(nearest.distance, exact, 1e-13);
    EXPECT_LT((nearest.point + nearest.distance * nearest.normal - x).norm(), 1e-12);
  }
  const auto on_circle = PlaneRegion(disc(0, 0, 1)).nearest(Vec2(0.6 * 1.000001, 0.8 * 1.000001));
  EXPECT_NEAR(on_circle.distance, 1e-6, 1e-12);
}

TEST(PlaneRegion, NearestAtReentrantCornerAndArcEnds) {
  const PlaneShape ell{Polygon{{{0, 0}, {2, 0}, {2, 1}, {1, 1}, {1, 2}, {0, 2}}}};
  const auto corner = PlaneRegion(ell).nearest(Vec2(0.97, 0.96));
  EXPECT_NEAR(corner.distance, -0.05, 1e-14);
  EXPECT_LT((corner.normal - Vec2(0.6, 0.8)).norm(), 1e-12);
  const PlaneRegion half(minus({disc(0, 0, 1), box(-2, -2, 2, 0)}));
  EXPECT_NEAR(half.nearest(Vec2(1.3, -0.4)).distance, 0.5, 1e-4);
}
