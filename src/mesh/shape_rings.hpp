#pragma once
/// Booleans of shapes: the only place that sees Boost.Geometry.

#include <vector>

#include "mesh/plane_region.hpp"

namespace berm {

using Ring = std::vector<Vec2>;  ///< closed implicitly: the first vertex is not repeated

/// A disc of the shape as it appears in its rings: a regular polygon of the same area.
struct ChordDisc {
  Disc disc;
  int chords;
  double vertex_radius;  ///< distance of the chords' ends from the centre [m]
};

struct ShapeRings {
  std::vector<Ring> rings;  ///< outer rings counter-clockwise, holes clockwise
  std::vector<ChordDisc> discs;
};

/// Evaluates the shape. Throws InputError if a part or the result is empty, or a polygon touches or crosses itself.
ShapeRings evaluate_shape(const PlaneShape& shape, int arc_segments);

}  // namespace berm
