#include "mesh/grid.hpp"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "mesh/cell_map.hpp"

namespace berm {

namespace {

constexpr double boundary_tolerance = 1e-12;  ///< of the grid's size: how far outside still counts as inside

/// Does the diagonal of structured cell (i, j) run from lower left to upper right?
bool diagonal_right(GridKind kind, int i, int j) {
  return kind == GridKind::triangles_right || (kind == GridKind::union_jack && (i + j) % 2 == 0);
}

Mat3 rotation(double angle) {
  Mat3 r = Mat3::Identity();
  r.topLeftCorner<2, 2>() << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return r;
}

/// Which of kuhn_tetrahedra holds the place (u, v, w) of the unit cube.
int kuhn_number(double u, double v, double w) {
  if (u >= v && u >= w) return v >= w ? 0 : 1;
  if (v >= w) return u >= w ? 2 : 3;
  return u >= v ? 4 : 5;
}

class StructuredLocator : public CellLocator {
public:
  explicit StructuredLocator(const StructuredGrid& spec) : spec_(spec), back_(rotation(-spec.angle)) {
    const int n[3] = {spec.nx, spec.ny, spec.nz};
    for (int d = 0; d < 3; ++d) tolerance_ = std::max(tolerance_, boundary_tolerance * n[d] * spec.cell_size[d]);
  }

  int locate(const Vec3& x, int) const override {
    const Vec3 y = (spec_.angle == 0.0 ? x : Vec3(back_ * x)) - spec_.origin;
    int i, j, k = 0;
    double u, v, w = 0.0;
    if (!axis(y.x(), spec_.cell_size.x(), spec_.nx, i, u) || !axis(y.y(), spec_.cell_size.y(), spec_.ny, j, v))
      return -1;
    if (spec_.nz > 0 && !axis(y.z(), spec_.cell_size.z(), spec_.nz, k, w)) return -1;
    const int cell = (k * spec_.ny + j) * spec_.nx + i;
    switch (spec_.kind) {
      case GridKind::quads:
      case GridKind::hexahedra:
        return cell;
      case GridKind::tetrahedra:
        return 6 * cell + kuhn_number(u, v, w);
      default:
        return 2 * cell + ((diagonal_right(spec_.kind, i, j) ? v > u : u + v > 1.0) ? 1 : 0);
    }
  }

private:
  /// Cell index and position in the cell (0..1) along one axis; false if outside.
  bool axis(double y, double h, int n, int& index, double& local) const {
    if (!(y >= -tolerance_ && y <= n * h + tolerance_)) return false;
    const double t = y / h;
    index = std::clamp(static_cast<int>(std::floor(t)), 0, n - 1);
    local = t - index;
    return true;
  }

  StructuredGrid spec_;
  Mat3 back_;
  double tolerance_ = 0.0;
};

/// Uniform bins; every bin lists the cells whose bounding box touches it, in increasing order.
class BinLocator : public CellLocator {
public:
  explicit BinLocator(const Mesh& mesh) : dimension_(mesh.dimension()) {
    for (int c = 0; c < mesh.n_cells(); ++c) {
      kinds_.push_back(linear_kind(mesh.kinds[c]));
      corners_.push_back(corners(mesh, c));
    }
    min_ = max_ = corners_.at(0).x[0];
    for (const Corners& p : corners_)
      for (int i = 0; i < p.n; ++i) {
        min_ = min_.cwiseMin(p.x[i]);
        max_ = max_.cwiseMax(p.x[i]);
      }
    const Vec3 extent = max_ - min_;
    tolerance_ = boundary_tolerance * extent.maxCoeff();
    const double side = std::pow(extent.head(dimension_).prod() / n_cells(), 1.0 / dimension_);
    for (int d = 0; d < 3; ++d) {
      bins_[d] = d < dimension_ ? std::clamp(static_cast<int>(std::ceil(extent[d] / side)), 1, 20000) : 1;
      width_[d] = d < dimension_ ? extent[d] / bins_[d] : 1.0;
    }
    fill();
  }

  int locate(const Vec3& x, int hint) const override {
    // A point on an inner line must not depend on the hint: the hint counts only well inside of the cell.
    if (hint >= 0 && hint < n_cells() && inside(hint, x, tolerance_)) return hint;
    for (int d = 0; d < dimension_; ++d)
      if (!(x[d] >= min_[d] - tolerance_ && x[d] <= max_[d] + tolerance_)) return -1;
    return first_with(x, -tolerance_, -1);
  }

  /// A cell but that one in which x lies, not on an edge of it; -1: none.
  int other_cell(const Vec3& x, int but) const { return first_with(x, tolerance_, but); }

private:
  int first_with(const Vec3& x, double margin, int but) const {
    const int bin = (index(2, x.z()) * bins_[1] + index(1, x.y())) * bins_[0] + index(0, x.x());
    for (int k = start_[bin]; k < start_[bin + 1]; ++k)
      if (candidates_[k] != but && inside(candidates_[k], x, margin)) return candidates_[k];
    return -1;
  }

  int n_cells() const { return static_cast<int>(corners_.size()); }

