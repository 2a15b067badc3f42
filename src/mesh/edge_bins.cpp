#include "mesh/edge_bins.hpp"

#include <algorithm>
#include <cmath>

namespace berm {

namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Compressed lists: places(item, put) calls put(list) for every list that item belongs to.
template <class Places>
void fill_lists(int n_items, int n_lists, Places places, std::vector<int>& start, std::vector<int>& items) {
  start.assign(n_lists + 1, 0);
  for (int i = 0; i < n_items; ++i) places(i, [&](int list) { ++start[list + 1]; });
  for (int l = 0; l < n_lists; ++l) start[l + 1] += start[l];
  items.resize(start.back());
  std::vector<int> next(start.begin(), start.end() - 1);
  for (int i = 0; i < n_items; ++i) places(i, [&](int list) { items[next[list]++] = i; });
}

double squared_distance(const Vec2& x, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double t = std::clamp((x - a).dot(along) / along.squaredNorm(), 0.0, 1.0);
  return (x - a - t * along).squaredNorm();
}

}  // namespace

EdgeBins::EdgeBins(const std::vector<Ring>& rings) {
  min_ = max_ = rings.front().front();
  for (const Ring& ring : rings)
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
      if (a != b) edges_.push_back({a, b});
      min_ = min_.cwiseMin(a);
      max_ = max_.cwiseMax(a);
    }
  tolerance_ = 1e-12 * (max_ - min_).maxCoeff();
  // About as many bins a direction as a quarter of the edges: a bin holds few edges, the table stays small.
  const int n = std::clamp(static_cast<int>(edges_.size()) / 4, 8, 512);
  for (int d = 0; d < 2; ++d) {
    bins_[d] = n;
    width_[d] = (max_[d] - min_[d]) / n;
  }
  const auto rows = [&](int e, auto put) {
    const auto [lo, hi] = std::minmax(edges_[e].a.y(), edges_[e].b.y());
    for (int j = index(1, lo - tolerance_); j <= index(1, hi + tolerance_); ++j) put(j);
  };
  const auto bins = [&](int e, auto put) {
    const auto [lo, hi] = std::minmax(edges_[e].a.x(), edges_[e].b.x());
    rows(e, [&](int j) {
      for (int i = index(0, lo - tolerance_); i <= index(0, hi + tolerance_); ++i) put(j * bins_[0] + i);
    });
  };
  fill_lists(static_cast<int>(edges_.size()), bins_[1], rows, row_start_, row_edges_);
  fill_lists(static_cast<int>(edges_.size()), bins_[0] * bins_[1], bins, bin_start_, bin_edges_);
}

int EdgeBins::index(int d, double x) const {
  return static_cast<int>(std::clamp(std::floor((x - min_[d]) / width_[d]), 0.0, bins_[d] - 1.0));
}

bool EdgeBins::contains(const Vec2& x) const {
  for (int d = 0; d < 2; ++d)
    if (!(x[d] >= min_[d] - tolerance_ && x[d] <= max_[d] + tolerance_)) return false;
  const int row = index(1, x.y()), bin = row * bins_[0] + index(0, x.x());
  for (int k = bin_start_[bin]; k < bin_start_[bin + 1]; ++k) {
    const Edge& e = edges_[bin_edges_[k]];
    if (squared_distance(x, e.a, e.b) <= tolerance_ * tolerance_) return true;
  }
  bool inside = false;
  for (int k = row_start_[row]; k < row_start_[row + 1]; ++k) {
    const Edge& e = edges_[row_edges_[k]];
    if ((e.a.y() > x.y()) == (e.b.y() > x.y())) continue;
    if (x.x() < e.a.x() + (x.y() - e.a.y()) * (e.b.x() - e.a.x()) / (e.b.y() - e.a.y())) inside = !inside;
  }
  return inside;
}

bool EdgeBins::near(const Edge& edge, const std::vector<Vec2>& polygon, const Vec2& low, const Vec2& high) const {
  for (int d = 0; d < 2; ++d)
    if (std::max(edge.a[d], edge.b[d]) < low[d] || std::min(edge.a[d], edge.b[d]) > high[d]) return false;
  // All corners on one side of the edge's line: no contact.
  const Vec2 along = edge.b - edge.a;
  const double margin = tolerance_ * along.norm();
  bool left = false, right = false;
  for (const Vec2& v : polygon) {
    const double side = cross(along, v - edge.a);
    left = left || side > -margin;
    right = right || side < margin;
  }
  return left && right;
}

bool EdgeBins::any_near(const std::vector<Vec2>& polygon) const {
  Vec2 low = polygon[0], high = polygon[0];
  for (const Vec2& v : polygon) {
    low = low.cwiseMin(v);
    high = high.cwiseMax(v);
  }
  low.array() -= tolerance_;
  high.array() += tolerance_;
  for (int d = 0; d < 2; ++d)
    if (high[d] < min_[d] || low[d] > max_[d]) return false;
  for (int j = index(1, low.y()); j <= index(1, high.y()); ++j)
    for (int i = index(0, low.x()); i <= index(0, high.x()); ++i)
      for (int k = bin_start_[j * bins_[0] + i]; k < bin_start_[j * bins_[0] + i + 1]; ++k)
        if (near(edges_[bin_edges_[k]], polygon, low, high)) return true;
  return false;
}

}  // namespace berm
