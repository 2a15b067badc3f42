#pragma once
/// The point of a triangle that is closest to a point.

#include "base/tensor.hpp"

namespace berm {

struct ClosestPoint {
  Vec3 point;
  bool interior;  ///< not on an edge or a corner
};

ClosestPoint closest_on_triangle(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c);

}  // namespace berm