  int index(int d, double x) const {
    return std::clamp(static_cast<int>(std::floor((x - min_[d]) / width_[d])), 0, bins_[d] - 1);
  }

  template <class Visit>
  void for_bins_of(int c, Visit visit) const {
    const Corners& p = corners_[c];
    Vec3 lo = p.x[0], hi = lo;
    for (int k = 1; k < p.n; ++k) {
      lo = lo.cwiseMin(p.x[k]);
      hi = hi.cwiseMax(p.x[k]);
    }
    const double t = tolerance_;
    for (int k = index(2, lo.z() - t); k <= index(2, hi.z() + t); ++k)
      for (int j = index(1, lo.y() - t); j <= index(1, hi.y() + t); ++j)
        for (int i = index(0, lo.x() - t); i <= index(0, hi.x() + t); ++i) visit((k * bins_[1] + j) * bins_[0] + i);
  }

  void fill() {
    start_.assign(static_cast<std::size_t>(bins_[0]) * bins_[1] * bins_[2] + 1, 0);
    for (int c = 0; c < n_cells(); ++c) for_bins_of(c, [&](int b) { ++start_[b + 1]; });
    for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
    candidates_.resize(start_.back());
    std::vector<int> next(start_.begin(), start_.end() - 1);
    for (int c = 0; c < n_cells(); ++c) for_bins_of(c, [&](int b) { candidates_[next[b]++] = c; });
  }

  /// Is x at least `margin` inside of every side of the convex cell?
  bool inside(int c, const Vec3& x, double margin) const {
    const Corners& p = corners_[c];
    if (dimension_ == 3) {
      Vec3 xi;
      const double size = (p.x[1] - p.x[0]).norm();
      return inverse_map(kinds_[c], p, x, xi) && local_depth(kinds_[c], xi) >= margin / size;
    }
    for (int k = 0; k < p.n; ++k) {
      const Vec3 side = p.x[(k + 1) % p.n] - p.x[k];
      if (side.cross(x - p.x[k]).z() < margin * side.norm()) return false;
    }
    return true;
  }

  int dimension_;
  std::vector<CellKind> kinds_;
  std::vector<Corners> corners_;
  std::vector<int> start_, candidates_;
  Vec3 min_, max_, width_;
  int bins_[3];
  double tolerance_;
};

void check(const StructuredGrid& spec) {
  const bool solid = dimension_of(spec.kind) == 3;
  const int n[3] = {spec.nx, spec.ny, solid ? spec.nz : 1};
  if (std::min({n[0], n[1], n[2]}) < 1)
    throw InputError(fmt::format("grid: {} x {}{} cells (at least one a direction is needed)", spec.nx, spec.ny,
                                 solid ? fmt::format(" x {}", spec.nz) : ""));
  for (int d = 0; d < dimension_of(spec.kind); ++d)
    if (!(spec.cell_size[d] > 0.0))
      throw InputError(fmt::format("grid: a cell size of {:g} m (it must be positive)", spec.cell_size[d]));
  const int share = spec.kind == GridKind::tetrahedra ? 6 : 2;
  if (share * (n[0] + 1.0) * (n[1] + 1.0) * (solid ? n[2] + 1.0 : 1.0) > (solid ? 2.5e8 : 5e8))
    throw InputError(fmt::format("grid: {} x {} x {} cells are too many (take larger cells)", n[0], n[1], n[2]));
}

/// Every corner of every cell must turn the right way by more than a rounding error.
void check_convex(const Mesh& mesh) {
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const CellKind kind = mesh.kinds[c];
    const Corners p = corners(mesh, c);
    if (nodes_of(kind) != p.n)
      throw InputError("grid: quadratic cells are not supported (save a mesh of order 1)");
    if (dimension_of(kind) != mesh.dimension()) throw InputError("grid: cells of the plane and of space are mixed");
    LocalShape s;
    for (int i = 0; i < p.n; ++i) {
      Vec3 at(corner_sign[i][0], corner_sign[i][1], corner_sign[i][2]);
      if (is_simplex(kind)) at.setZero();
      local_shape(kind, at, s);
      const Mat3 J = cell_jacobian(p, mesh.dimension(), s);
      if (!(J.determinant() > 1e-10 * J.col(0).norm() * J.col(1).norm() * J.col(2).norm()))
        throw InputError(fmt::format("grid: cell {} is inverted, flat or not convex at ({:g}, {:g}, {:g})", c + 1,
                                     p.x[i].x(), p.x[i].y(), p.x[i].z()));
    }
  }
}

void add_plane_cells(const StructuredGrid& spec, Mesh& mesh) {
  const int nx = spec.nx, ny = spec.ny;
  for (int j = 0; j < ny; ++j)
    for (int i = 0; i < nx; ++i) {
      const int n00 = j * (nx + 1) + i, n10 = n00 + 1, n01 = n00 + nx + 1, n11 = n01 + 1;
      const bool right = diagonal_right(spec.kind, i, j);
      const int quad[4] = {n00, n10, n11, n01}, lower[3] = {n00, n10, right ? n11 : n01},
                upper[3] = {right ? n00 : n10, n11, n01};
      if (spec.kind == GridKind::quads) {
        mesh.add_cell(CellKind::quad4, quad);
      } else {
        mesh.add_cell(CellKind::tri3, lower);
        mesh.add_cell(CellKind::tri3, upper);
      }
    }
}

void add_solid_cells(const StructuredGrid& spec, Mesh& mesh) {
  const int nx = spec.nx, ny = spec.ny, row = nx + 1, layer = (nx + 1) * (ny + 1);
  const bool hexes = spec.kind == GridKind::hexahedra;
  const std::size_t n = static_cast<std::size_t>(nx) * ny * spec.nz * (hexes ? 1 : 6);
  mesh.kinds.reserve(n);
  mesh.offsets.reserve(n + 1);
  mesh.connectivity.reserve(n * (hexes ? 8 : 4));
  for (int k = 0; k < spec.nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const int o = k * layer + j * row + i;
        const int cube[8] = {o,         o + 1,         o + row + 1,         o + row,
                             o + layer, o + layer + 1, o + layer + row + 1, o + layer + row};
        if (hexes) {
          mesh.add_cell(CellKind::hex8, cube);
          continue;
        }
        for (const auto& corner : kuhn_tetrahedra) {
          const int tet[4] = {cube[corner[0]], cube[corner[1]], cube[corner[2]], cube[corner[3]]};
          mesh.add_cell(CellKind::tet4, tet);
        }
      }
}

/// cell_neighbours of quads and hexahedra, by arithmetic.
std::vector<int> box_neighbours(const StructuredGrid& spec) {
  const int nx = spec.nx, ny = spec.ny, nz = std::max(1, spec.nz), layer = nx * ny;
  std::vector<int> out(static_cast<std::size_t>(max_faces) * layer * nz, -1);
  for (int k = 0; k < nz; ++k)
    for (int j = 0; j < ny; ++j)
      for (int i = 0; i < nx; ++i) {
        const int c = k * layer + j * nx + i;
        const int west = i > 0 ? c - 1 : -1, east = i + 1 < nx ? c + 1 : -1, south = j > 0 ? c - nx : -1,
                  north = j + 1 < ny ? c + nx : -1, below = k > 0 ? c - layer : -1,
                  above = k + 1 < nz ? c + layer : -1;
        const int solid[6] = {below, above, south, east, north, west}, plane[4] = {south, east, north, west};
        int* list = &out[static_cast<std::size_t>(max_faces) * c];
        spec.nz > 0 ? std::copy_n(solid, 6, list) : std::copy_n(plane, 4, list);
      }
  return out;
}

}  // namespace

