#pragma once
/// The angle under which a triangle is seen.

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>

#include "base/tensor.hpp"

namespace berm {

/// Solid angle of the triangle seen from x over 4 pi, positive if it runs clockwise there (x is behind its outside).
/// After van Oosterom and Strackee (1983). The sum over a closed surface is 1 inside and 0 outside.
inline double winding_part(const Vec3& x, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 p = a - x, q = b - x, r = c - x;
  const double lp = p.norm(), lq = q.norm(), lr = r.norm();
  return std::atan2(p.dot(q.cross(r)), lp * lq * lr + p.dot(q) * lr + q.dot(r) * lp + r.dot(p) * lq) /
         (2.0 * std::numbers::pi);
}

}  // namespace berm
