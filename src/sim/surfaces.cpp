#include "sim/surfaces.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/error.hpp"
#include "method/depth.hpp"

namespace berm {
namespace {

/// measure: length [m] in plane models, area [m2] in space.
SurfacePoint surface_point(const Case& c, int body, const Vec3& x, const Vec3& normal, double measure) {
  SurfacePoint s;
  s.body = body;
  s.X = x;
  s.normal = normal;
  s.area = measure * depth(c.space, c.thickness, x.x());
  s.size = c.space == Space::solid ? std::sqrt(measure) : measure;
  return s;
}

/// A straight-sided face in pieces.
struct FacePieces {
  std::vector<Vec3> centre;
  std::vector<double> measure;
  std::vector<std::array<Vec3, 4>> corner;  ///< 3 or 4; not of edges
};

FacePieces divide_edge(const Vec3& a, const Vec3& b, int n) {
  FacePieces out;
  for (int k = 0; k < n; ++k) {
    out.centre.push_back(a + (b - a) * ((k + 0.5) / n));
    out.measure.push_back((b - a).norm() / n);
  }
  return out;
}

FacePieces divide_triangle(const std::array<Vec3, 4>& p, int n) {
  FacePieces out;
  const double area = 0.5 * (p[1] - p[0]).cross(p[2] - p[0]).norm() / (n * n);
  const auto at = [&](double i, double j) -> Vec3 { return p[0] + (p[1] - p[0]) * (i / n) + (p[2] - p[0]) * (j / n); };
  const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
    out.centre.push_back((a + b + c) / 3.0);
    out.measure.push_back(area);
    out.corner.push_back({a, b, c, Vec3::Zero()});
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i + j < n; ++i) {
      add(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + j < n - 1) add(at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
    }
  return out;
}

FacePieces divide_quad(const std::array<Vec3, 4>& p, int n) {
  FacePieces out;
  const auto at = [&](double u, double v) -> Vec3 {
    return (1.0 - u) * (1.0 - v) * p[0] + u * (1.0 - v) * p[1] + u * v * p[2] + (1.0 - u) * v * p[3];
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const double u = (i + 0.5) / n, v = (j + 0.5) / n;
      const Vec3 along = (1.0 - v) * (p[1] - p[0]) + v * (p[2] - p[3]);
      const Vec3 across = (1.0 - u) * (p[3] - p[0]) + u * (p[2] - p[1]);
      out.centre.push_back(at(u, v));
      out.measure.push_back(along.cross(across).norm() / (n * n));
      const double d = 0.5 / n;
      out.corner.push_back({at(u - d, v - d), at(u + d, v - d), at(u + d, v + d), at(u - d, v + d)});
    }
  return out;
}

}  // namespace

void add_surface_of_mesh(const Case& c, int body, const Mesh& mesh, double spacing, std::vector<SurfacePoint>& out) {
  constexpr double most_on_a_face = 1e6, most_in_all = 3e7;
  std::map<int, std::vector<std::string>> groups;
  for (const auto& [name, nodes] : mesh.node_groups)
    for (int node : nodes) groups[node].push_back(name);
  for (const CellFace& f : boundary_faces(mesh)) {
    const FaceCorners& face = faces_of(mesh.kinds[f.cell])[f.local];
    std::array<Vec3, 4> p;
    std::array<int, 4> node{};
    double longest = 0.0;
    for (int k = 0; k < face.n; ++k) {
      node[k] = mesh.cell(f.cell)[face.corner[k]];
      p[k] = mesh.nodes[node[k]];
    }
    for (int k = 0; k < face.n; ++k) longest = std::max(longest, (p[(k + 1) % face.n] - p[k]).norm());
    const double along = std::max(2.0, std::ceil(longest / spacing - 1e-9)), count = face.n == 2 ? along : along * along;
    if (count > most_on_a_face || count + static_cast<double>(out.size()) > most_in_all)
      throw InputError(fmt::format("body \"{}\": an edge of {:.3g} m would be cut into {:.3g} pieces, as elements are only {:.3g} m large in the mean: they are too flat, or too unlike",
                                   c.bodies[body].name, longest, along, spacing * surface_points_per_cell(c)));
    const int n = static_cast<int>(along);
    const FacePieces pieces = face.n == 2   ? divide_edge(p[0], p[1], n)
                              : face.n == 3 ? divide_triangle(p, n)
                                            : divide_quad(p, n);
    const Vec3 normal = face.n == 2   ? Vec3(p[1].y() - p[0].y(), p[0].x() - p[1].x(), 0.0)
                        : face.n == 3 ? Vec3((p[1] - p[0]).cross(p[2] - p[0]))
                                      : Vec3((p[2] - p[0]).cross(p[3] - p[1]));
    std::vector<std::string> common = groups.count(node[0]) ? groups.at(node[0]) : std::vector<std::string>{};
    std::erase_if(common, [&](const std::string& name) {
      for (int k = 1; k < face.n; ++k) {
        const auto found = groups.find(node[k]);
        if (found == groups.end() || std::find(found->second.begin(), found->second.end(), name) == found->second.end())
          return true;
      }
      return false;
    });
    for (std::size_t k = 0; k < pieces.centre.size(); ++k) {
      out.push_back(surface_point(c, body, pieces.centre[k], normal.normalized(), pieces.measure[k]));
      out.back().groups = common;
      if (face.n == 2) continue;
      out.back().n_corners = face.n;
      out.back().corner = pieces.corner[k];
    }
  }
}

void add_surface_of_shape(const Case& c, int body, const Region& region, double spacing,
                          std::vector<SurfacePoint>& out) {
  for (const BoundaryPiece& piece : region.boundary(spacing)) {
    out.push_back(surface_point(c, body, piece.centre, piece.normal, piece.measure));
    if (region.dimension() == 2) continue;
    out.back().n_corners = 3;
    std::copy(piece.corner.begin(), piece.corner.end(), out.back().corner.begin());
  }
}

std::vector<Vec3> ways_to_surface(const std::vector<Vec3>& places, std::span<const SurfacePoint> surface, double reach) {
  using Bucket = std::array<long, 3>;
  const auto bucket_of = [&](const Vec3& x) {
    return Bucket{std::lround(x.x() / reach), std::lround(x.y() / reach), std::lround(x.z() / reach)};
  };
  std::map<Bucket, std::vector<const SurfacePoint*>> buckets;
  for (const SurfacePoint& s : surface) buckets[bucket_of(s.X)].push_back(&s);
  std::vector<Vec3> ways;
  for (const Vec3& x : places) {
    const Bucket at = bucket_of(x);
    const SurfacePoint* nearest = nullptr;
    for (int k = 0; k < 27; ++k) {
      const auto found = buckets.find({at[0] + k % 3 - 1, at[1] + k / 3 % 3 - 1, at[2] + k / 9 - 1});
      if (found == buckets.end()) continue;
      for (const SurfacePoint* s : found->second)
        if (!nearest || (s->X - x).squaredNorm() < (nearest->X - x).squaredNorm()) nearest = s;
    }
    const double distance = nearest ? nearest->normal.dot(nearest->X - x) : 0.0;
    ways.push_back(distance > 0.0 && distance <= reach ? Vec3(distance * nearest->normal) : Vec3::Zero());
  }
  return ways;
}

}  // namespace berm
