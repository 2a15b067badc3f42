#include "mesh/solid_region.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <random>

#include "base/error.hpp"
#include "mesh/gmsh_solid.hpp"

using namespace berm;

namespace {

const double pi = std::acos(-1.0);

SolidShape box(const Vec3& a, const Vec3& b) { return {SolidBox{a, b}}; }
SolidShape cylinder(const Vec3& a, const Vec3& b, double r) { return {Cylinder{a, b, r}}; }
SolidShape sphere(const Vec3& c, double r) { return {Sphere{c, r}}; }
SolidShape join(std::vector<SolidShape> parts) {
  return {SolidCombination{SolidCombination::Kind::join, std::move(parts)}};
}
SolidShape minus(std::vector<SolidShape> parts) {
  return {SolidCombination{SolidCombination::Kind::difference, std::move(parts)}};
}
SolidRegion region(const SolidShape& shape, double size) { return SolidRegion(triangulate(shape, size)); }

std::array<Vec3, 8> corners_of_box(const Vec3& a, const Vec3& b) {
  return {Vec3(a.x(), a.y(), a.z()), Vec3(b.x(), a.y(), a.z()), Vec3(b.x(), b.y(), a.z()), Vec3(a.x(), b.y(), a.z()),
          Vec3(a.x(), a.y(), b.z()), Vec3(b.x(), a.y(), b.z()), Vec3(b.x(), b.y(), b.z()), Vec3(a.x(), b.y(), b.z())};
}
ConvexCell box_cell(const Vec3& a, const Vec3& b) { return hexahedron_cell(corners_of_box(a, b)); }
ConvexCell turned(ConvexCell cell, const Eigen::Matrix3d& rotation, const Vec3& shift = Vec3::Zero()) {
  for (Vec3& x : cell.vertices) x = rotation * x + shift;
  return cell;
}
Eigen::Matrix3d rotation(double angle, const Vec3& axis) {
  return Eigen::AngleAxisd(angle, axis.normalized()).toRotationMatrix();
}

/// Volume and centroid of a whole region, from clipping by one cell around it.
SolidPiece all_of(const SolidRegion& r) {
  const Vec3 margin = 0.1 * (r.max() - r.min());
  return r.clip(box_cell(r.min() - margin, r.max() + margin));
}

void expect_body(const SolidRegion& r, double volume, const Vec3& centroid, double tolerance, bool curved = true) {
  EXPECT_NEAR(r.volume(), volume, tolerance * volume);
  const SolidPiece all = all_of(r);
  EXPECT_NEAR(all.volume, r.volume(), 1e-11 * volume);
  // Faceting leaves the volume alone, but moves the centroid of an irregular mesh a little.
  const double size = (r.max() - r.min()).norm();
  EXPECT_LT((all.centroid - centroid).norm(), (curved ? 1e-6 : 1e-13) * size);
  EXPECT_NO_THROW(check_closed(r.surface(), "surface"));
}

struct Sum {
  double volume = 0.0;
  Vec3 moment = Vec3::Zero();
  void add(const SolidPiece& p) {
    volume += p.volume;
    moment += p.volume * p.centroid;
  }
};

BoxGrid grid_around(const SolidRegion& r, int n, double margin) {
  const Vec3 m = margin * (r.max() - r.min());
  return {r.min() - m, (r.max() - r.min() + 2.0 * m) / n, {n, n, n}, {1, 1, 1}};
}

/// The grid adds up to the body, and each of its boxes agrees with a clip of that box alone.
void expect_grid(const SolidRegion& r, const BoxGrid& grid) {
  std::map<std::array<int, 3>, std::pair<SolidPiece, bool>> found;
  Sum sum;
  r.for_each_box(grid, [&](int i, int j, int k, const SolidPiece& piece, bool full) {
    EXPECT_TRUE((found.emplace(std::array<int, 3>{i, j, k}, std::pair(piece, full)).second));
    EXPECT_GT(piece.volume, 0.0);
    sum.add(piece);
  });
  EXPECT_NEAR(sum.volume, r.volume(), 1e-10 * r.volume());
  const SolidPiece all = all_of(r);
  EXPECT_LT((sum.moment / sum.volume - all.centroid).norm(), 1e-10 * (r.max() - r.min()).norm());
  double cell = 1.0;
  for (int d = 0; d < 3; ++d) cell *= grid.cell[d] / grid.divisions[d];
  const double length = std::cbrt(cell);
  for (int k = 0; k < grid.cells[2] * grid.divisions[2]; ++k)
    for (int j = 0; j < grid.cells[1] * grid.divisions[1]; ++j)
      for (int i = 0; i < grid.cells[0] * grid.divisions[0]; ++i) {
        const Vec3 low(grid.plane(0, i), grid.plane(1, j), grid.plane(2, k)),
            high(grid.plane(0, i + 1), grid.plane(1, j + 1), grid.plane(2, k + 1));
        const SolidPiece alone = r.clip(box_cell(low, high));
        const auto place = found.find({i, j, k});
        const double volume = place == found.end() ? 0.0 : place->second.first.volume;
        ASSERT_NEAR(volume, alone.volume, 3e-12 * cell) << i << " " << j << " " << k;
        if (volume > 1e-6 * cell) {
          ASSERT_LT((place->second.first.centroid - alone.centroid).norm(), 1e-5 * length);
        }
        if (place != found.end() && place->second.second) {
          ASSERT_NEAR(alone.volume, cell, 3e-12 * cell);
        }
      }
}

std::vector<SolidRegion> assorted_bodies() {
  std::vector<SolidRegion> bodies;
  bodies.push_back(region(box({-0.1, 0.2, 0}, {0.3, 0.5, 0.2}), 0.1));
  bodies.push_back(region(cylinder({0, 0, 0}, {0, 0, 0.2}, 0.05), 0.01));
  bodies.push_back(region(cylinder({0, 0.01, 0}, {0.1, 0.11, 0.05}, 0.03), 0.02));
  bodies.push_back(region(sphere({0.1, 0.2, 0.3}, 0.07), 0.02));
  bodies.push_back(region(minus({box({0, 0, 0}, {1, 1, 1}), sphere({0.5, 0.5, 0.5}, 0.3)}), 0.2));
  bodies.push_back(region(minus({cylinder({0, 0, 0}, {0, 0, 2}, 1), cylinder({0, 0, 0}, {0, 0, 2}, 0.5)}), 0.3));
  return bodies;
}

}  // namespace

