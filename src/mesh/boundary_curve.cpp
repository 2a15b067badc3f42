#include "mesh/boundary_curve.hpp"

#include <algorithm>
#include <cmath>

namespace berm {

namespace {

const double pi = std::acos(-1.0);

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }
double angle_of(const Vec2& v) { return std::atan2(v.y(), v.x()); }
Vec2 unit(double angle) { return Vec2(std::cos(angle), std::sin(angle)); }

/// The angle turned into [0, 2 pi).
double positive_angle(double angle) {
  const double turned = std::fmod(angle, 2.0 * pi);
  return turned < 0.0 ? turned + 2.0 * pi : turned;
}

/// The disc whose chord (or a part of it) the edge is, or -1.
int disc_of(const Vec2& a, const Vec2& b, const std::vector<ChordDisc>& discs) {
  for (std::size_t k = 0; k < discs.size(); ++k) {
    const ChordDisc& d = discs[k];
    const double tolerance = 1e-9 * d.vertex_radius, in_radius = d.vertex_radius * std::cos(pi / d.chords);
    const Vec2 u = a - d.disc.centre, v = b - d.disc.centre;
    if (u.norm() > d.vertex_radius + tolerance || v.norm() > d.vertex_radius + tolerance) continue;
    // Both ends within the narrow ring of the chords, and the edge no longer than a chord.
    if (u.norm() < in_radius - tolerance || v.norm() < in_radius - tolerance) continue;
    if ((b - a).norm() <= 2.0 * d.vertex_radius * std::sin(pi / d.chords) + tolerance) return static_cast<int>(k);
  }
  return -1;
}

struct TaggedEdge {
  Vec2 a, b;
  int disc;
  bool counter_clockwise;  ///< about the disc
};

std::vector<TaggedEdge> tagged_edges(const Ring& ring, const std::vector<ChordDisc>& discs) {
  std::vector<TaggedEdge> edges;
  for (std::size_t i = 0; i < ring.size(); ++i) {
    const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
    const int disc = disc_of(a, b, discs);
    const bool ccw = disc >= 0 && cross(a - discs[disc].disc.centre, b - discs[disc].disc.centre) > 0.0;
    if (a != b) edges.push_back({a, b, disc, ccw});
  }
  return edges;
}

bool continues(const TaggedEdge& e, const TaggedEdge& next) {
  if (e.disc != next.disc || e.counter_clockwise != next.counter_clockwise) return false;
  if (e.disc >= 0) return true;
  const Vec2 u = (e.b - e.a).normalized(), v = (next.b - next.a).normalized();
  return std::abs(cross(u, v)) < 1e-9 && u.dot(v) > 0.0;
}

BoundaryCurve full_circle(const Disc& disc, bool counter_clockwise) {
  BoundaryCurve curve;
  curve.arc = curve.full = true;
  curve.centre = disc.centre;
  curve.radius = disc.radius;
  curve.sweep = counter_clockwise ? 2.0 * pi : -2.0 * pi;
  return curve;
}

BoundaryCurve from_run(const TaggedEdge& first, const TaggedEdge& last, const std::vector<ChordDisc>& discs) {
  BoundaryCurve curve;
  curve.a = first.a;
  curve.b = last.b;
  if (first.disc < 0) return curve;
  const Disc& disc = discs[first.disc].disc;
  curve.arc = true;
  curve.centre = disc.centre;
  curve.radius = disc.radius;
  curve.from = angle_of(first.a - disc.centre);
  const double to = angle_of(last.b - disc.centre);
  curve.sweep = first.counter_clockwise ? positive_angle(to - curve.from) : -positive_angle(curve.from - to);
  return curve;
}

void append_curves(const Ring& ring, const std::vector<ChordDisc>& discs, std::vector<BoundaryCurve>& curves) {
  const std::vector<TaggedEdge> edges = tagged_edges(ring, discs);
  const std::size_t n = edges.size();
  std::size_t start = 0;
  while (start < n && continues(edges[(start + n - 1) % n], edges[start])) ++start;
  if (start == n) {
    curves.push_back(full_circle(discs[edges[0].disc].disc, edges[0].counter_clockwise));
    return;
  }
  for (std::size_t i = 0; i < n;) {
    std::size_t j = i;
    while (j + 1 < n && continues(edges[(start + j) % n], edges[(start + j + 1) % n])) ++j;
    curves.push_back(from_run(edges[(start + i) % n], edges[(start + j) % n], discs));
    i = j + 1;
  }
}

}  // namespace

double BoundaryCurve::length() const { return arc ? radius * std::abs(sweep) : (b - a).norm(); }

Vec2 BoundaryCurve::point(double t) const {
  return arc ? Vec2(centre + radius * unit(from + t * sweep)) : Vec2(a + t * (b - a));
}

Vec2 BoundaryCurve::normal(double t) const {
  if (arc) return sweep > 0.0 ? unit(from + t * sweep) : Vec2(-unit(from + t * sweep));
  const Vec2 along = (b - a).normalized();
  return Vec2(along.y(), -along.x());
}

double BoundaryCurve::closest(const Vec2& x) const {
  if (!arc) return std::clamp((x - a).dot(b - a) / (b - a).squaredNorm(), 0.0, 1.0);
  const double turn = angle_of(x - centre) - from;
  const double t = positive_angle(sweep > 0.0 ? turn : -turn) / std::abs(sweep);
  if (t <= 1.0) return t;
  return (x - point(0.0)).squaredNorm() <= (x - point(1.0)).squaredNorm() ? 0.0 : 1.0;
}

Vec2 BoundaryCurve::extreme(const Vec2& direction) const {
  const Vec2 first = point(0.0), last = point(1.0);
  Vec2 best = direction.dot(first) >= direction.dot(last) ? first : last;
  if (!arc) return best;
  const Vec2 top = centre + radius * direction.normalized();
  const double t = closest(top);
  return full || (t > 0.0 && t < 1.0) ? top : best;
}

std::vector<BoundaryCurve> boundary_curves(const ShapeRings& shape) {
  std::vector<BoundaryCurve> curves;
  for (const Ring& ring : shape.rings) append_curves(ring, shape.discs, curves);
  return curves;
}

}  // namespace berm
