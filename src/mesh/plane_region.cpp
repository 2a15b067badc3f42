#include "mesh/plane_region.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "mesh/boundary_curve.hpp"
#include "mesh/edge_bins.hpp"
#include "mesh/shape_rings.hpp"

namespace berm {

namespace {

constexpr double sliver = 1e-12;  ///< parts of a polygon smaller than this fraction are rounding errors

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Signed area, and first moment about `origin` (chosen close by: keeps the digits).
struct Moments {
  double area = 0.0;
  Vec2 first = Vec2::Zero();
  void add(const Ring& ring, const Vec2& origin) {
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 a = ring[i] - origin, b = ring[i + 1 < ring.size() ? i + 1 : 0] - origin;
      const double twice = cross(a, b);
      area += 0.5 * twice;
      first += twice / 6.0 * (a + b);
    }
  }
};

/// Sutherland-Hodgman: the part of the ring to the left of the line p -> q. Parts that fall apart stay joined by
/// edges along the line, which are run through both ways and add nothing to area and moments.
void cut(const Ring& ring, const Vec2& p, const Vec2& q, Ring& out) {
  out.clear();
  if (ring.empty()) return;
  const Vec2 along = q - p;
  Vec2 a = ring.back();
  double side_a = cross(along, a - p);
  for (const Vec2& b : ring) {
    const double side_b = cross(along, b - p);
    if ((side_a < 0.0) != (side_b < 0.0)) out.push_back(a + (b - a) * (side_a / (side_a - side_b)));
    if (side_b >= 0.0) out.push_back(b);
    a = b;
    side_a = side_b;
  }
}

}  // namespace

struct PlaneRegion::Impl {
  ShapeRings shape;
  std::vector<BoundaryCurve> curves;
  EdgeBins bins;
  double total_area = 0.0;

  Impl(const PlaneShape& s, int arc_segments) : shape(evaluate_shape(s, arc_segments)), bins(shape.rings) {
    for (const auto& loop : boundary_loops(shape)) curves.insert(curves.end(), loop.begin(), loop.end());
    Moments moments;
    for (const Ring& ring : shape.rings) moments.add(ring, bins.centre());
    total_area = moments.area;
  }

  PlanePiece clip(const std::vector<Vec2>& polygon) const {
    Moments whole;
    whole.add(polygon, polygon[0]);
    const PlanePiece full{polygon[0] + whole.first / whole.area, whole.area}, nothing{polygon[0], 0.0};
    if (!bins.any_near(polygon)) return bins.contains(full.centroid) ? full : nothing;
    Moments part;
    Ring ring, next;
    for (const Ring& source : shape.rings) {
      ring = source;
      for (std::size_t i = 0; i < polygon.size(); ++i) {
        cut(ring, polygon[i], polygon[i + 1 < polygon.size() ? i + 1 : 0], next);
        ring.swap(next);
      }
      part.add(ring, polygon[0]);
    }
    if (part.area <= sliver * whole.area) return nothing;
    if (part.area >= (1.0 - sliver) * whole.area) return full;
    return {polygon[0] + part.first / part.area, part.area};
  }
};

PlaneRegion::PlaneRegion(const PlaneShape& shape, int arc_segments) : impl_(std::make_unique<Impl>(shape, arc_segments)) {}
PlaneRegion::~PlaneRegion() = default;
PlaneRegion::PlaneRegion(PlaneRegion&&) noexcept = default;
PlaneRegion& PlaneRegion::operator=(PlaneRegion&&) noexcept = default;

double PlaneRegion::area() const { return impl_->total_area; }

Vec2 PlaneRegion::min() const {
  Vec2 low = Vec2::Constant(std::numeric_limits<double>::infinity());
  for (const BoundaryCurve& c : impl_->curves)
    for (int d = 0; d < 2; ++d) low[d] = std::min(low[d], c.extreme(-Vec2::Unit(d))[d]);
  return low;
}

Vec2 PlaneRegion::max() const {
  Vec2 high = Vec2::Constant(-std::numeric_limits<double>::infinity());
  for (const BoundaryCurve& c : impl_->curves)
    for (int d = 0; d < 2; ++d) high[d] = std::max(high[d], c.extreme(Vec2::Unit(d))[d]);
  return high;
}

bool PlaneRegion::contains(const Vec2& x) const { return impl_->bins.contains(x); }

PlanePiece PlaneRegion::clip(const std::vector<Vec2>& polygon) const { return impl_->clip(polygon); }

std::vector<signed char> PlaneRegion::classify(const std::vector<std::vector<Vec2>>& polygons) const {
  std::vector<signed char> classes;
  classes.reserve(polygons.size());
  for (const std::vector<Vec2>& polygon : polygons) {
    Moments whole;
    whole.add(polygon, polygon[0]);
    // The clip of a polygon away from the boundary costs no more than the test where it is.
    const double area = impl_->clip(polygon).area;
    classes.push_back(area == 0.0 ? 0 : area == whole.area ? 1 : -1);
  }
  return classes;
}

std::vector<PlaneBoundaryPiece> PlaneRegion::boundary(double spacing) const {
  std::vector<PlaneBoundaryPiece> pieces;
  for (const BoundaryCurve& curve : impl_->curves) {
    int n = std::max(1, static_cast<int>(std::ceil(curve.length() / spacing - 1e-9)));
    if (curve.full) n = (n + 3) / 4 * 4;  // keeps the symmetry of a circle about both axes
    for (int i = 0; i < n; ++i) {
      const double t = (i + 0.5) / n;
      pieces.push_back({curve.point(t), curve.normal(t), curve.length() / n});
    }
  }
  return pieces;
}

PlaneRegion::Nearest PlaneRegion::nearest(const Vec2& x) const {
  double best = std::numeric_limits<double>::infinity(), t = 0.0;
  const BoundaryCurve* curve = nullptr;
  for (const BoundaryCurve& c : impl_->curves) {
    const double tc = c.closest(x), distance = (x - c.point(tc)).norm();
    if (distance < best) {
      best = distance;
      t = tc;
      curve = &c;
    }
  }
  const Vec2 point = curve->point(t), normal = curve->normal(t), offset = x - point;
  const bool at_end = !curve->full && (t == 0.0 || t == 1.0);
  // On arcs the sign follows the true circle, not its chords.
  const bool outside = at_end || !curve->arc ? !contains(x) : offset.dot(normal) > 0.0;
  const double sign = outside ? 1.0 : -1.0;
  // At a corner the normal is the direction of the distance, as long as there is one.
  if (at_end && best > 1e-12 * (max() - min()).maxCoeff()) return {point, sign / best * offset, sign * best};
  return {point, normal, sign * best};
}

std::vector<std::vector<Vec2>> PlaneRegion::rings() const { return impl_->shape.rings; }

}  // namespace berm