TEST(SolidRegion, Primitives) {
  expect_body(region(box({-1, 2, 0}, {3, 4, 0.5}), 0.3), 4.0, Vec3(1, 3, 0.25), 1e-13, false);
  expect_body(region(cylinder({0, 0, 0}, {0, 0, 0.2}, 0.05), 0.01), pi * 0.0025 * 0.2, Vec3(0, 0, 0.1), 1e-12);
  const Vec3 from(0.1, 0.2, -0.1), to(0.4, -0.2, 0.3);
  expect_body(region(cylinder(from, to, 0.1), 0.03), pi * 0.01 * (to - from).norm(), 0.5 * (from + to), 1e-12);
  expect_body(region(sphere({1, -2, 3}, 0.5), 0.1), 4.0 / 3.0 * pi * 0.125, Vec3(1, -2, 3), 1e-12);
  // An L of thickness 2, clockwise.
  const SolidShape ell{Extrusion{{{0, 0}, {0, 2}, {1, 2}, {1, 1}, {3, 1}, {3, 0}}, -1, 1}};
  expect_body(region(ell, 0.5), 8.0, Vec3(1.25, 0.75, 0), 1e-13, false);
}

TEST(SolidRegion, Combinations) {
  const SolidShape tube = minus({cylinder({0, 0, 0}, {0, 0, 2}, 1), cylinder({0, 0, -1}, {0, 0, 3}, 0.5)});
  expect_body(region(tube, 0.2), 1.5 * pi, Vec3(0, 0, 1), 1e-11);
  const SolidShape hollow = minus({box({0, 0, 0}, {1, 1, 1}), sphere({0.5, 0.5, 0.5}, 0.3)});
  expect_body(region(hollow, 0.1), 1.0 - 4.0 / 3.0 * pi * 0.027, Vec3(0.5, 0.5, 0.5), 1e-11);
  const SolidShape boxes =
      join({box({0, 0, 0}, {1, 1, 1}), box({1, 0, 0}, {2, 1, 1}), box({0.5, 0.5, 0.5}, {1.5, 2, 1.5})});
  EXPECT_NEAR(region(boxes, 1.0).volume(), 3.25, 1e-13);
  // Two unit spheres at the distance 1 share a lens of volume 5 pi / 12.
  const SolidShape pair = join({sphere({0, 0, 0}, 1), sphere({1, 0, 0}, 1)});
  expect_body(region(pair, 0.2), 8.0 / 3.0 * pi - 5.0 * pi / 12.0, Vec3(0.5, 0, 0), 1e-7);
  // Two crossing cylinders share 16 / 3 r^3.
  const SolidShape cross = join({cylinder({-3, 0, 0}, {3, 0, 0}, 1), cylinder({0, -3, 0}, {0, 3, 0}, 1)});
  expect_body(region(cross, 0.3), 12.0 * pi - 16.0 / 3.0, Vec3(0, 0, 0), 1e-6);
  const SolidShape apart =
      minus({join({box({0, 0, 0}, {1, 1, 1}), box({2, 1, 0}, {3, 2, 1})}), box({-1, 0.2, 0.2}, {5, 0.4, 5})});
  EXPECT_NEAR(region(apart, 1.0).volume(), 2.0 - 0.2 * 0.8, 1e-13);
}

