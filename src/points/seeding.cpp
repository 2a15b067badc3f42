#include "points/seeding.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "mesh/cell_map.hpp"
#include "shape/quadrature.hpp"

namespace berm {
namespace {

struct Part {
  CellKind kind;
  Corners corners;
};

Vec3 place(const Part& cell, const Vec3& xi, double* jacobian = nullptr) {
  LocalShape s;
  local_shape(cell.kind, xi, s);
  Vec3 x = Vec3::Zero();
  for (int i = 0; i < cell.corners.n; ++i) x += s.N[i] * cell.corners.x[i];
  if (jacobian) *jacobian = cell_jacobian(cell.corners, dimension_of(cell.kind), s).determinant();
  return x;
}

double measure_of(const Part& part) {
  Mesh mesh;
  std::array<int, 8> list{};
  for (int i = 0; i < part.corners.n; ++i) {
    mesh.nodes.push_back(part.corners.x[i]);
    list[i] = i;
  }
  mesh.add_cell(part.kind, list.data());
  return cell_measure(mesh, 0);
}

/// A quad or hexahedron cut into n parts a direction.
std::vector<Part> box_parts(const Part& cell, int n) {
  std::vector<Part> out;
  const int layers = dimension_of(cell.kind) == 3 ? n : 1;
  for (int k = 0; k < layers; ++k)
    for (int j = 0; j < n; ++j)
      for (int i = 0; i < n; ++i) {
        Part part{cell.kind, {}};
        part.corners.n = cell.corners.n;
        for (int c = 0; c < cell.corners.n; ++c) {
          const Vec3 step = 0.5 * (Vec3(corner_sign[c][0], corner_sign[c][1], corner_sign[c][2]) + Vec3::Ones());
          part.corners.x[c] = place(cell, Vec3::Constant(-1.0) + 2.0 / n * (Vec3(i, j, k) + step));
        }
        out.push_back(part);
      }
  return out;
}

/// A triangle cut into n^2 similar ones.
std::vector<Part> triangle_parts(const Part& cell, int n) {
  const auto& p = cell.corners.x;
  auto at = [&](int i, int j) -> Vec3 {
    return p[0] + (p[1] - p[0]) * (double(i) / n) + (p[2] - p[0]) * (double(j) / n);
  };
  std::vector<Part> out;
  for (int j = 0; j < n; ++j)
    for (int i = 0; i + j < n; ++i) {
      out.push_back({cell.kind, {3, {at(i, j), at(i + 1, j), at(i, j + 1)}}});
      if (i + j < n - 1) out.push_back({cell.kind, {3, {at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)}}});
    }
  return out;
}

/// A tetrahedron cut into 8 by its mid-edges, as often as gives at least n parts along an edge.
std::vector<Part> tetrahedron_parts(const Part& cell, int n) {
  std::vector<Part> out = {cell};
  for (int divisions = 1; divisions < n; divisions *= 2) {
    std::vector<Part> finer;
    for (const Part& t : out) {
      const auto& p = t.corners.x;
      const auto mid = [&](int a, int b) -> Vec3 { return 0.5 * (p[a] + p[b]); };
      const Vec3 m01 = mid(0, 1), m02 = mid(0, 2), m03 = mid(0, 3), m12 = mid(1, 2), m13 = mid(1, 3), m23 = mid(2, 3);
      const Vec3 parts[8][4] = {{p[0], m01, m02, m03}, {m01, p[1], m12, m13}, {m02, m12, p[2], m23},
                                {m03, m13, m23, p[3]}, {m01, m13, m02, m03},  {m01, m12, m02, m13},
                                {m03, m13, m02, m23},  {m13, m12, m02, m23}};
      for (const auto& q : parts) finer.push_back({t.kind, {4, {q[0], q[1], q[2], q[3]}}});
    }
    out = std::move(finer);
  }
  return out;
}

std::vector<Part> parts_of(const Part& cell, int n) {
  if (!is_simplex(cell.kind)) return box_parts(cell, n);
  return dimension_of(cell.kind) == 3 ? tetrahedron_parts(cell, n) : triangle_parts(cell, n);
}

void seed_gauss(const Part& cell, const std::vector<QuadraturePoint>& rule, SeededPoints& out) {
  for (const QuadraturePoint& q : rule) {
    double jacobian = 0.0;
    const Vec3 x = place(cell, q.xi, &jacobian);
    out.add(x, q.weight * jacobian);
  }
}

/// The rule of a cell for n points a direction; empty if there is none.
std::vector<QuadraturePoint> rule_of(CellKind kind, int n) {
  constexpr int triangle[] = {1, 3, 6, 12};
  if (n > 4) return {};
  switch (kind) {
    case CellKind::tri3:
      return gauss_triangle(triangle[n - 1]);
    case CellKind::quad4:
      return gauss_square(n);
    case CellKind::tet4:
      return n <= 2 ? gauss_tetrahedron(n == 1 ? 1 : 4) : std::vector<QuadraturePoint>{};
    default:
      return gauss_cube(n);
  }
}

void seed_whole_cell(const Part& cell, const PointSeeding& seeding, SeededPoints& out) {
  if (seeding.placement != PointSeeding::Placement::uniform) {
    const auto rule = rule_of(cell.kind, seeding.per_direction);
    if (!rule.empty()) return seed_gauss(cell, rule, out);
  }
  for (const Part& part : parts_of(cell, seeding.per_direction)) {
    Vec3 centre = Vec3::Zero();
    for (int i = 0; i < part.corners.n; ++i) centre += part.corners.x[i] / part.corners.n;
    out.add(centre, measure_of(part));
  }
}

/// Edges of a box about the centroid of the piece of body in a part, no face of which leaves the part: those of the piece
/// where one face of the body along the grid cuts it. The part has a corner and the columns of `edges` from there.
Vec3 box_of_piece(const Vec3& corner, const Mat3& edges, int dimension, const Vec3& centroid) {
  Vec3 box = Vec3::Zero();
  for (int k = 0; k < dimension; ++k) {
    const double at = (centroid - corner).dot(edges.col(k)) / edges.col(k).squaredNorm();
    box[k] = 2.0 * std::max(std::min(at, 1.0 - at), 1e-6) * edges.col(k).norm();
  }
  return box;
}

/// Nothing in triangles and tetrahedra.
Vec3 box_of_piece(const Part& part, const Vec3& centroid) {
  if (is_simplex(part.kind)) return Vec3::Zero();
  constexpr int neighbour[] = {1, 3, 4};
  const Vec3& corner = part.corners.x[0];
  Mat3 edges = Mat3::Zero();
  for (int k = 0; k < dimension_of(part.kind); ++k) edges.col(k) = part.corners.x[neighbour[k]] - corner;
  return box_of_piece(corner, edges, dimension_of(part.kind), centroid);
}

Part part_of(const Mesh& mesh, int cell) { return {linear_kind(mesh.kinds[cell]), corners(mesh, cell)}; }

constexpr double sliver = 1e-12;  ///< of a part: less is rounding, not material

/// One cell after the other.
void seed_cells(const Region& region, const Grid& grid, const PointSeeding& seeding, SeededPoints& out) {
  const Vec3 low = region.min(), high = region.max();
  for (int c = 0; c < grid.mesh.n_cells(); ++c) {
    const Part cell = part_of(grid.mesh, c);
    Vec3 bottom = cell.corners.x[0], top = bottom;
    for (int i = 1; i < cell.corners.n; ++i) {
      bottom = bottom.cwiseMin(cell.corners.x[i]);
      top = top.cwiseMax(cell.corners.x[i]);
    }
    if ((bottom.array() > high.array()).any() || (top.array() < low.array()).any()) continue;
    const double whole = measure_of(cell), inside = region.clip(cell.kind, cell.corners).measure;
    if (inside <= sliver * whole) continue;
    if (inside >= (1.0 - sliver) * whole) {
      seed_whole_cell(cell, seeding, out);
      continue;
    }
    for (const Part& part : parts_of(cell, seeding.per_direction)) {
      const Piece piece = region.clip(part.kind, part.corners);
      if (piece.measure > sliver * measure_of(part)) out.add(piece.centroid, piece.measure, box_of_piece(part, piece.centroid));
    }
  }
}

/// Grids of boxes: the region is cut into all of them at once.
void seed_boxes(const SolidRegion& region, const Grid& grid, const PointSeeding& seeding, SeededPoints& out) {
  const StructuredGrid& spec = *grid.boxes;
  const int n = seeding.per_direction;
  const auto index = [&](int i, int j, int k) { return (k * spec.ny + j) * spec.nx + i; };
  enum Kind : char { empty, cut, whole };
  std::vector<Kind> kind(grid.mesh.n_cells(), empty);
  BoxGrid boxes{spec.origin, spec.cell_size, {spec.nx, spec.ny, spec.nz}, {1, 1, 1}};
  region.for_each_box(
      boxes, [&](int i, int j, int k, const SolidPiece&, bool full) { kind[index(i, j, k)] = full ? whole : cut; });
  // Parts of cut cells, by cell: all cells in ascending order, as on any other grid.
  struct Cut {
    int cell;
    SolidPiece piece;
    Vec3 box;
  };
  const Vec3 part = spec.cell_size / n;
  std::vector<Cut> pieces;
  boxes.divisions = {n, n, n};
  region.for_each_box(boxes, [&](int i, int j, int k, const SolidPiece& piece, bool) {
    const int cell = index(i / n, j / n, k / n);
    if (kind[cell] != cut) return;
    const Vec3 corner = spec.origin + part.cwiseProduct(Vec3(i, j, k));
    pieces.push_back({cell, piece, box_of_piece(corner, part.asDiagonal(), 3, piece.centroid)});
  });
  std::stable_sort(pieces.begin(), pieces.end(), [](const Cut& a, const Cut& b) { return a.cell < b.cell; });
  auto next = pieces.begin();
  for (int c = 0; c < grid.mesh.n_cells(); ++c) {
    if (kind[c] == whole) seed_whole_cell(part_of(grid.mesh, c), seeding, out);
    for (; next != pieces.end() && next->cell == c; ++next)
      out.add(next->piece.centroid, next->piece.volume, next->box);
  }
}

/// Takes the mean products of two local coordinates out of the points of a full hexahedron with parallel edges, whose
/// own are zero: places are scaled and sheared about their mean as little as that takes. Nothing if the points lie
/// almost in a plane.
void take_out_products(const Part& cell, const std::vector<int>& list, SeededPoints& points) {
  LocalShape s;
  local_shape(cell.kind, Vec3::Zero(), s);
  const Mat3 J = cell_jacobian(cell.corners, 3, s), inverse = J.inverse();
  const Vec3 centre = place(cell, Vec3::Zero());
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner(corner_sign[i][0], corner_sign[i][1], corner_sign[i][2]);
    if ((inverse * (cell.corners.x[i] - centre) - corner).norm() > 1e-9) return;
  }
  Mat3 products = Mat3::Zero();
  double sum = 0.0;
  for (int p : list) {
    const Vec3 xi = inverse * (points.x[p] + points.shift[p] - centre);
    products += points.measure[p] * xi * xi.transpose();
    sum += points.measure[p];
  }
  // With spreads S and correlations R the map S R^(-1/2) S^-1 leaves the spreads and takes out the correlations.
  const Vec3 spread = (products.diagonal() / sum).cwiseSqrt();
  if (!(spread.minCoeff() > 0.05)) return;
  const Mat3 scale = spread.asDiagonal(), back = spread.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Mat3> R(back * products * back / sum);
  if (!(R.eigenvalues()[0] > 0.05)) return;
  const Mat3 map = J * scale * R.operatorInverseSqrt() * back * inverse;
  for (int p : list) points.shift[p] = centre + map * (points.x[p] + points.shift[p] - centre) - points.x[p];
}

}  // namespace

