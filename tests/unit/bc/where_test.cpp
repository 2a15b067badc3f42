#include "bc/where.hpp"

#include <gtest/gtest.h>

namespace berm {
namespace {

Vec3 at(double degrees, double r = 1.0, double z = 0.0) {
  const double a = degrees * std::numbers::pi / 180.0;
  return Vec3(2.0 + r * std::cos(a), 3.0 + r * std::sin(a), z);
}

Where sector(double from, double to) {
  Where w;
  w.sector = Where::Sector{Vec2(2.0, 3.0), from * std::numbers::pi / 180.0, to * std::numbers::pi / 180.0};
  return w;
}

TEST(Where, SectorsAcrossTheCut) {
  EXPECT_TRUE(inside(sector(80.0, 100.0), at(90.0)));
  EXPECT_FALSE(inside(sector(80.0, 100.0), at(79.0)));
  EXPECT_FALSE(inside(sector(80.0, 100.0), at(101.0)));
  EXPECT_TRUE(inside(sector(264.0, 276.0), at(-90.0)));
  EXPECT_TRUE(inside(sector(-10.0, 10.0), at(355.0)));
  EXPECT_TRUE(inside(sector(350.0, 370.0), at(5.0)));
  EXPECT_FALSE(inside(sector(350.0, 370.0), at(15.0)));
  EXPECT_TRUE(inside(sector(0.0, 360.0), at(200.0)));
}

TEST(Where, BoxAndSectorMustBothHold) {
  Where w = sector(0.0, 90.0);
  w.min = Vec3(2.5, 3.0, 0.0);
  w.max = Vec3(4.0, 4.0, 0.0);
  EXPECT_TRUE(inside(w, at(45.0)));
  EXPECT_FALSE(inside(w, at(85.0)));
  EXPECT_FALSE(inside(w, Vec3(2.6, 2.9, 0.0)));
}

TEST(Where, BoxesInSpaceLimitZ) {
  Where w;
  w.min = Vec3(0.0, 0.0, 0.0);
  EXPECT_TRUE(inside(w, Vec3(1.0, 1.0, 5.0)));
  EXPECT_FALSE(inside(w, Vec3(1.0, 1.0, -0.1)));
  w.max = Vec3(2.0, 2.0, 2.0);
  EXPECT_TRUE(inside(w, Vec3(2.0, 2.0, 2.0)));
  EXPECT_FALSE(inside(w, Vec3(1.0, 1.0, 5.0)));
}

TEST(Where, SectorsInSpaceAreSeenAgainstZ) {
  EXPECT_TRUE(inside(sector(80.0, 100.0), at(90.0, 2.0, 7.0)));
  EXPECT_FALSE(inside(sector(80.0, 100.0), at(79.0, 2.0, -7.0)));
}

TEST(Where, BeyondALine) {
  Where w;
  w.beyond = {Vec3(1.0, 0.0, 0.0), Vec3(1.0, 2.0, 0.0)};
  EXPECT_TRUE(inside(w, Vec3(1.0, 0.0, 0.0)));  // on it
  EXPECT_TRUE(inside(w, Vec3(-0.9, 1.0, 0.0)));
  EXPECT_FALSE(inside(w, Vec3(-1.1, 1.0, 0.0)));
}

}  // namespace
}  // namespace berm
