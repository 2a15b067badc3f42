#include "mesh/triangle_tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

#include "mesh/closest_point.hpp"

namespace berm {

namespace {

double squared_distance(const Vec3& x, const Vec3& low, const Vec3& high) {
  return (low - x).cwiseMax(x - high).cwiseMax(0.0).squaredNorm();
}

}  // namespace

TriangleTree::TriangleTree(const TriangleSurface& surface) : surface_(surface), order_(surface.triangles.size()) {
  std::iota(order_.begin(), order_.end(), 0);
  nodes_.reserve(order_.size());
  build(0, static_cast<int>(order_.size()));
}

int TriangleTree::build(int first, int last) {
  constexpr int leaf = 4;
  Vec3 low = surface_.corner(order_[first], 0), high = low;
  for (int i = first; i < last; ++i)
    for (int c = 0; c < 3; ++c) {
      low = low.cwiseMin(surface_.corner(order_[i], c));
      high = high.cwiseMax(surface_.corner(order_[i], c));
    }
  const int number = static_cast<int>(nodes_.size());
  nodes_.push_back({low, high, first, last - first, -1});
  if (last - first <= leaf) return number;
  int axis;
  (high - low).maxCoeff(&axis);
  const auto middle_of = [&](int t) {
    return surface_.corner(t, 0)[axis] + surface_.corner(t, 1)[axis] + surface_.corner(t, 2)[axis];
  };
  const int middle = (first + last) / 2;
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last, [&](int s, int t) {
    const double ms = middle_of(s), mt = middle_of(t);
    return ms < mt || (ms == mt && s < t);
  });
  const int left = build(first, middle), right = build(middle, last);
  nodes_[number].first = left;
  nodes_[number].count = 0;
  nodes_[number].right = right;
  return number;
}

TriangleTree::Hit TriangleTree::nearest(const Vec3& x) const {
  Hit hit{-1, Vec3::Zero(), false};
  double best = std::numeric_limits<double>::infinity();
  std::vector<std::pair<int, double>> stack = {{0, 0.0}};
  while (!stack.empty()) {
    const auto [number, bound] = stack.back();
    stack.pop_back();
    if (bound >= best) continue;
    const Node& node = nodes_[number];
    for (int i = node.first; i < node.first + node.count; ++i) {
      const int t = order_[i];
      const ClosestPoint c =
          closest_on_triangle(x, surface_.corner(t, 0), surface_.corner(t, 1), surface_.corner(t, 2));
      const double distance = (x - c.point).squaredNorm();
      if (distance >= best) continue;
      best = distance;
      hit = {t, c.point, c.interior};
    }
    if (node.count > 0) continue;
    const Node &left = nodes_[node.first], &right = nodes_[node.right];
    const std::pair<int, double> l{node.first, squared_distance(x, left.low, left.high)},
        r{node.right, squared_distance(x, right.low, right.high)};
    stack.push_back(l.second < r.second ? r : l);
    stack.push_back(l.second < r.second ? l : r);
  }
  return hit;
}

}  // namespace berm
