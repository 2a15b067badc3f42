#include "sim/body_parts.hpp"

#include <gtest/gtest.h>

namespace berm {
namespace {

/// Gauss points of n x n cells of that size from a corner.
void fill(std::vector<Vec3>& places, const Vec3& corner, const Vec3& cell, int n) {
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      for (double a : {0.2113, 0.7887})
        for (double b : {0.2113, 0.7887}) places.push_back(corner + Vec3((i + a) * cell.x(), (j + b) * cell.y(), 0.0));
}

TEST(BodyParts, OneBlockIsOnePartOnAnyGrid) {
  for (const Vec3& cell : {Vec3(0.1, 0.1, 0.0), Vec3(4.0, 1.0, 0.0), Vec3(0.01, 1.0, 0.0)}) {
    std::vector<Vec3> places;
    fill(places, Vec3(1.0, 0.0, 0.0), cell, 12);
    EXPECT_EQ(BodyParts(places, 1.000001 * cell.maxCoeff()).count(), 1) << cell.transpose();
  }
}

TEST(BodyParts, APlaceBelongsToTheNearestPart) {
  std::vector<Vec3> places;
  fill(places, Vec3(0.0, 0.0, 0.0), Vec3(0.1, 0.1, 0.0), 4);
  fill(places, Vec3(1.0, 0.0, 0.0), Vec3(0.1, 0.1, 0.0), 4);
  fill(places, Vec3(0.0, -5.4e6, 0.0), Vec3(0.1, 0.1, 0.0), 4);
  const BodyParts parts(places, 0.1);
  ASSERT_EQ(parts.count(), 3);
  const int left = parts.of(Vec3(0.2, 0.2, 0.0)), right = parts.of(Vec3(1.2, 0.2, 0.0)), far = parts.of(Vec3(0.2, -5.4e6, 0.0));
  EXPECT_NE(left, right);
  EXPECT_NE(right, far);
  EXPECT_EQ(parts.of(Vec3(0.45, 0.2, 0.0)), left);
  EXPECT_EQ(parts.of(Vec3(0.8, 0.2, 0.0)), right);  // farther than a box
}

}  // namespace
}  // namespace berm
