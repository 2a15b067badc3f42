#include "bc/surface.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "mesh/closest_point.hpp"

namespace berm {

Vec3 closest_on_piece(const Vec3& x, const SurfacePoint& s) {
  if (s.n_corners == 0) {
    const Vec3 along(-s.normal.y(), s.normal.x(), 0.0);
    return s.X + std::clamp((x - s.X).dot(along), -0.5 * s.size, 0.5 * s.size) * along;
  }
  const auto& c = s.corner;
  Vec3 best = closest_on_triangle(x, c[0], c[1], c[2]).point;
  if (s.n_corners == 4)
    if (const Vec3 other = closest_on_triangle(x, c[0], c[2], c[3]).point; (x - other).norm() < (x - best).norm())
      best = other;
  return best;
}

double share_inside(const Where& where, const SurfacePoint& s, int dimension) {
  int count = 0, all = 0;
  const auto look = [&](const Vec3& x) {
    count += inside(where, x);
    ++all;
  };
  if (dimension == 2) {
    const Vec3 along(-s.normal.y(), s.normal.x(), 0.0);
    for (int i = 0; i < 100; ++i) look(s.X + s.size * ((i + 0.5) / 100 - 0.5) * along);
    return double(count) / all;
  }
  // Equal parts of the triangle, or of the square that the quadrilateral is the image of.
  constexpr int n = 10;
  const auto& c = s.corner;
  const bool quadrilateral = s.n_corners == 4;
  const auto place = [&](double u, double v) {
    return quadrilateral ? Vec3((1.0 - u) * ((1.0 - v) * c[0] + v * c[3]) + u * ((1.0 - v) * c[1] + v * c[2]))
                         : Vec3(c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]));
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      if (quadrilateral) {
        look(place((i + 0.5) / n, (j + 0.5) / n));
        continue;
      }
      if (i + j < n) look(place((i + 1.0 / 3.0) / n, (j + 1.0 / 3.0) / n));
      if (i + j < n - 1) look(place((i + 2.0 / 3.0) / n, (j + 2.0 / 3.0) / n));
    }
  return double(count) / all;
}

bool in_group(const SurfacePoint& s, const std::string& group) {
  return std::find(s.groups.begin(), s.groups.end(), group) != s.groups.end();
}

std::vector<SurfacePart> caught_surface(const std::string& table, const Where& where, int body,
                                        const std::string& body_name, const std::vector<SurfacePoint>& surface,
                                        int dimension) {
  std::vector<SurfacePart> parts;
  for (const SurfacePoint& s : surface) {
    if (s.body != body || (where.group && !in_group(s, *where.group))) continue;
    if (const double share = share_inside(where, s, dimension); share != 0.0) parts.push_back({s, share});
  }
  if (parts.empty())
    throw InputError(
        fmt::format("[{}] catches no part of the surface of body \"{}\": check its where", table, body_name));
  return parts;
}

bool overlap(const std::vector<SurfacePart>& a, const std::vector<SurfacePart>& b) {
  std::map<const SurfacePoint*, double> shares;
  for (const SurfacePart& part : a) shares[&part.piece] += part.share;
  return std::any_of(b.begin(), b.end(), [&](const SurfacePart& part) {
    const auto found = shares.find(&part.piece);
    return found != shares.end() && found->second + part.share > 1.0 + 1e-9;
  });
}

std::vector<SurfacePart> without_strips(const std::vector<SurfacePart>& parts) {
  constexpr double whole = 1.0 - 1e-9, elsewhere = 0.7, alike = 0.95, little = 0.1;
  Vec3 main = Vec3::Zero();
  for (const auto& [s, share] : parts) main += share * s.area * s.normal;
  if (main.isZero(0.0)) return parts;
  main.normalize();
  std::vector<SurfacePart> meant;
  double all = 0.0, strips = 0.0;
  for (const SurfacePart& part : parts) {
    const double along = main.dot(part.piece.normal), area = part.share * part.piece.area;
    all += area;
    if (along > alike) {
      meant.push_back(part);
      continue;
    }
    if (along > elsewhere || part.share >= whole) return parts;  // a curved face, or more of another one than a strip
    strips += area;
  }
  return strips < little * all ? meant : parts;
}

}  // namespace berm
