#pragma once
/// What an area or a length of a model stands for.

#include <numbers>

#include "law/point_response.hpp"

namespace berm {

/// Factor from an area of the model at that radius to a volume, and from a length to an area: the thickness of the plane,
/// the ring around the axis, nothing in space [m or -].
inline double depth(Space space, double thickness, double radius) {
  if (space == Space::axisymmetric) return 2.0 * std::numbers::pi * radius;
  return is_plane(space) ? thickness : 1.0;
}

}  // namespace berm
