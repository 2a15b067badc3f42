#include "sim/local_fit.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace berm {
namespace {

/// Random points in the unit square or cube.
std::vector<Vec3> cloud(int n, int dimension) {
  std::mt19937 generator(4);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  std::vector<Vec3> x;
  for (int i = 0; i < n; ++i) x.emplace_back(u(generator), u(generator), dimension == 3 ? u(generator) : 0.0);
  return x;
}

std::vector<double> volumes(std::size_t n) {
  std::vector<double> v;
  for (std::size_t i = 0; i < n; ++i) v.push_back(1.0 + 0.5 * std::sin(1.0 * i));
  return v;
}

double linear(const Vec3& x) { return 2.0 - 3.0 * x.x() + 0.7 * x.y() + 1.9 * x.z(); }
double quadratic(const Vec3& x) {
  return linear(x) + 4.0 * x.x() * x.x() - 2.0 * x.x() * x.y() + x.y() * x.y() + 3.0 * x.y() * x.z() -
         1.5 * x.z() * x.z() + 0.5 * x.x() * x.z();
}

/// Places inside, at the faces and in the corners of the cloud.
std::vector<Vec3> places(int dimension) {
  std::vector<Vec3> at = {{0.5, 0.5, 0.5}, {0.31, 0.77, 0.12}, {0.0, 0.4, 0.6}, {0.0, 0.0, 0.0}, {1.0, 1.0, 1.0}};
  if (dimension == 2)
    for (Vec3& x : at) x.z() = 0.0;
  return at;
}

TEST(LocalFit, ReproducesLinearAndQuadraticFields) {
  for (int dimension : {2, 3}) {
    const std::vector<Vec3> x = cloud(dimension == 2 ? 400 : 4000, dimension);
    const double radius = 0.3;
    const PointBins bins(x, radius, dimension);
    for (const Vec3& at : places(dimension)) {
      const LocalFit first = bins.fit(at, radius, volumes(x.size()));
      EXPECT_GT(first.point.size(), 10u);
      EXPECT_EQ(first.point.size(), first.weight.size());
      EXPECT_NEAR(first.apply([&](int p) { return linear(x[p]); }), linear(at), 1e-12);
      EXPECT_NEAR(first.apply([](int) { return 1.0; }), 1.0, 1e-13);
      const LocalFit second = bins.fit(at, radius, volumes(x.size()), 2);
      EXPECT_NEAR(second.apply([&](int p) { return quadratic(x[p]); }), quadratic(at), 1e-11);
      EXPECT_GT(std::abs(first.apply([&](int p) { return quadratic(x[p]); }) - quadratic(at)), 1e-6);
    }
  }
}

/// All points nearer than the radius and no other.
TEST(LocalFit, TakesTheNeighbourhood) {
  for (int dimension : {2, 3}) {
    const std::vector<Vec3> x = cloud(1000, dimension);
    for (double radius : {0.25, 0.17}) {  // bins as large as the radius, and larger
      const PointBins bins(x, 0.25, dimension);
      for (const Vec3& at : places(dimension)) {
        std::vector<int> found = bins.fit(at, radius, volumes(x.size())).point, expected;
        std::sort(found.begin(), found.end());
        for (int p = 0; p < 1000; ++p)
          if ((x[p] - at).norm() < radius) expected.push_back(p);
        if (static_cast<int>(expected.size()) > dimension) {
          EXPECT_EQ(found, expected);
        } else {
          EXPECT_EQ(found.size(), 1u);
        }
      }
    }
  }
}

TEST(LocalFit, TooFewPointsTakeTheNextLowerDegree) {
  // Fewer than 14 points in space: linear.
  const std::vector<Vec3> few = cloud(13, 3);
  const Vec3 at(0.5, 0.5, 0.5);
  const LocalFit fit = PointBins(few, 2.0, 3).fit(at, 2.0, volumes(13), 2);
  EXPECT_EQ(fit.point.size(), 13u);
  EXPECT_NEAR(fit.apply([&](int p) { return linear(few[p]); }), linear(at), 1e-12);
  const std::vector<Vec3> enough = cloud(14, 3);
  const LocalFit full = PointBins(enough, 2.0, 3).fit(at, 2.0, volumes(14), 2);
  EXPECT_NEAR(full.apply([&](int p) { return quadratic(enough[p]); }), quadratic(at), 1e-9);
  // Three points in space do not make a linear field: the nearest.
  const std::vector<Vec3> three = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0.2}};
  const LocalFit nearest = PointBins(three, 2.0, 3).fit(Vec3(0.7, 0.1, 0.1), 2.0, volumes(3), 2);
  EXPECT_EQ(nearest.point, std::vector<int>{1});
  EXPECT_EQ(nearest.weight, std::vector<double>{1.0});
  // In the plane they do.
  std::vector<Vec3> flat = three;
  flat[2].z() = 0.0;
  const Vec3 in_plane(0.4, 0.2, 0.0);
  const LocalFit plane = PointBins(flat, 2.0, 2).fit(in_plane, 2.0, volumes(3), 2);
  EXPECT_NEAR(plane.apply([&](int p) { return linear(flat[p]); }), linear(in_plane), 1e-12);
}

/// Many points, but in a plane or on a line of space: they do not determine the fit, and nothing blows up.
TEST(LocalFit, PointsInAPlaneOrLineTakeTheNearest) {
  std::vector<Vec3> plane, line, shell;
  for (int i = 0; i < 10; ++i)
    for (int j = 0; j < 10; ++j) {
      plane.emplace_back(0.1 * i, 0.1 * j, 0.1 * i - 0.2 * j);
      line.push_back((0.1 * i + 0.01 * j) * Vec3(1.0, -1.0, 0.5));
      shell.emplace_back(0.1 * i, 0.1 * j, j % 2 ? 0.0 : 0.1);  // two layers: linear, not quadratic
    }
  for (const auto* x : {&plane, &line}) {
    for (int degree : {1, 2}) {
      const Vec3 at = (*x)[34] + Vec3(0.001, 0.001, 0.001);
      const LocalFit fit = PointBins(*x, 0.5, 3).fit(at, 0.5, volumes(100), degree);
      EXPECT_EQ(fit.point, std::vector<int>{34});
    }
  }
  const Vec3 at(0.45, 0.45, 0.05);
  const LocalFit fit = PointBins(shell, 0.5, 3).fit(at, 0.5, volumes(100), 2);
  EXPECT_NEAR(fit.apply([&](int p) { return linear(shell[p]); }), linear(at), 1e-12);
}

TEST(LocalFit, FarAwayTakesTheNearestOfAll) {
  for (int dimension : {2, 3}) {
    const std::vector<Vec3> x = cloud(200, dimension);
    const Vec3 at(7.0, -3.0, dimension == 3 ? 5.0 : 0.0);
    int nearest = 0;
    for (int p = 1; p < 200; ++p)
      if ((x[p] - at).norm() < (x[nearest] - at).norm()) nearest = p;
    const LocalFit fit = PointBins(x, 0.1, dimension).fit(at, 0.1, volumes(200), 2);
    EXPECT_EQ(fit.point, std::vector<int>{nearest});
    EXPECT_EQ(fit.weight, std::vector<double>{1.0});
  }
}

}  // namespace
}  // namespace berm
