#pragma once
/// Smooth outlines through a few points.

#include <vector>

#include "base/tensor.hpp"

namespace berm {

/// The closed cubic B-spline through the points in their order, twice continuously differentiable, its knots as far apart as
/// the points (Bing 2017 describes the boundaries of bodies by such curves), as a polygon of `pieces` chords from each
/// point to the next [m]. The chords of a circle of 12 points and 32 pieces are off it by 2e-4 of its radius. At least three
/// points, neighbours apart. Throws InputError if they are so far apart that squares of lengths overflow.
std::vector<Vec2> closed_spline(const std::vector<Vec2>& points, int pieces = 32);

}  // namespace berm
