#include "points/seeding.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "shape/quadrature.hpp"

namespace berm {
namespace {

std::vector<Vec2> corners(const Mesh& mesh, int cell) {
  std::vector<Vec2> polygon;
  for (int k = 0; k < corners_of(mesh.kinds[cell]); ++k) polygon.push_back(mesh.nodes[mesh.cell(cell)[k]]);
  return polygon;
}

Vec2 bilinear(const std::vector<Vec2>& p, double xi, double eta) {
  return 0.25 * ((1 - xi) * (1 - eta) * p[0] + (1 + xi) * (1 - eta) * p[1] + (1 + xi) * (1 + eta) * p[2] +
                 (1 - xi) * (1 + eta) * p[3]);
}

/// The cell cut into n x n parts (quads) or n^2 similar triangles.
std::vector<std::vector<Vec2>> parts(const std::vector<Vec2>& cell, int n) {
  std::vector<std::vector<Vec2>> out;
  if (cell.size() == 4) {
    auto at = [&](int i, int j) { return bilinear(cell, -1.0 + 2.0 * i / n, -1.0 + 2.0 * j / n); };
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) out.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    return out;
  }
  auto at = [&](int i, int j) -> Vec2 {
    return cell[0] + (cell[1] - cell[0]) * (double(i) / n) + (cell[2] - cell[0]) * (double(j) / n);
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i + j < n; ++i) {
      out.push_back({at(i, j), at(i + 1, j), at(i, j + 1)});
      if (i + j < n - 1) out.push_back({at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return out;
}

double area_of(const std::vector<Vec2>& p) {
  double twice = 0.0;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const Vec2 &a = p[k], &b = p[(k + 1) % p.size()];
    twice += a.x() * b.y() - b.x() * a.y();
  }
  return 0.5 * twice;
}

/// Gauss points of an uncut quad cell; on a distorted quad the weights follow the Jacobian.
void seed_gauss_quad(const std::vector<Vec2>& p, int n, SeededPoints& out) {
  for (const QuadraturePoint& q : gauss_square(n)) {
    const double xi = q.xi.x(), eta = q.xi.y();
    const Vec2 dx = 0.25 * ((1 - eta) * (p[1] - p[0]) + (1 + eta) * (p[2] - p[3]));
    const Vec2 dy = 0.25 * ((1 - xi) * (p[3] - p[0]) + (1 + xi) * (p[2] - p[1]));
    out.x.push_back(bilinear(p, xi, eta));
    out.area.push_back(q.weight * (dx.x() * dy.y() - dx.y() * dy.x()));
  }
}

void seed_gauss_triangle(const std::vector<Vec2>& p, int points, SeededPoints& out) {
  for (const QuadraturePoint& q : gauss_triangle(points)) {
    out.x.push_back(p[0] + (p[1] - p[0]) * q.xi.x() + (p[2] - p[0]) * q.xi.y());
    out.area.push_back(q.weight * 2.0 * area_of(p));
  }
}

/// n = 1, 2, 3, 4 points a direction correspond to triangle rules of 1, 3, 6, 12 points.
int triangle_rule(int per_direction) {
  const int rules[] = {1, 3, 6, 12};
  return rules[std::min(per_direction, 4) - 1];
}

void seed_whole_cell(const std::vector<Vec2>& cell, const PointSeeding& seeding, SeededPoints& out) {
  const int n = seeding.per_direction;
  if (seeding.placement == PointSeeding::Placement::gauss && n <= 4) {
    if (cell.size() == 4)
      seed_gauss_quad(cell, n, out);
    else
      seed_gauss_triangle(cell, triangle_rule(n), out);
    return;
  }
  for (const auto& part : parts(cell, n)) {
    Vec2 centre = Vec2::Zero();
    for (const Vec2& corner : part) centre += corner / static_cast<double>(part.size());
    out.x.push_back(centre);
    out.area.push_back(area_of(part));
  }
}

}  // namespace

SeededPoints seed_from_grid(const Region& region, const Grid& grid, const PointSeeding& seeding,
                            const std::string& body) {
  const Mesh& mesh = grid.mesh;
  std::vector<std::vector<Vec2>> cells;
  cells.reserve(mesh.n_cells());
  for (int c = 0; c < mesh.n_cells(); ++c) cells.push_back(corners(mesh, c));
  const std::vector<signed char> inside = region.classify(cells);

  SeededPoints out;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    if (inside[c] == 0) continue;
    if (inside[c] == 1) {
      seed_whole_cell(cells[c], seeding, out);
      continue;
    }
    // Slivers below 1e-12 of the part are rounding, not material.
    for (const auto& part : parts(cells[c], seeding.per_direction)) {
      const Piece piece = region.clip(part);
      if (piece.area <= 1e-12 * area_of(part)) continue;
      out.x.push_back(piece.centroid);
      out.area.push_back(piece.area);
    }
  }
  double sum = 0.0;
  for (double a : out.area) sum += a;
  if (std::abs(sum - region.area()) > 1e-6 * region.area())
    throw InputError(fmt::format(
        "body \"{}\" has an area of {:.6g} m2, but only {:.6g} m2 lie inside the background grid: make the grid larger",
        body, region.area(), sum));
  return out;
}

SeededPoints seed_from_mesh(const Mesh& mesh, int per_element) {
  SeededPoints out;
  const int n = static_cast<int>(std::lround(std::sqrt(per_element)));
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const std::vector<Vec2> cell = corners(mesh, c);
    if (cell.size() == 4 && n * n != per_element)
      throw InputError(fmt::format("a quad takes 1, 4, 9 or 16 points, not {}", per_element));
    if (cell.size() == 4)
      seed_gauss_quad(cell, n, out);
    else
      seed_gauss_triangle(cell, per_element, out);
  }
  return out;
}

void fit_to_cells(SeededPoints& points, const Region& region, const Grid& grid) {
  const Mesh& mesh = grid.mesh;
  std::vector<std::vector<int>> in_cell(mesh.n_cells());
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    const int cell = grid.locator->locate(points.x[p], -1);
    if (cell >= 0) in_cell[cell].push_back(static_cast<int>(p));
  }
  points.shift.assign(points.x.size(), Vec2::Zero());
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const std::vector<Vec2> polygon = corners(mesh, c);
    const Piece piece = region.clip(polygon);
    // A point on the very edge of a cell that the body does not enter keeps its own area.
    if (piece.area <= 1e-9 * area_of(polygon)) continue;
    if (in_cell[c].empty()) {
      points.x.push_back(piece.centroid);
      points.area.push_back(piece.area);
      points.shift.push_back(Vec2::Zero());
      continue;
    }
    double area = 0.0;
    Vec2 mean = Vec2::Zero();
    for (int p : in_cell[c]) {
      area += points.area[p];
      mean += points.area[p] * points.x[p];
    }
    mean /= area;
    for (int p : in_cell[c]) {
      points.area[p] *= piece.area / area;
      points.shift[p] = piece.centroid - mean;
    }
  }
}

}  // namespace berm
