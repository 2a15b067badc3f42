#include "bc/surface.hpp"

#include <gtest/gtest.h>

namespace berm {
namespace {

SurfacePoint piece(const Vec3& x, const Vec3& normal, double size) {
  SurfacePoint s;
  s.X = x;
  s.normal = normal;
  s.area = s.size = size;
  return s;
}

/// The right side of a unit square in ten pieces, and pieces of its top and bottom beside it.
struct Side {
  std::vector<SurfacePoint> side, beside;
  Side() {
    for (int k = 0; k < 10; ++k) side.push_back(piece({1.0, 0.1 * k + 0.05, 0.0}, Vec3::UnitX(), 0.1));
    beside = {piece({0.95, 1.0, 0.0}, Vec3::UnitY(), 0.1), piece({0.95, 0.0, 0.0}, -Vec3::UnitY(), 0.1)};
  }
  std::vector<SurfacePart> parts(double share) const {
    std::vector<SurfacePart> all;
    for (const SurfacePoint& s : side) all.push_back({s, 1.0});
    for (const SurfacePoint& s : beside) all.push_back({s, share});
    return all;
  }
};

TEST(Strips, ThoseBesideAFaceAreLeftOut) {
  const Side s;
  const auto parts = without_strips(s.parts(0.01));
  ASSERT_EQ(parts.size(), 10u);
  for (const SurfacePart& part : parts) EXPECT_EQ(part.piece.normal, Vec3::UnitX());
}

TEST(Strips, WholePiecesAreMeant) { EXPECT_EQ(without_strips(Side().parts(1.0)).size(), 12u); }

TEST(Strips, CurvedFacesAreKept) {
  std::vector<SurfacePoint> arc;
  for (int k = -9; k <= 9; ++k) arc.push_back(piece(Vec3::Zero(), Vec3(std::cos(0.1 * k), std::sin(0.1 * k), 0.0), 0.1));
  std::vector<SurfacePart> parts;
  for (const SurfacePoint& s : arc) parts.push_back({s, &s == &arc.front() || &s == &arc.back() ? 0.2 : 1.0});
  EXPECT_EQ(without_strips(parts).size(), arc.size());
}

TEST(Strips, AClosedSurfaceHasNoMainFace) {
  const std::vector<SurfacePoint> box = {piece(Vec3::Zero(), Vec3::UnitX(), 1.0), piece(Vec3::Zero(), -Vec3::UnitX(), 1.0), piece(Vec3::Zero(), Vec3::UnitY(), 1.0),
                                         piece(Vec3::Zero(), -Vec3::UnitY(), 1.0)};
  std::vector<SurfacePart> parts;
  for (const SurfacePoint& s : box) parts.push_back({s, 0.5});
  EXPECT_EQ(without_strips(parts).size(), 4u);
}

}  // namespace
}  // namespace berm