TEST(SolidRegion, PartsThatTouchAlongAnEdge) {
  const SolidRegion r = region(join({box({0, 0, 0}, {1, 1, 1}), box({1, 1, 0}, {2, 2, 1})}), 1.0);
  EXPECT_NEAR(r.volume(), 2.0, 1e-13);
  EXPECT_TRUE(r.contains({1.5, 1.5, 0.5}));
  EXPECT_TRUE(r.contains({0.5, 0.5, 0.5}));
  EXPECT_FALSE(r.contains({1.001, 0.999, 0.5}));
  EXPECT_FALSE(r.contains({0.5, 1.5, 0.5}));
}

TEST(SolidRegion, HalfSphere) {
  const SolidRegion half = region(minus({sphere({0, 0, 0}, 1), box({-2, -2, -2}, {2, 2, 0})}), 0.05);
  EXPECT_NEAR(half.volume(), 2.0 / 3.0 * pi, 1e-11);
  EXPECT_NEAR(half.min().z(), 0.0, 1e-15);
  EXPECT_NEAR(all_of(half).centroid.z(), 3.0 / 8.0, 1e-5);
  // The same half by clipping: first moment pi / 4.
  const SolidRegion whole = region(sphere({0, 0, 0}, 1), 0.05);
  const SolidPiece upper = whole.clip(box_cell({-2, -2, 0}, {2, 2, 2}));
  EXPECT_NEAR(upper.volume, 2.0 / 3.0 * pi, 2e-5);
  EXPECT_NEAR(upper.volume * upper.centroid.z(), pi / 4.0, 3e-5);
  // The cap above z = 1/2: pi h^2 (3 - h) / 3 with h = 1/2; in a turned cell.
  const Eigen::Matrix3d q = rotation(0.7, {1, 2, -1});
  const SolidPiece cap = whole.clip(turned(box_cell({-2, -2, 0.5}, {2, 2, 2}), q));
  EXPECT_NEAR(cap.volume, pi * 0.25 * 2.5 / 3.0, 1e-4);
  EXPECT_NEAR((q.transpose() * cap.centroid).z(), 0.75 * 1.5 * 1.5 / 2.5, 1e-4);
}

