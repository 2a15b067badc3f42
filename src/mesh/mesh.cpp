#include "mesh/mesh.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

#include "base/error.hpp"

namespace berm {

namespace {

constexpr FaceCorners triangle[] = {{2, {0, 1}}, {2, {1, 2}}, {2, {2, 0}}};
constexpr FaceCorners quad[] = {{2, {0, 1}}, {2, {1, 2}}, {2, {2, 3}}, {2, {3, 0}}};
constexpr FaceCorners tetrahedron[] = {{3, {0, 2, 1}}, {3, {0, 1, 3}}, {3, {1, 2, 3}}, {3, {0, 3, 2}}};
constexpr FaceCorners hexahedron[] = {{4, {0, 3, 2, 1}}, {4, {4, 5, 6, 7}}, {4, {0, 1, 5, 4}},
                                      {4, {1, 2, 6, 5}}, {4, {2, 3, 7, 6}}, {4, {3, 0, 4, 7}}};

constexpr std::array<int, 2> triangle_edges[] = {{0, 1}, {1, 2}, {2, 0}};
constexpr std::array<int, 2> quad_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}};
constexpr std::array<int, 2> tetrahedron_edges[] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};
constexpr std::array<int, 2> hexahedron_edges[] = {{0, 1}, {1, 2}, {2, 3}, {3, 0}, {4, 5}, {5, 6},
                                                   {6, 7}, {7, 4}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

struct Side {
  std::array<int, 4> key;  ///< corner nodes, ascending
  int cell, local;
};

std::vector<Side> sorted_sides(const Mesh& mesh) {
  std::vector<Side> sides;
  sides.reserve(static_cast<std::size_t>(mesh.dimension() == 3 ? 6 : 4) * mesh.kinds.size());
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const auto faces = faces_of(mesh.kinds[c]);
    for (std::size_t f = 0; f < faces.size(); ++f) {
      Side side{{-1, -1, -1, -1}, c, static_cast<int>(f)};
      for (int k = 0; k < faces[f].n; ++k) {
        side.key[k] = mesh.cell(c)[faces[f].corner[k]];
        for (int j = k; j > 0 && side.key[j] < side.key[j - 1]; --j) std::swap(side.key[j], side.key[j - 1]);
      }
      sides.push_back(side);
    }
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.key != b.key ? a.key < b.key : a.cell != b.cell ? a.cell < b.cell : a.local < b.local;
  });
  return sides;
}

/// Calls visit(first, count) for every group of sides with the same corners.
template <class Visit>
void for_each_face(const Mesh& mesh, Visit visit) {
  const std::vector<Side> sides = sorted_sides(mesh);
  for (std::size_t i = 0; i < sides.size();) {
    std::size_t j = i + 1;
    while (j < sides.size() && sides[j].key == sides[i].key) ++j;
    if (j - i > 2) {
      const Vec3& x = mesh.nodes[sides[i].key[0]];
      throw InputError(fmt::format("mesh: a{} at ({:g}, {:g}, {:g}) is shared by {} cells (at most two can share one)",
                                   mesh.dimension() == 3 ? " face" : "n edge", x.x(), x.y(), x.z(), j - i));
    }
    visit(&sides[i], static_cast<int>(j - i));
    i = j;
  }
}

/// Integral of the Jacobian of a trilinear cell: 2 x 2 x 2 Gauss points are exact.
double hexahedron_volume(const Corners& p) {
  constexpr int sign[8][3] = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1},
                              {-1, -1, 1},  {1, -1, 1},  {1, 1, 1},  {-1, 1, 1}};
  const double g = 1.0 / std::sqrt(3.0);
  double volume = 0.0;
  for (const auto& at : sign) {
    Mat3 jacobian = Mat3::Zero();
    for (int i = 0; i < 8; ++i) {
      const double f[3] = {1.0 + g * at[0] * sign[i][0], 1.0 + g * at[1] * sign[i][1], 1.0 + g * at[2] * sign[i][2]};
      const Vec3 d(sign[i][0] * f[1] * f[2], sign[i][1] * f[0] * f[2], sign[i][2] * f[0] * f[1]);
      jacobian += 0.125 * p.x[i] * d.transpose();
    }
    volume += jacobian.determinant();
  }
  return volume;
}

}  // namespace

