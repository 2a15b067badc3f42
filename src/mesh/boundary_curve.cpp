#include "mesh/boundary_curve.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

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
  curve.arc = true;
  curve.centre = discs[first.disc].disc.centre;
  curve.radius = discs[first.disc].disc.radius;
  curve.sweep = first.counter_clockwise ? 1.0 : -1.0;  // the size follows when the corners are known
  return curve;
}

void set_angles(BoundaryCurve& curve) {
  if (!curve.arc || curve.full) return;
  curve.from = angle_of(curve.a - curve.centre);
  const double turn = angle_of(curve.b - curve.centre) - curve.from;
  curve.sweep = curve.sweep > 0.0 ? positive_angle(turn) : -positive_angle(-turn);
}

/// Value and gradient of a function that is zero on the curve (and on its extension).
std::pair<double, Vec2> implicit_form(const BoundaryCurve& curve, const Vec2& x) {
  if (!curve.arc) return {curve.normal(0.0).dot(x - curve.a), curve.normal(0.0)};
  const Vec2 offset = x - curve.centre;
  return {0.5 * (offset.squaredNorm() / curve.radius - curve.radius), offset / curve.radius};
}

/// Intersection of two curves close to `start`, by Newton; `start` itself where they touch without crossing.
Vec2 true_corner(const BoundaryCurve& one, const BoundaryCurve& two, const Vec2& start) {
  const double reach = 1e-2 * std::max(one.radius, two.radius);
  Vec2 x = start;
  for (int it = 0; it < 20; ++it) {
    const auto [f, df] = implicit_form(one, x);
    const auto [g, dg] = implicit_form(two, x);
    const double det = cross(df, dg);
    if (std::abs(det) < 1e-6) return start;
    const Vec2 step((f * dg.y() - g * df.y()) / det, (g * df.x() - f * dg.x()) / det);
    x -= step;
    if ((x - start).norm() > reach) return start;
    if (step.norm() < 1e-15 * reach) break;
  }
  return x;
}

std::vector<BoundaryCurve> loop_of(const Ring& ring, const std::vector<ChordDisc>& discs) {
  const std::vector<TaggedEdge> edges = tagged_edges(ring, discs);
  const std::size_t n = edges.size();
  std::size_t start = 0;
  while (start < n && continues(edges[(start + n - 1) % n], edges[start])) ++start;
  if (start == n) return {full_circle(discs[edges[0].disc].disc, edges[0].counter_clockwise)};
  std::vector<BoundaryCurve> loop;
  for (std::size_t i = 0; i < n;) {
    std::size_t j = i;
    while (j + 1 < n && continues(edges[(start + j) % n], edges[(start + j + 1) % n])) ++j;
    loop.push_back(from_run(edges[(start + i) % n], edges[(start + j) % n], discs));
    i = j + 1;
  }
  std::vector<Vec2> corners;
  for (std::size_t i = 0; i < loop.size(); ++i) {
    const BoundaryCurve& next = loop[(i + 1) % loop.size()];
    corners.push_back(loop[i].arc || next.arc ? true_corner(loop[i], next, loop[i].b) : loop[i].b);
  }
  for (std::size_t i = 0; i < loop.size(); ++i) {
    loop[i].a = corners[(i + loop.size() - 1) % loop.size()];
    loop[i].b = corners[i];
    set_angles(loop[i]);
  }
  return loop;
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

std::vector<std::vector<BoundaryCurve>> boundary_loops(const ShapeRings& shape) {
  std::vector<std::vector<BoundaryCurve>> loops;
  for (const Ring& ring : shape.rings) loops.push_back(loop_of(ring, shape.discs));
  return loops;
}

}  // namespace berm