Grid make_structured_grid(const StructuredGrid& spec) {
  check(spec);
  Grid grid;
  Mesh& mesh = grid.mesh;
  const int layers = dimension_of(spec.kind) == 3 ? spec.nz + 1 : 1;
  const Mat3 r = rotation(spec.angle);
  mesh.nodes.reserve(static_cast<std::size_t>(spec.nx + 1) * (spec.ny + 1) * layers);
  for (int k = 0; k < layers; ++k)
    for (int j = 0; j <= spec.ny; ++j)
      for (int i = 0; i <= spec.nx; ++i) {
        const Vec3 x = spec.origin + Vec3(i, j, k).cwiseProduct(spec.cell_size);
        mesh.nodes.push_back(spec.angle == 0.0 ? x : Vec3(r * x));
      }
  if (dimension_of(spec.kind) == 3)
    add_solid_cells(spec, mesh);
  else
    add_plane_cells(spec, mesh);
  const bool boxes = spec.kind == GridKind::quads || spec.kind == GridKind::hexahedra;
  grid.neighbours = boxes ? box_neighbours(spec) : cell_neighbours(mesh);
  if (boxes && spec.angle == 0.0) grid.boxes = std::make_unique<StructuredGrid>(spec);
  grid.locator = std::make_unique<StructuredLocator>(spec);
  grid.structure = std::make_unique<StructuredGrid>(spec);
  return grid;
}

Grid make_unstructured_grid(Mesh mesh) {
  if (mesh.kinds.empty()) throw InputError("grid: the mesh has no cells");
  check_convex(mesh);
  Grid grid;
  grid.neighbours = cell_neighbours(mesh);  // throws if a face has more than two cells
  grid.locator = std::make_unique<BinLocator>(mesh);
  grid.mesh = std::move(mesh);
  return grid;
}

std::optional<std::pair<int, int>> overlapping_cells(const Mesh& mesh) {
  if (mesh.n_cells() < 2) return std::nullopt;
  constexpr double towards_corner = 0.8;
  const BinLocator locator(mesh);
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const Vec3 centre = cell_centre(mesh, c);
    const Corners p = corners(mesh, c);
    for (int k = -1; k < p.n; ++k) {
      const Vec3 place = k < 0 ? centre : Vec3(centre + towards_corner * (p.x[k] - centre));
      if (const int found = locator.other_cell(place, c); found >= 0) return std::pair(found, c);
    }
  }
  return std::nullopt;
}

}  // namespace berm
