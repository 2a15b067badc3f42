#include "mesh/solid_bins.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "mesh/closest_point.hpp"
#include "mesh/solid_angle.hpp"

namespace berm {

namespace {

constexpr int most_bins = 32;  ///< in each direction

double winding(const Soup& soup, const Vec3& x) {
  double sum = 0.0;
  for (const SoupTriangle& t : soup) sum += winding_part(x, t.a, t.b, t.c);
  return sum;
}

std::vector<HalfSpace> half_spaces(const ConvexCell& cell) {
  std::vector<HalfSpace> halves;
  halves.reserve(cell.faces.size());
  for (const std::vector<int>& face : cell.faces) {
    Vec3 normal = Vec3::Zero(), centre = Vec3::Zero();
    for (std::size_t i = 0; i < face.size(); ++i) {
      const Vec3 &a = cell.vertices[face[i]], &b = cell.vertices[face[(i + 1) % face.size()]];
      normal += (a - cell.vertices[face[0]]).cross(b - cell.vertices[face[0]]);
      centre += a;
    }
    normal.normalize();
    halves.push_back({normal, normal.dot(centre) / static_cast<double>(face.size())});
  }
  return halves;
}

}  // namespace

Soup soup_of(const TriangleSurface& surface) {
  Soup soup;
  soup.reserve(surface.triangles.size());
  for (int t = 0; t < surface.n_triangles(); ++t)
    soup.push_back({surface.corner(t, 0), surface.corner(t, 1), surface.corner(t, 2), false});
  return soup;
}

SolidBins::SolidBins(const TriangleSurface& surface) {
  const Vec3 low = low_corner(surface), high = high_corner(surface), extent = high - low;
  tolerance_ = 1e-12 * std::max({extent.maxCoeff(), low.cwiseAbs().maxCoeff(), high.cwiseAbs().maxCoeff()});
  double area = 0.0;
  for (int t = 0; t < surface.n_triangles(); ++t) area += area_vector(surface, t).norm();
  const double width = std::max(extent.maxCoeff() / most_bins, 2.0 * std::sqrt(area / surface.n_triangles()));
  // Odd margins, so that bin walls rarely coincide with faces of the body.
  const double margin = 0.0173205 * extent.maxCoeff();
  for (int d = 0; d < 3; ++d) {
    count_[d] = std::clamp(static_cast<int>(std::ceil(extent[d] / width)), 1, most_bins);
    const double from = low[d] - margin, step = (extent[d] + 2.2360680 * margin) / count_[d];
    for (int i = 0; i <= count_[d]; ++i) planes_[d].push_back(from + i * step);
  }
  states_.assign(static_cast<std::size_t>(count_[0]) * count_[1] * count_[2], outside);
  soup_of_.assign(states_.size(), -1);
  bisect(
      soup_of(surface), planes_, 0.0,
      [&](const BoxRange& range) {
        for (int k = range.first[2]; k < range.last[2]; ++k)
          for (int j = range.first[1]; j < range.last[1]; ++j)
            for (int i = range.first[0]; i < range.last[0]; ++i) states_[number(i, j, k)] = inside;
      },
      [&](const BoxRange& range, const Soup& soup) {
        const int n = number(range.first[0], range.first[1], range.first[2]);
        states_[n] = cut_through;
        soup_of_[n] = static_cast<int>(soups_.size());
        soups_.push_back(soup);
        soups_.back().shrink_to_fit();
      });
}

/// Below 0 or count: outside of the bins.
int SolidBins::index(int d, double x) const {
  const std::vector<double>& planes = planes_[d];
  return static_cast<int>(std::upper_bound(planes.begin(), planes.end(), x) - planes.begin()) - 1;
}

bool SolidBins::contains(const Vec3& x) const {
  int at[3];
  Vec3 inner = x;
  for (int d = 0; d < 3; ++d) {
    at[d] = index(d, x[d]);
    if (!(at[d] >= 0 && at[d] < count_[d])) return false;
    // In a wall of the bin the solid angle has no value: step off by less than the distance to the surface.
    inner[d] = std::clamp(x[d], planes_[d][at[d]] + 0.25 * tolerance_, planes_[d][at[d] + 1] - 0.25 * tolerance_);
  }
  const int n = number(at[0], at[1], at[2]);
  if (states_[n] != cut_through) return states_[n] == inside;
  const Soup& soup = soups_[soup_of_[n]];
  for (const SoupTriangle& t : soup)
    if (!t.cap && (closest_on_triangle(x, t.a, t.b, t.c).point - x).norm() <= tolerance_) return true;
  return winding(soup, inner) > 0.5;
}

Soup SolidBins::box(int i, int j, int k) const {
  const int at[3] = {i, j, k};
  std::array<Vec3, 8> x;
  for (int c = 0; c < 8; ++c)  // VTK order
    x[c] = Vec3(planes_[0][at[0] + ((c + 1) / 2 % 2)], planes_[1][at[1] + (c / 2 % 2)], planes_[2][at[2] + c / 4]);
  Soup soup;
  for (const std::vector<int>& f : hexahedron_cell(x).faces) {
    soup.push_back({x[f[0]], x[f[1]], x[f[2]], true});
    soup.push_back({x[f[0]], x[f[2]], x[f[3]], true});
  }
  return soup;
}

SolidMoments SolidBins::clip(const ConvexCell& cell, const Vec3& origin) const {
  Vec3 low = cell.vertices[0], high = low;
  for (const Vec3& x : cell.vertices) {
    low = low.cwiseMin(x);
    high = high.cwiseMax(x);
  }
  int first[3], last[3];
  for (int d = 0; d < 3; ++d) {
    first[d] = std::max(index(d, low[d]), 0);
    last[d] = std::min(index(d, high[d]), count_[d] - 1);
  }
  SolidMoments moments;
  const std::vector<HalfSpace> halves = half_spaces(cell);
  Soup soup, next;
  for (int k = first[2]; k <= last[2]; ++k)
    for (int j = first[1]; j <= last[1]; ++j)
      for (int i = first[0]; i <= last[0]; ++i) {
        const int n = number(i, j, k);
        if (states_[n] == outside) continue;
        soup = states_[n] == inside ? box(i, j, k) : soups_[soup_of_[n]];
        for (const HalfSpace& half : halves) {
          cut(soup, half, next);
          soup.swap(next);
        }
        moments.add(soup, origin);
      }
  return moments;
}

}  // namespace berm
