#pragma once
/// The boundary of a shape as whole sides: straight ones, and arcs of the true circles behind the chords.

#include <vector>

#include "mesh/shape_rings.hpp"

namespace berm {

/// A straight side or an arc, the body to its left.
struct BoundaryCurve {
  bool arc = false;
  Vec2 a = Vec2::Zero(), b = Vec2::Zero();  ///< ends [m]
  Vec2 centre = Vec2::Zero();               ///< of an arc [m]
  double radius = 0.0;                      ///< of an arc [m]
  double from = 0.0, sweep = 0.0;           ///< of an arc [rad]; sweep < 0: the body lies outside of the circle
  bool full = false;                        ///< a whole circle: no ends

  double length() const;
  Vec2 point(double t) const;                 ///< t = 0..1 along the curve
  Vec2 normal(double t) const;                ///< outward
  double closest(const Vec2& x) const;        ///< parameter of the point closest to x
  Vec2 extreme(const Vec2& direction) const;  ///< the point farthest in that direction
};

/// The sides of every ring in order, collinear edges and the chords of one circle joined. Corners with arcs are moved
/// from the chords to the intersection of the true curves.
std::vector<std::vector<BoundaryCurve>> boundary_loops(const ShapeRings& shape);

}  // namespace berm
