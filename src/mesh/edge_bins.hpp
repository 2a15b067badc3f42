#pragma once
/// Fast questions to the edges of closed rings.

#include <vector>

#include "mesh/shape_rings.hpp"

namespace berm {

/// Edges of rings in a uniform table of bins, and in rows for points in polygons.
class EdgeBins {
public:
  explicit EdgeBins(const std::vector<Ring>& rings);

  Vec2 centre() const { return 0.5 * (min_ + max_); }
  /// Is x inside of the rings (even-odd) or within rounding of an edge?
  bool contains(const Vec2& x) const;
  /// May an edge cut or touch the convex, counter-clockwise polygon? False is certain, true is a guess.
  bool any_near(const std::vector<Vec2>& polygon) const;

private:
  struct Edge {
    Vec2 a, b;
  };
  int index(int d, double x) const;
  bool near(const Edge& edge, const std::vector<Vec2>& polygon, const Vec2& low, const Vec2& high) const;

  std::vector<Edge> edges_;
  std::vector<int> bin_start_, bin_edges_, row_start_, row_edges_;
  Vec2 min_, max_, width_;
  int bins_[2];
  double tolerance_;
};

}  // namespace berm