std::span<const FaceCorners> faces_of(CellKind kind) {
  if (dimension_of(kind) == 2)
    return is_simplex(kind) ? std::span<const FaceCorners>(triangle) : std::span<const FaceCorners>(quad);
  return is_simplex(kind) ? std::span<const FaceCorners>(tetrahedron) : std::span<const FaceCorners>(hexahedron);
}

std::span<const std::array<int, 2>> edges_of(CellKind kind) {
  using Edges = std::span<const std::array<int, 2>>;
  if (dimension_of(kind) == 2) return is_simplex(kind) ? Edges(triangle_edges) : Edges(quad_edges);
  return is_simplex(kind) ? Edges(tetrahedron_edges) : Edges(hexahedron_edges);
}

Corners corners(const Mesh& mesh, int c) {
  Corners out;
  out.n = corners_of(mesh.kinds[c]);
  for (int i = 0; i < out.n; ++i) out.x[i] = mesh.nodes[mesh.cell(c)[i]];
  return out;
}

double cell_measure(const Mesh& mesh, int c) {
  const Corners p = corners(mesh, c);
  if (mesh.kinds[c] == CellKind::hex8 || mesh.kinds[c] == CellKind::hex20) return hexahedron_volume(p);
  if (dimension_of(mesh.kinds[c]) == 3) return (p.x[1] - p.x[0]).cross(p.x[2] - p.x[0]).dot(p.x[3] - p.x[0]) / 6.0;
  double twice = 0.0;
  for (int i = 1; i + 1 < p.n; ++i) twice += (p.x[i] - p.x[0]).cross(p.x[i + 1] - p.x[0]).z();
  return 0.5 * twice;
}

double edge_length(CellKind kind, double measure) {
  if (dimension_of(kind) == 3) return std::cbrt(is_simplex(kind) ? 6.0 * measure : measure);
  return std::sqrt(is_simplex(kind) ? 2.0 * measure : measure);
}

Vec3 cell_centre(const Mesh& mesh, int c) {
  const Corners p = corners(mesh, c);
  Vec3 sum = Vec3::Zero();
  for (int i = 0; i < p.n; ++i) sum += p.x[i];
  return sum / p.n;
}

Corners face_corners(const Mesh& mesh, const CellFace& face) {
  const FaceCorners& f = faces_of(mesh.kinds[face.cell])[face.local];
  Corners out;
  out.n = f.n;
  for (int i = 0; i < f.n; ++i) out.x[i] = mesh.nodes[mesh.cell(face.cell)[f.corner[i]]];
  return out;
}

std::vector<CellFace> boundary_faces(const Mesh& mesh) {
  std::vector<CellFace> faces;
  for_each_face(mesh, [&](const Side* side, int count) {
    if (count == 1) faces.push_back({side->cell, side->local});
  });
  std::sort(faces.begin(), faces.end(), [](const CellFace& a, const CellFace& b) {
    return a.cell != b.cell ? a.cell < b.cell : a.local < b.local;
  });
  return faces;
}

std::vector<int> cell_neighbours(const Mesh& mesh) {
  std::vector<int> neighbour(static_cast<std::size_t>(max_faces) * mesh.kinds.size(), -1);
  for_each_face(mesh, [&](const Side* side, int count) {
    if (count != 2) return;
    neighbour[static_cast<std::size_t>(max_faces) * side[0].cell + side[0].local] = side[1].cell;
    neighbour[static_cast<std::size_t>(max_faces) * side[1].cell + side[1].local] = side[0].cell;
  });
  return neighbour;
}

}  // namespace berm
