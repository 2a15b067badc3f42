#include "mesh/closed_spline.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace berm {
namespace {

/// Largest distance from the unit circle of the spline through n of its points.
double off_circle(int n) {
  std::vector<Vec2> points;
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / n;
    points.emplace_back(std::cos(angle), std::sin(angle));
  }
  double most = 0.0;
  for (const Vec2& x : closed_spline(points, 32)) most = std::max(most, std::abs(x.norm() - 1.0));
  return most;
}

TEST(ClosedSpline, CircleIsMetWithOrderFour) {
  EXPECT_LT(off_circle(12), 2.5e-4);
  EXPECT_NEAR(std::log2(off_circle(12) / off_circle(24)), 4.0, 0.1);
}

TEST(ClosedSpline, GoesThroughItsPointsWithoutCornersOrJumpsOfCurvature) {
  const std::vector<Vec2> points = {{0.0, 0.0}, {4.0, -1.0}, {5.0, 1.0}, {2.0, 2.5}, {-0.5, 2.0}};
  constexpr int pieces = 4000;
  const std::vector<Vec2> curve = closed_spline(points, pieces);
  const int n = int(curve.size());
  ASSERT_EQ(n, 5 * pieces);
  // Tangents and curvatures a few chords before and after every point.
  const auto at = [&](int i) { return curve[(i + n) % n]; };
  const auto tangent = [&](int i) { return Vec2((at(i + 1) - at(i)).normalized()); };
  const auto curvature = [&](int i) {
    const Vec2 a = tangent(i - 1), b = tangent(i + 1);
    return (a.x() * b.y() - a.y() * b.x()) / (0.5 * (at(i + 2) - at(i - 2)).norm());
  };
  for (int k = 0; k < 5; ++k) {
    const int i = k * pieces;
    EXPECT_NEAR((curve[i] - points[k]).norm(), 0.0, 1e-14);
    EXPECT_LT((tangent(i) - tangent(i - 1)).norm(), 2e-3);
    EXPECT_NEAR(curvature(i + 4), curvature(i - 5), 0.02);
  }
}

}  // namespace
}  // namespace berm
