#include "mesh/shape_rings.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "base/error.hpp"

// Without this, Boost 1.74 rounds the coordinates of intersections to an integer grid (7 digits).
#define BOOST_GEOMETRY_NO_ROBUSTNESS
#define BOOST_ALLOW_DEPRECATED_HEADERS
// GCC 12 cannot see through Boost's iterators.
#pragma GCC diagnostic ignored "-Wmaybe-uninitialized"
#include <boost/geometry.hpp>
#include <boost/geometry/geometries/multi_polygon.hpp>
#include <boost/geometry/geometries/point_xy.hpp>
#include <boost/geometry/geometries/polygon.hpp>

namespace berm {

namespace {

namespace bg = boost::geometry;
using Point = bg::model::d2::point_xy<double>;
using BoostPolygon = bg::model::polygon<Point, false, true>;  // counter-clockwise, closed
using BoostShape = bg::model::multi_polygon<BoostPolygon>;

const double pi = std::acos(-1.0);

BoostShape from_ring(const Ring& ring) {
  BoostPolygon polygon;
  for (const Vec2& v : ring) bg::append(polygon.outer(), Point(v.x(), v.y()));
  bg::correct(polygon);
  bg::unique(polygon);
  BoostShape shape;
  shape.push_back(polygon);
  return shape;
}

class Evaluation {
public:
  Evaluation(int arc_segments, std::vector<ChordDisc>& discs) : arc_segments_(arc_segments), discs_(discs) {}

  BoostShape operator()(const Box& box) {
    if (!(box.max.x() > box.min.x() && box.max.y() > box.min.y()))
      throw InputError(fmt::format("shape: the box from ({:g}, {:g}) to ({:g}, {:g}) is empty (min must be below max)",
                                   box.min.x(), box.min.y(), box.max.x(), box.max.y()));
    return from_ring({box.min, Vec2(box.max.x(), box.min.y()), box.max, Vec2(box.min.x(), box.max.y())});
  }

  BoostShape operator()(const Disc& disc) {
    if (!(disc.radius > 0.0))
      throw InputError(fmt::format("shape: disc of radius {:g} m (it must be positive)", disc.radius));
    const int n = arc_segments_;
    const double radius = disc.radius * std::sqrt(2.0 * pi / (n * std::sin(2.0 * pi / n)));
    discs_.push_back({disc, n, radius});
    Ring ring;
    for (int i = 0; i < n; ++i)
      ring.push_back(disc.centre + radius * Vec2(std::cos(2.0 * pi * i / n), std::sin(2.0 * pi * i / n)));
    return from_ring(ring);
  }

  BoostShape operator()(const Polygon& polygon) {
    if (polygon.vertices.size() < 3)
      throw InputError(fmt::format("shape: a polygon of {} vertices (at least 3 are needed)", polygon.vertices.size()));
    const BoostShape shape = from_ring(polygon.vertices);
    std::string reason;
    if (!bg::is_valid(shape, reason))
      throw InputError(
          "shape: the polygon or spline is flat, or touches or crosses itself (its sides may only meet at its vertices, in "
          "order)");
    return shape;
  }

  BoostShape operator()(const Combination& combination) {
    if (combination.parts.empty()) throw InputError("shape: a combination without parts");
    BoostShape result = std::visit(*this, combination.parts.front().form);
    for (std::size_t i = 1; i < combination.parts.size(); ++i) {
      const BoostShape other = std::visit(*this, combination.parts[i].form);
      result = combine(result, other, combination.kind);
    }
    return result;
  }

private:
  static BoostShape combine(const BoostShape& a, const BoostShape& b, Combination::Kind kind) {
    const bool join = kind == Combination::Kind::join;
    BoostShape result, common;
    if (join)
      bg::union_(a, b, result);
    else
      bg::difference(a, b, result);
    bg::intersection(a, b, common);
    // The areas of both operations must agree: guards against the floating-point corner cases of such algorithms.
    const double expected = bg::area(a) + (join ? bg::area(b) : 0.0) - bg::area(common);
    if (std::abs(bg::area(result) - expected) > 1e-9 * (bg::area(a) + bg::area(b)))
      throw InputError("shape: parts that almost touch could not be combined (make them overlap or separate them)");
    return result;
  }

  int arc_segments_;
  std::vector<ChordDisc>& discs_;
};

template <class BoostRing>
Ring to_ring(const BoostRing& source) {
  Ring ring;
  for (std::size_t i = 0; i + 1 < source.size(); ++i) ring.emplace_back(source[i].x(), source[i].y());
  return ring;
}

/// Places so far away that those of one shape can hardly be told apart.
void refuse_lost_in_rounding(const std::vector<Ring>& rings) {
  constexpr double rounding = 1e-15;
  Vec2 low = rings.front().front(), high = low;
  for (const Ring& ring : rings)
    for (const Vec2& x : ring) low = low.cwiseMin(x), high = high.cwiseMax(x);
  const double farthest = low.cwiseAbs().cwiseMax(high.cwiseAbs()).maxCoeff();
  if (!((high - low).minCoeff() > rounding * farthest))
    throw InputError(fmt::format("shape: it reaches {:.3g} m from the corner of the grid, or from the origin, and is {:.3g} m wide: its places are lost in rounding", farthest,
                                 (high - low).minCoeff()));
}

}  // namespace

ShapeRings evaluate_shape(const PlaneShape& shape, int arc_segments) {
  if (arc_segments < 8)
    throw InputError(fmt::format("shape: {} chords a circle (at least 8 are needed)", arc_segments));
  ShapeRings out;
  Evaluation evaluation(arc_segments, out.discs);
  const BoostShape result = std::visit(evaluation, shape.form);
  for (const BoostPolygon& polygon : result) {
    if (!(bg::area(polygon) > 0.0)) continue;
    out.rings.push_back(to_ring(polygon.outer()));
    for (const auto& hole : polygon.inners()) out.rings.push_back(to_ring(hole));
  }
  if (out.rings.empty()) throw InputError("shape: nothing is left of it (the parts taken away cover it)");
  refuse_lost_in_rounding(out.rings);
  return out;
}

}  // namespace berm
