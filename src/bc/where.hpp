#pragma once
/// Which places a boundary condition acts on.

#include <cmath>
#include <numbers>

#include "case/case.hpp"

namespace berm {

/// True if x fulfils the box, the half space and the sector of `where` (its group is looked up by the caller).
inline bool inside(const Where& where, const Vec3& x) {
  if (where.min && (x.array() < where.min->array()).any()) return false;
  if (where.max && (x.array() > where.max->array()).any()) return false;
  if (where.beyond && (x - where.beyond->at).dot(where.beyond->normal) < 0.0) return false;
  if (where.sector) {
    const Vec2 d = in_plane(x) - where.sector->centre;
    constexpr double turn = 2.0 * std::numbers::pi;
    const double width = where.sector->to - where.sector->from;
    const double angle = std::atan2(d.y(), d.x()) - where.sector->from;
    if (angle - turn * std::floor(angle / turn) > width) return false;
  }
  return true;
}

}  // namespace berm