TEST(SolidRegion, GridsAddUp) {
  for (const SolidRegion& r : assorted_bodies())
    for (int n : {1, 3, 11}) expect_grid(r, grid_around(r, n, 0.0173));
}

TEST(SolidRegion, FacesInTheFacesOfCells) {
  for (const SolidRegion& r : assorted_bodies()) {
    expect_grid(r, grid_around(r, 8, 0.0));
    BoxGrid grid = grid_around(r, 4, 0.25);
    grid.divisions = {2, 1, 3};
    expect_grid(r, grid);
  }
  const SolidRegion r = region(box({0, 0, 0}, {0.1, 0.3, 0.2}), 0.1);
  int full = 0;
  r.for_each_box({Vec3(-0.1, -0.1, -0.1), Vec3(0.02, 0.02, 0.02), {25, 25, 25}, {1, 1, 1}},
                 [&](int, int, int, const SolidPiece& piece, bool is_full) {
                   EXPECT_TRUE(is_full);
                   EXPECT_NEAR(piece.volume, 8e-6, 1e-17);
                   ++full;
                 });
  EXPECT_EQ(full, 5 * 15 * 10);
}

TEST(SolidRegion, GridBeyondAndWithinTheBody) {
  const SolidRegion r = region(box({0, 0, 0}, {1, 1, 1}), 1.0);
  Sum sum;
  r.for_each_box({Vec3(0.5, 0.25, -1), Vec3(0.1, 0.1, 0.7), {20, 5, 2}, {1, 2, 2}},
                 [&](int, int, int, const SolidPiece& piece, bool) { sum.add(piece); });
  EXPECT_NEAR(sum.volume, 0.5 * 0.5 * 0.4, 1e-13);
  EXPECT_LT((sum.moment / sum.volume - Vec3(0.75, 0.5, 0.2)).norm(), 1e-13);
  r.for_each_box({Vec3(2, 2, 2), Vec3(1, 1, 1), {3, 3, 3}, {1, 1, 1}},
                 [&](int, int, int, const SolidPiece&, bool) { FAIL(); });
}

TEST(SolidRegion, ClipsOfABox) {
  const SolidRegion r = region(box({0, 0, 0}, {2, 2, 2}), 1.0);
  const SolidPiece corner = r.clip(box_cell({1.5, 1, -1}, {4, 5, 1}));
  EXPECT_NEAR(corner.volume, 0.5, 1e-14);
  EXPECT_LT((corner.centroid - Vec3(1.75, 1.5, 0.5)).norm(), 1e-14);
  EXPECT_EQ(r.clip(box_cell({2, 0, 0}, {3, 1, 1})).volume, 0.0);
  EXPECT_EQ(r.clip(box_cell({5, 0, 0}, {6, 1, 1})).volume, 0.0);
  EXPECT_NEAR(r.clip(box_cell({0, 0, 0}, {2, 2, 2})).volume, 8.0, 1e-12);
  EXPECT_NEAR(r.clip(box_cell({0.5, 0.5, 0.5}, {1, 1, 1})).volume, 0.125, 1e-15);
  // A bar of section 1 x 1 turned by 45 degrees about z through the middle edge x = y = 0: half of it is cut off by
  // each wall; what is left is a triangle of area 1/2 in the corner.
  const ConvexCell bar = turned(box_cell({0, -0.5, 0}, {1, 0.5, 1}), rotation(pi / 4, {0, 0, 1}));
  const SolidPiece left = r.clip(bar);
  // The section is the square with corners (s/2)(1,-1), (3s/2, s/2), (s/2, 3s/2), (s/2)(-1, 1), s = 1/sqrt(2): the
  // walls cut off the two triangles of area 1/8 each below x = 0 and y = 0.
  EXPECT_NEAR(left.volume, 0.75, 1e-14);
  EXPECT_NEAR(left.centroid.x(), left.centroid.y(), 1e-14);
  EXPECT_NEAR(left.centroid.z(), 0.5, 1e-14);
  // First moment along the bar: the square gives 1/2, each triangle 1/8 * 1/6.
  EXPECT_NEAR((left.centroid.x() + left.centroid.y()) / std::sqrt(2.0) * 0.75, 0.5 - 2.0 / 48.0, 1e-14);
  // A tetrahedron whose corner with right angles is the centre of the body.
  const SolidPiece inner = r.clip(tetrahedron_cell({Vec3(1, 1, 1), Vec3(1.5, 1, 1), Vec3(1, 1.5, 1), Vec3(1, 1, 1.5)}));
  EXPECT_NEAR(inner.volume, 0.125 / 6.0, 1e-16);
  EXPECT_LT((inner.centroid - Vec3::Constant(1.125)).norm(), 1e-14);
  // x + y + z <= 3 from the origin: 4.5 less three corners of side 1.
  const SolidPiece outer = r.clip(tetrahedron_cell({Vec3(0, 0, 0), Vec3(3, 0, 0), Vec3(0, 3, 0), Vec3(0, 0, 3)}));
  EXPECT_NEAR(outer.volume, 4.5 - 3.0 / 6.0, 1e-13);
  const double moment = 4.5 * 0.75 - (2.25 + 2.0 * 0.25) / 6.0;
  EXPECT_LT((outer.centroid - Vec3::Constant(moment / 4.0)).norm(), 1e-13);
}

