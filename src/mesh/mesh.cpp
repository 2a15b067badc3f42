#include "mesh/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>

#include "base/error.hpp"

namespace berm {

namespace {

struct Side {
  std::uint64_t key;  ///< both end nodes, the smaller one first
  int cell, local;
};

std::vector<Side> sorted_sides(const Mesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(4 * mesh.kinds.size());
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const int n = corners_of(mesh.kinds[c]);
    const int* nodes = mesh.cell(c);
    for (int e = 0; e < n; ++e) {
      const auto [lo, hi] = std::minmax(nodes[e], nodes[(e + 1) % n]);
      sides.push_back({(static_cast<std::uint64_t>(lo) << 32) | static_cast<std::uint32_t>(hi), c, e});
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.key != b.key ? a.key < b.key : a.cell != b.cell ? a.cell < b.cell : a.local < b.local;
  });
  return sides;
}

/// Calls visit(first, count) for every group of sides with the same end nodes.
template <class Visit>
void for_each_edge(const Mesh& mesh, Visit visit) {
  const std::vector<Side> sides = sorted_sides(mesh);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t j = i + 1;
    while (j < sides.size() && sides[j].key == sides[i].key) ++j;
    if (j - i > 2) {
      const Vec2& x = mesh.nodes[mesh.cell(sides[i].cell)[sides[i].local]];
      throw InputError(fmt::format("mesh: an edge at ({:g}, {:g}) is shared by {} cells (at most two can share one)",
                                   x.x(), x.y(), j - i));
    }
    visit(&sides[i], static_cast<int>(j - i));
    i = j;
  }
}

}  // namespace

double cell_area(const Mesh& mesh, int c) {
  const int n = corners_of(mesh.kinds[c]);
  const int* nodes = mesh.cell(c);
  const Vec2& origin = mesh.nodes[nodes[0]];
  double twice = 0.0;
  for (int i = 1; i + 1 < n; ++i) {
    const Vec2 a = mesh.nodes[nodes[i]] - origin, b = mesh.nodes[nodes[i + 1]] - origin;
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return 0.5 * twice;
}

std::vector<Edge> boundary_edges(const Mesh& mesh) {
  std::vector<Edge> edges;
  for_each_edge(mesh, [&](const Side* side, int count) {
    if (count == 1) edges.push_back({side->cell, side->local});
  });
  std::sort(edges.begin(), edges.end(),
            [](const Edge& a, const Edge& b) { return a.cell != b.cell ? a.cell < b.cell : a.local < b.local; });
  return edges;
}

std::vector<InteriorEdge> interior_edges(const Mesh& mesh) {
  std::vector<InteriorEdge> edges;
  for_each_edge(mesh, [&](const Side* side, int count) {
    if (count != 2) return;
    const int* nodes = mesh.cell(side->cell);
    const int n = corners_of(mesh.kinds[side->cell]);
    edges.push_back({side[0].cell, side[1].cell, nodes[side->local], nodes[(side->local + 1) % n]});
  });
  std::sort(edges.begin(), edges.end(), [](const InteriorEdge& a, const InteriorEdge& b) {
    return a.cell_a != b.cell_a ? a.cell_a < b.cell_a : a.cell_b < b.cell_b;
  });
  return edges;
}

}  // namespace berm