SeededPoints seed_from_grid(const Region& region, const Grid& grid, const PointSeeding& seeding,
                            const std::string& body) {
  SeededPoints out;
  if (region.solid() && grid.boxes)
    seed_boxes(*region.solid(), grid, seeding, out);
  else
    seed_cells(region, grid, seeding, out);
  double sum = 0.0;
  for (double m : out.measure) sum += m;
  if (std::abs(sum - region.measure()) > 1e-6 * region.measure()) {
    const bool solid = region.dimension() == 3;
    Vec3 low = grid.mesh.nodes[0], high = low;
    for (const Vec3& x : grid.mesh.nodes) low = low.cwiseMin(x), high = high.cwiseMax(x);
    const double extent = (high - low).norm(), rounding = 1e-9 * extent, size = (region.max() - region.min()).norm();
    if (size < 1e-6 * extent)
      throw InputError(fmt::format("body \"{}\" is {:.3g} m large, and the background grid {:.3g} m: it is lost between the nodes. Are its lengths right?", body, size, extent));
    if (solid && grid.boxes && ((region.min() - low).array() >= -rounding).all() && ((high - region.max()).array() >= -rounding).all())
      throw InputError(fmt::format("body \"{}\" has a volume of {:.6g} m3, of which the cells find {:.6g} m3: parts of its surface overlap, and what lies in several "
                                   "of them counts once. Unite the parts",
                                   body, region.measure(), sum));
    throw InputError(
        fmt::format("body \"{}\" has {} of {:.6g} {}, but only {:.6g} {} lie inside the background grid: make the grid "
                    "larger{}",
                    body, solid ? "a volume" : "an area", region.measure(), solid ? "m3" : "m2", sum,
                    solid ? "m3" : "m2", sum < 0.01 * region.measure() ? "; or are the lengths of the body in mm? Here they are in m" : ""));
  }
  return out;
}