TEST(SolidRegion, TurnedBodiesInTurnedCells) {
  const SolidRegion r = region(minus({box({0, 0, 0}, {1, 1, 1}), cylinder({0.5, 0.5, -1}, {0.5, 0.5, 2}, 0.2)}), 0.2);
  const Eigen::Matrix3d q = rotation(0.9, {1, 0.5, 2});
  Sum sum;
  constexpr int n = 9;
  const double h = 2.4 / n;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const Vec3 low(-1.2 + i * h, -1.2 + j * h, -1.2 + k * h);
        sum.add(r.clip(turned(box_cell(low, low + Vec3(h, h, h)), q, Vec3(0.5, 0.5, 0.5))));
      }
  EXPECT_NEAR(sum.volume, 1.0 - 0.04 * pi, 1e-11);
  EXPECT_LT((sum.moment / sum.volume - all_of(r).centroid).norm(), 1e-11);
}

/// Cells with warped faces share triangles with their neighbours, so nothing is lost or counted twice.
TEST(SolidRegion, DistortedCellsAddUp) {
  const SolidRegion r = region(sphere({0.5, 0.5, 0.5}, 0.4), 0.1);
  constexpr int n = 6;
  std::mt19937 random(7);
  std::uniform_real_distribution<double> shake(-0.2 / n, 0.2 / n);
  std::vector<Vec3> nodes;
  for (int k = 0; k <= n; ++k)
    for (int j = 0; j <= n; ++j)
      for (int i = 0; i <= n; ++i) {
        Vec3 x(i, j, k);
        x /= n;
        if (i % n != 0 && j % n != 0 && k % n != 0) x += Vec3(shake(random), shake(random), shake(random));
        nodes.push_back(x);
      }
  const auto node = [&](int i, int j, int k) { return nodes[(k * (n + 1) + j) * (n + 1) + i]; };
  Sum hexahedra, tetrahedra;
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        const std::array<Vec3, 8> c = {
            node(i, j, k),     node(i + 1, j, k),     node(i + 1, j + 1, k),     node(i, j + 1, k),
            node(i, j, k + 1), node(i + 1, j, k + 1), node(i + 1, j + 1, k + 1), node(i, j + 1, k + 1)};
        hexahedra.add(r.clip(hexahedron_cell(c)));
        for (const std::array<int, 4>& t : {std::array{0, 1, 2, 6}, std::array{0, 2, 3, 6}, std::array{0, 3, 7, 6},
                                            std::array{0, 7, 4, 6}, std::array{0, 4, 5, 6}, std::array{0, 5, 1, 6}})
          tetrahedra.add(r.clip(tetrahedron_cell({c[t[0]], c[t[1]], c[t[2]], c[t[3]]})));
      }
  for (const Sum& sum : {hexahedra, tetrahedra}) {
    EXPECT_NEAR(sum.volume, r.volume(), 1e-11 * r.volume());
    EXPECT_LT((sum.moment / sum.volume - all_of(r).centroid).norm(), 1e-11);
  }
}

