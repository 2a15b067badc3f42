#pragma once
/// Cutting closed surfaces by planes.

#include <array>
#include <functional>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

struct SoupTriangle {
  Vec3 a, b, c;
  bool cap;  ///< lies in a cutting plane: not a part of the body's own surface
};

/// A closed surface as a signed sum of triangles, in any order; they may overlap and cancel each other.
using Soup = std::vector<SoupTriangle>;

/// The points x with normal . x <= offset.
struct HalfSpace {
  Vec3 normal;
  double offset;
};

/// The soup of what lies in the half-space. Every cut triangle leaves a segment in the plane, whose sum is closed;
/// triangles from one fixed point of the plane to all segments close the soup again.
void cut(const Soup& soup, const HalfSpace& half, Soup& out);
/// The same for the half-space sign * x[axis] <= sign * position; cut points lie exactly in the plane.
void cut(const Soup& soup, int axis, double position, double sign, Soup& out);

/// Volume and its first moment about `origin` by the divergence theorem.
struct SolidMoments {
  double volume = 0.0;
  Vec3 first = Vec3::Zero();
  void add(const Vec3& a, const Vec3& b, const Vec3& c) {  ///< corners relative to the origin
    const double six = a.x() * (b.y() * c.z() - b.z() * c.y()) + a.y() * (b.z() * c.x() - b.x() * c.z()) +
                       a.z() * (b.x() * c.y() - b.y() * c.x());
    volume += six / 6.0;
    first += six / 24.0 * (a + b + c);
  }
  void add(const Soup& soup, const Vec3& origin) {
    for (const SoupTriangle& t : soup) add(t.a - origin, t.b - origin, t.c - origin);
  }
};

/// Planes of an axis-aligned structured grid of boxes, increasing in every direction.
using GridPlanes = std::array<std::vector<double>, 3>;

/// Boxes first .. last-1 in every direction.
struct BoxRange {
  std::array<int, 3> first, last;
  Vec3 low(const GridPlanes& planes) const;
  Vec3 high(const GridPlanes& planes) const;
  bool single() const { return last[0] - first[0] == 1 && last[1] - first[1] == 1 && last[2] - first[2] == 1; }
};

/// Cuts the soup into the boxes by halving ranges of them. Calls full(range) for ranges inside of the body and
/// part(range, soup) for single boxes that its surface runs through; the rest is empty. The order of the calls is
/// always the same. With a `sliver` above 0, ranges whose part is smaller than that volume [m3] are empty, and full if
/// that little is missing.
void bisect(const Soup& soup, const GridPlanes& planes, double sliver, const std::function<void(const BoxRange&)>& full,
            const std::function<void(const BoxRange&, const Soup&)>& part);

}  // namespace berm
