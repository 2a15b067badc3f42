#pragma once
/// Places that travel with the cells that hold them.

#include <algorithm>
#include <vector>

#include "bc/surface.hpp"

namespace berm {

/// The place by which a point finds its process.
template <class Point>
Anchor& place_of(Point& p) {
  return p.anchor;
}

/// Points go to the processes that own their cells, and lie in the order of their ids there. Collective.
template <class Point>
void travel(std::vector<Point>& points, const Discretisation& d) {
  const Comm& comm = d.comm();
  std::vector<int> owner;
  comm.agree([&] {
    for (Point& p : points) owner.push_back(d.locate(place_of(p)));
  });
  const bool leaving = std::any_of(owner.begin(), owner.end(), [&](int rank) { return rank != comm.rank(); });
  if (!comm.any(leaving)) return;
  std::vector<std::vector<Point>> to(comm.size());
  for (std::size_t k = 0; k < points.size(); ++k) to[owner[k]].push_back(points[k]);
  points = std::move(to[comm.rank()]);
  to[comm.rank()].clear();
  for (const auto& from : comm.exchange(to)) points.insert(points.end(), from.begin(), from.end());
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.id < b.id; });
}

}  // namespace berm