TEST(SolidRegion, Contains) {
  const Vec3 from(0.1, 0.2, 0.0), to(0.5, 0.3, 0.6);
  const SolidRegion tube = region(minus({cylinder(from, to, 0.2), cylinder(from, to, 0.1)}), 0.05);
  const Vec3 axis = (to - from).normalized();
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  int tested = 0;
  for (int n = 0; n < 100000; ++n) {
    const Vec3 x = (tube.min() + (tube.max() - tube.min()).cwiseProduct(1.1 * Vec3(u(random), u(random), u(random))));
    const double along = axis.dot(x - from), radius = (x - from - along * axis).norm();
    const double depth = std::min({0.2 - radius, radius - 0.1, along, (to - from).norm() - along});
    if (std::abs(depth) < 1e-3) continue;  // the height of the chords is 1.4e-4 to 3e-4
    ++tested;
    ASSERT_EQ(tube.contains(x), depth > 0.0) << x.transpose();
  }
  EXPECT_GT(tested, 95000);
}

TEST(SolidRegion, ContainsCountsTheBoundary) {
  const SolidRegion r = region(minus({box({0, 0, 0}, {1, 1, 1}), box({0.25, 0.25, 0.25}, {0.75, 0.75, 2})}), 1.0);
  for (const Vec3& x : {Vec3(0, 0, 0), Vec3(1, 1, 1), Vec3(0.3, 0, 0.9), Vec3(0.25, 0.5, 0.5), Vec3(0.5, 0.5, 0.25),
                        Vec3(0.1, 0.1, 1), Vec3(1, 0.123, 0.456), Vec3(-1e-14, 0.5, 0.1)})
    EXPECT_TRUE(r.contains(x)) << x.transpose();
  for (const Vec3& x : {Vec3(-1e-9, 0.5, 0.5), Vec3(0.25 + 1e-9, 0.5, 0.5), Vec3(0.5, 0.5, 0.25 + 1e-9),
                        Vec3(0.1, 0.1, 2), Vec3(std::nan(""), 0, 0)})
    EXPECT_FALSE(r.contains(x)) << x.transpose();
}

TEST(SolidRegion, Nearest) {
  const SolidRegion b = region(box({-1, -2, -3}, {1, 2, 3}), 1.0);
  std::mt19937 random(2);
  std::uniform_real_distribution<double> u(-1.5, 1.5);
  for (int n = 0; n < 5000; ++n) {
    const Vec3 x(u(random), 2 * u(random), 3 * u(random)), half(1, 2, 3);
    const Vec3 beyond = x.cwiseAbs() - half;
    const bool outside = beyond.maxCoeff() > 0.0;
    const double expected = outside ? beyond.cwiseMax(0.0).norm() : beyond.maxCoeff();
    const SolidRegion::Nearest nearest = b.nearest(x);
    ASSERT_NEAR(nearest.distance, expected, 1e-13);
    ASSERT_NEAR((x - nearest.point).norm(), std::abs(expected), 1e-13);
    ASSERT_LT((nearest.point + nearest.distance * nearest.normal - x).norm(), 1e-9);
  }
  const SolidRegion::Nearest corner = b.nearest({2, 3, 4});
  EXPECT_LT((corner.point - Vec3(1, 2, 3)).norm(), 1e-14);
  EXPECT_LT((corner.normal - Vec3(1, 1, 1).normalized()).norm(), 1e-14);
  EXPECT_NEAR(b.nearest({1, 0.3, 0.2}).distance, 0.0, 1e-14);
  EXPECT_LT((b.nearest({1, 0.3, 0.2}).normal - Vec3(1, 0, 0)).norm(), 1e-14);

  const SolidRegion s = region(sphere({1, 0, 0}, 0.5), 0.04);
  for (int n = 0; n < 5000; ++n) {
    const Vec3 x = Vec3(1, 0, 0) + 0.5 * Vec3(u(random), u(random), u(random));
    const double radius = (x - Vec3(1, 0, 0)).norm();
    const SolidRegion::Nearest nearest = s.nearest(x);
    ASSERT_NEAR(nearest.distance, radius - 0.5, 1e-3);
    if (radius > 0.1) {
      ASSERT_GT(nearest.normal.dot(x - Vec3(1, 0, 0)) / radius, std::cos(0.1));
    }
  }
}

