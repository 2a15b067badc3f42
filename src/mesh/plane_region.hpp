#pragma once
/// Plane shapes of bodies: primitives, their unions and differences, and what is asked of them.

#include <memory>
#include <variant>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

struct Box {
  Vec2 min, max;
};
struct Disc {
  Vec2 centre;
  double radius;
};
struct Polygon {
  std::vector<Vec2> vertices;  ///< simple, either orientation
};
struct PlaneShape;
/// First shape united with / minus all the others.
struct Combination {
  enum class Kind { join, difference } kind;
  std::vector<PlaneShape> parts;
};
struct PlaneShape {
  std::variant<Box, Disc, Polygon, Combination> form;
};

/// A piece of a cell inside the body.
struct PlanePiece {
  Vec2 centroid;
  double area;
};

/// A piece of the boundary, outward normal.
struct PlaneBoundaryPiece {
  Vec2 centre, normal;
  double length;
};

/// The shape as polygons with holes (arcs are cut into `arc_segments` chords a full circle, scaled to keep the area).
class PlaneRegion {
public:
  /// Throws InputError for an empty or self-intersecting shape.
  explicit PlaneRegion(const PlaneShape& shape, int arc_segments = 720);
  ~PlaneRegion();
  PlaneRegion(PlaneRegion&&) noexcept;
  PlaneRegion& operator=(PlaneRegion&&) noexcept;

  double area() const;
  Vec2 min() const;
  Vec2 max() const;
  bool contains(const Vec2& x) const;  ///< boundary counts as inside

  /// The part of the convex polygon (counter-clockwise) inside the region. Area 0 if none.
  PlanePiece clip(const std::vector<Vec2>& polygon) const;
  /// For every polygon: 1 fully inside, 0 fully outside, -1 cut by the boundary. Fast: only the edges near a polygon
  /// are looked at.
  std::vector<signed char> classify(const std::vector<std::vector<Vec2>>& polygons) const;

  /// The boundary in pieces no longer than `spacing`; corners are piece ends. True arcs get true normals.
  std::vector<PlaneBoundaryPiece> boundary(double spacing) const;
  /// Closest boundary point to x: signed distance (negative inside) and the outward normal there.
  struct Nearest {
    Vec2 point, normal;
    double distance;
  };
  Nearest nearest(const Vec2& x) const;
  /// Outer rings and holes, for drawing.
  std::vector<std::vector<Vec2>> rings() const;

private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace berm