SeededPoints seed_from_mesh(const Mesh& mesh, int per_element) {
  SeededPoints out;
  const int square = static_cast<int>(std::lround(std::sqrt(per_element)));
  const int cube = static_cast<int>(std::lround(std::cbrt(per_element)));
  const bool mixed = std::any_of(mesh.kinds.begin(), mesh.kinds.end(), [&](CellKind kind) { return kind != mesh.kinds.front(); });
  if (mixed && per_element != 1)
    throw InputError(fmt::format("the mesh has elements of several kinds, which all take points.per_element = 1 and not {}: take 1, or mesh the body with one kind", per_element));
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const Part cell = part_of(mesh, c);
    switch (cell.kind) {
      case CellKind::tri3:
        seed_gauss(cell, gauss_triangle(per_element), out);
        break;
      case CellKind::tet4:
        seed_gauss(cell, gauss_tetrahedron(per_element), out);
        break;
      case CellKind::quad4:
        if (square * square != per_element)
          throw InputError(fmt::format("a quad takes 1, 4, 9 or 16 points, not {}", per_element));
        seed_gauss(cell, gauss_square(square), out);
        break;
      default:
        if (cube * cube * cube != per_element || cube > 3)
          throw InputError(fmt::format("a hexahedron takes 1, 8 or 27 points, not {}", per_element));
        seed_gauss(cell, gauss_cube(cube), out);
    }
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
  points.shift.assign(points.x.size(), Vec3::Zero());
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const Part cell = part_of(mesh, c);
    const Piece piece = region.clip(cell.kind, cell.corners);
    // A point on the very edge of a cell that the body does not enter keeps its own measure.
    if (piece.measure <= 1e-9 * measure_of(cell)) continue;
    if (in_cell[c].empty()) {
      points.add(piece.centroid, piece.measure);
      points.shift.push_back(Vec3::Zero());
      continue;
    }
    double sum = 0.0;
    Vec3 mean = Vec3::Zero();
    for (int p : in_cell[c]) {
      sum += points.measure[p];
      mean += points.measure[p] * points.x[p];
    }
    mean /= sum;
    for (int p : in_cell[c]) {
      points.measure[p] *= piece.measure / sum;
      points.shift[p] = piece.centroid - mean;
    }
    if (cell.kind == CellKind::hex8 && piece.measure >= (1.0 - sliver) * measure_of(cell))
      take_out_products(cell, in_cell[c], points);
  }
}

}  // namespace berm