TEST(SolidRegion, Boundary) {
  const auto check = [](const SolidRegion& r, double spacing, double area, double tolerance) {
    double total = 0.0, flux = 0.0;
    Vec3 sum = Vec3::Zero();
    for (const SolidBoundaryPiece& p : r.boundary(spacing)) {
      EXPECT_NEAR(p.normal.norm(), 1.0, 1e-14);
      EXPECT_LE(p.area, std::sqrt(3.0) / 4.0 * spacing * spacing * (1 + 1e-12));
      total += p.area;
      sum += p.area * p.normal;
      flux += p.area * p.normal.dot(p.centre) / 3.0;
    }
    EXPECT_NEAR(total, area, tolerance * area);
    EXPECT_LT(sum.norm(), tolerance * area);
    EXPECT_NEAR(flux, r.volume(), tolerance * r.volume());
  };
  for (double spacing : {10.0, 0.3, 0.05}) {
    check(region(box({0, 0, 0}, {1, 1, 2}), 1.0), spacing, 10.0, 1e-12);
    check(region(cylinder({0, 0, 0}, {0, 0, 1}, 0.5), 0.05), spacing, 1.5 * pi, 2e-3);
    check(region(sphere({0, 0, 0}, 0.5), 0.05), spacing, pi, 2e-3);
  }
  // True normals: those of the cylinder at the centres of the unsplit triangles.
  for (const SolidBoundaryPiece& p : region(cylinder({0, 0, 0}, {0, 0, 1}, 0.5), 0.05).boundary(10.0)) {
    if (std::abs(p.normal.z()) > 0.5) continue;
    EXPECT_LT((p.normal - Vec3(p.centre.x(), p.centre.y(), 0).normalized()).norm(), 2e-3);
  }
}

