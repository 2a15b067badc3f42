#include "mesh/box_mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <unordered_map>

#include "base/error.hpp"

namespace berm {

namespace {

void collect_lines(const PlaneShape& shape, std::array<std::vector<double>, 2>& lines) {
  if (const Box* box = std::get_if<Box>(&shape.form)) {
    for (int d = 0; d < 2; ++d) lines[d].insert(lines[d].end(), {box->min[d], box->max[d]});
  } else {
    for (const PlaneShape& part : std::get<Combination>(shape.form).parts) collect_lines(part, lines);
  }
}

/// Adds the cell's nodes to the mesh on first use.
class NodeTable {
public:
  NodeTable(Mesh& mesh, const std::vector<double>& x, const std::vector<double>& y)
      : mesh_(mesh), x_(x), y_(y), number_(x.size() * y.size(), -1) {}
  int operator()(std::size_t i, std::size_t j) {
    int& number = number_[j * x_.size() + i];
    if (number < 0) {
      number = mesh_.n_nodes();
      mesh_.nodes.emplace_back(x_[i], y_[j], 0.0);
    }
    return number;
  }

private:
  Mesh& mesh_;
  const std::vector<double>&x_, &y_;
  std::vector<int> number_;
};

/// A quad, or its two halves (diagonal from the first to the third corner if `right`).
void add_cell(Mesh& mesh, BodyMeshKind kind, const std::array<int, 4>& q, bool right) {
  if (kind == BodyMeshKind::quads) {
    mesh.add_cell(CellKind::quad4, q.data());
    return;
  }
  const int lower[3] = {q[0], q[1], right ? q[2] : q[3]}, upper[3] = {right ? q[0] : q[1], q[2], q[3]};
  mesh.add_cell(CellKind::tri3, lower);
  mesh.add_cell(CellKind::tri3, upper);
}

}  // namespace

Mesh mesh_disc(const Disc& disc, const BodyMeshOptions& options) {
  const int n = std::max(1, static_cast<int>(std::lround(std::sqrt(std::numbers::pi) * disc.radius / options.size)));
  if (n > 5000) throw InputError(fmt::format("mesh: size {:g} m gives too many cells", options.size));
  Mesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) {
      const double u = 2.0 * i / n - 1.0, v = 2.0 * j / n - 1.0;
      const Vec2 at(u * std::sqrt(1.0 - 0.5 * v * v), v * std::sqrt(1.0 - 0.5 * u * u));
      mesh.nodes.push_back(in_space(disc.centre + disc.radius * at));
    }
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i;
      add_cell(mesh, options.kind, {a, a + 1, a + n + 2, a + n + 1}, (i + j) % 2 == 0);
    }
  return options.order == 2 ? with_mid_sides(mesh) : mesh;
}

bool only_boxes(const PlaneShape& shape) {
  if (std::holds_alternative<Box>(shape.form)) return true;
  const Combination* combination = std::get_if<Combination>(&shape.form);
  return combination && std::all_of(combination->parts.begin(), combination->parts.end(), only_boxes);
}

Mesh mesh_boxes(const PlaneShape& shape, const BodyMeshOptions& options) {
  const PlaneRegion region(shape);
  std::array<std::vector<double>, 2> breaks;
  collect_lines(shape, breaks);
  const Vec2 low = region.min(), high = region.max();
  const Vec2 cells = (high - low) / options.size;
  if (cells.x() * cells.y() > 1e8)
    throw InputError(fmt::format("mesh: size {:g} m gives too many cells", options.size));
  const std::vector<double> x = mesh_lines(breaks[0], low.x(), high.x(), options.size);
  const std::vector<double> y = mesh_lines(breaks[1], low.y(), high.y(), options.size);
  Mesh mesh;
  NodeTable node(mesh, x, y);
  for (std::size_t j = 0; j + 1 < y.size(); ++j)
    for (std::size_t i = 0; i + 1 < x.size(); ++i) {
      if (!region.contains(Vec2(0.5 * (x[i] + x[i + 1]), 0.5 * (y[j] + y[j + 1])))) continue;
      add_cell(mesh, options.kind, {node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)}, (i + j) % 2 == 0);
    }
  return options.order == 2 ? with_mid_sides(mesh) : mesh;
}

std::vector<double> mesh_lines(std::vector<double> breaks, double low, double high, double size) {
  const double tolerance = 1e-9 * (high - low);
  std::sort(breaks.begin(), breaks.end());
  std::vector<double> kept;
  for (double x : breaks)
    if (x >= low - tolerance && x <= high + tolerance && (kept.empty() || x - kept.back() > tolerance))
      kept.push_back(x);
  std::vector<double> lines = {kept[0]};
  for (std::size_t k = 0; k + 1 < kept.size(); ++k) {
    const double length = kept[k + 1] - kept[k];
    // Halves are rounded up in spite of rounding errors: 14.5 cells become 15 on every side of a symmetric body.
    const int n = std::max(1, static_cast<int>(std::floor(length / size + 0.5 + 1e-9)));
    for (int i = 1; i <= n; ++i) lines.push_back(i == n ? kept[k + 1] : kept[k] + i * length / n);
  }
  return lines;
}

Mesh with_mid_sides(const Mesh& linear) {
  constexpr CellKind quadratic[] = {CellKind::tri6,  CellKind::quad8, CellKind::tri6,  CellKind::quad8,
                                    CellKind::tet10, CellKind::hex20, CellKind::tet10, CellKind::hex20};
  Mesh mesh;
  mesh.nodes = linear.nodes;
  std::unordered_map<std::uint64_t, int> mid_of;
  for (int c = 0; c < linear.n_cells(); ++c) {
    const CellKind kind = linear.kinds[c];
    std::vector<int> nodes(linear.cell(c), linear.cell(c) + corners_of(kind));
    for (const auto& [i, j] : edges_of(kind)) {
      const auto [a, b] = std::minmax(nodes[i], nodes[j]);
      const auto [place, is_new] = mid_of.emplace(static_cast<std::uint64_t>(a) << 32 | b, mesh.n_nodes());
      if (is_new) mesh.nodes.push_back(0.5 * (mesh.nodes[a] + mesh.nodes[b]));
      nodes.push_back(place->second);
    }
    mesh.add_cell(quadratic[static_cast<int>(kind)], nodes.data());
  }
  return mesh;
}

}  // namespace berm
