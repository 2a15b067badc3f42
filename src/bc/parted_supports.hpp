#pragma once
/// Supports that touch and move differently.   [boundaries, "Supports that touch"]

#include <array>
#include <cmath>
#include <map>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

inline constexpr const char* parted =
    "{} that touch each other move differently: a cell of each is left free where they meet, since nodes that both reach "
    "would have to follow both";

/// Takes out the surface points that lie within `reach` of one that moves otherwise, and returns how many: the
/// displacement of the grid is continuous, so two penalties would pull at the nodes that they share.
/// `differ(a, b)`: do the supports of two points prescribe different motions?
template <class Point, class Differ>
int part_supports(std::vector<Point>& points, double reach, Differ differ) {
  using Place = std::array<long, 3>;
  const auto place_of = [reach](const Vec3& x) {
    return Place{std::lround(x.x() / reach), std::lround(x.y() / reach), std::lround(x.z() / reach)};
  };
  std::map<Place, std::vector<const Point*>> bins;
  for (const Point& p : points) bins[place_of(p.anchor.X)].push_back(&p);
  const auto is_contested = [&](const Point& p) {
    const Place at = place_of(p.anchor.X);
    for (long i = -1; i <= 1; ++i)
      for (long j = -1; j <= 1; ++j)
        for (long k = -1; k <= 1; ++k) {
          const auto bin = bins.find({at[0] + i, at[1] + j, at[2] + k});
          if (bin == bins.end()) continue;
          for (const Point* q : bin->second)
            if (differ(p, *q) && (p.anchor.X - q->anchor.X).norm() < reach) return true;
        }
    return false;
  };
  std::vector<Point> left;
  for (const Point& p : points) {
    if (is_contested(p)) continue;
    left.push_back(p);
    left.back().id = static_cast<int>(left.size()) - 1;
  }
  const int taken = static_cast<int>(points.size() - left.size());
  points = std::move(left);
  return taken;
}

}  // namespace berm