TEST(SolidRegion, RefusesBadShapes) {
  const auto message = [](const SolidShape& shape, double size = 0.1) -> std::string {
    try {
      triangulate(shape, size);
    } catch (const InputError& error) {
      return error.what();
    }
    return "accepted";
  };
  const auto has = [](const std::string& text, const char* part) { return text.find(part) != std::string::npos; };
  EXPECT_PRED2(has, message(box({0, 0, 0}, {1, 0, 1})), "is empty");
  EXPECT_PRED2(has, message(box({0, 0, 0}, {1, std::nan(""), 1})), "is empty");
  EXPECT_PRED2(has, message(cylinder({0, 0, 0}, {0, 0, 1}, 0)), "cylinder of radius 0");
  EXPECT_PRED2(has, message(cylinder({0, 0, 1}, {0, 0, 1}, 1)), "must be apart");
  EXPECT_PRED2(has, message(sphere({0, 0, 0}, -1)), "sphere of radius -1");
  EXPECT_PRED2(has, message({Extrusion{{{0, 0}, {1, 0}, {1, 1}}, 1, 1}}), "from must be below to");
  EXPECT_PRED2(has, message({Extrusion{{{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 0, 1}}), "crosses itself");
  EXPECT_PRED2(has, message({Extrusion{{{0, 0}, {1, 1}}, 0, 1}}), "2 vertices");
  EXPECT_PRED2(has, message(join({})), "without parts");
  EXPECT_PRED2(has, message(minus({box({0, 0, 0}, {1, 1, 1}), box({-1, -1, -1}, {2, 2, 2})})), "nothing is left");
  EXPECT_PRED2(has, message(join({box({0, 0, 0}, {1, 1, 1}), {SurfaceFile{"a.stl"}}})), "a.stl: an STL surface cannot");
  EXPECT_PRED2(has, message(sphere({0, 0, 0}, 1), 0.0), "must be positive");
  EXPECT_PRED2(has, message(sphere({0, 0, 0}, 1), 1e-5), "too many");
  EXPECT_PRED2(has, message({SurfaceFile{"/nowhere/a.stl"}}), "/nowhere/a.stl: cannot be read");
  // The next shape is none the worse for it.
  EXPECT_NEAR(volume(triangulate(box({0, 0, 0}, {1, 1, 1}), 1.0)), 1.0, 1e-14);
}

TEST(SolidRegion, TheSameTwice) {
  const SolidShape shape = minus({cylinder({0, 0, 0}, {0, 0, 2}, 1), sphere({0, 0, 2}, 0.5)});
  const TriangleSurface a = triangulate(shape, 0.2);
  mesh_solid(shape, 0.4, 2);
  const TriangleSurface b = triangulate(shape, 0.2);
  EXPECT_EQ(a.vertices, b.vertices);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_EQ(a.normals, b.normals);
}

namespace {

/// Volume of quadratic tetrahedra by a rule that is exact for the Jacobian (degree 3: corners 1/40, faces 9/40).
double volume_of(const SolidMesh& mesh) {
  constexpr int edges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  double volume = 0.0;
  for (std::size_t c = 0; c < mesh.connectivity.size(); c += mesh.nodes_per_cell) {
    const auto x = [&](int i) { return mesh.nodes[mesh.connectivity[c + i]]; };
    for (int q = 0; q < 8; ++q) {
      Eigen::Vector4d l = Eigen::Vector4d::Constant(q < 4 ? 0.0 : 1.0 / 3.0);
      l[q % 4] = q < 4 ? 1.0 : 0.0;
      Vec3 d[4];
      for (int i = 0; i < 4; ++i) d[i] = mesh.nodes_per_cell == 4 ? x(i) : Vec3((4.0 * l[i] - 1.0) * x(i));
      if (mesh.nodes_per_cell == 10)
        for (int e = 0; e < 6; ++e) {
          d[edges[e][0]] += 4.0 * l[edges[e][1]] * x(4 + e);
          d[edges[e][1]] += 4.0 * l[edges[e][0]] * x(4 + e);
        }
      const double jacobian = (d[1] - d[0]).dot((d[2] - d[0]).cross(d[3] - d[0]));
      EXPECT_GT(jacobian, 0.0);
      volume += jacobian / 6.0 * (q < 4 ? 1.0 / 40.0 : 9.0 / 40.0);
    }
  }
  return volume;
}

}  // namespace

TEST(SolidMesh, FillsTheBody) {
  const SolidShape cube = box({0, 0, 0}, {1, 2, 1});
  const SolidShape tube = minus({cylinder({0, 0, 0}, {0, 0, 1}, 1), cylinder({0, 0, 0}, {0, 0, 1}, 0.5)});
  for (int order : {1, 2}) {
    const SolidMesh mesh = mesh_solid(cube, 0.3, order);
    EXPECT_EQ(mesh.nodes_per_cell, order == 1 ? 4 : 10);
    EXPECT_NEAR(volume_of(mesh), 2.0, 1e-12);
    EXPECT_NEAR(volume_of(mesh_solid(tube, 0.3, order)), 0.75 * pi, order == 1 ? 0.1 : 2e-3);
    EXPECT_NEAR(volume_of(mesh_solid(sphere({1, 1, 1}, 0.5), 0.2, order)), pi / 6.0, order == 1 ? 0.05 : 2e-3);
  }
  const SolidMesh a = mesh_solid(tube, 0.3, 2), b = mesh_solid(tube, 0.3, 2);
  EXPECT_EQ(a.nodes, b.nodes);
  EXPECT_EQ(a.connectivity, b.connectivity);
  EXPECT_THROW(mesh_solid(cube, 0.3, 3), InputError);
  EXPECT_THROW(mesh_solid(cube, -1, 1), InputError);
}
