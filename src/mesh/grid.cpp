#include "mesh/grid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace berm {

namespace {

constexpr double boundary_tolerance = 1e-12;  ///< of the grid's size: how far outside still counts as inside

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Does the diagonal of structured cell (i, j) run from lower left to upper right?
bool diagonal_right(GridKind kind, int i, int j) {
  return kind == GridKind::triangles_right || (kind == GridKind::union_jack && (i + j) % 2 == 0);
}

Mat2 rotation(double angle) {
  Mat2 r;
  r << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  return r;
}

class StructuredLocator : public CellLocator {
public:
  explicit StructuredLocator(const StructuredGrid& spec)
      : spec_(spec),
        back_(rotation(-spec.angle)),
        tolerance_(boundary_tolerance * std::max(spec.nx * spec.cell_size.x(), spec.ny * spec.cell_size.y())) {}

  int locate(const Vec2& x, int) const override {
    const Vec2 y = (spec_.angle == 0.0 ? x : Vec2(back_ * x)) - spec_.origin;
    int i, j;
    double u, v;
    if (!axis(y.x(), spec_.cell_size.x(), spec_.nx, i, u) || !axis(y.y(), spec_.cell_size.y(), spec_.ny, j, v))
      return -1;
    const int cell = j * spec_.nx + i;
    if (spec_.kind == GridKind::quads) return cell;
    const bool upper = diagonal_right(spec_.kind, i, j) ? v > u : u + v > 1.0;
    return 2 * cell + (upper ? 1 : 0);
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
  Mat2 back_;
  double tolerance_;
};

/// Uniform bins; every bin lists the cells whose bounding box touches it, in increasing order.
class BinLocator : public CellLocator {
public:
  explicit BinLocator(const Mesh& mesh) {
    copy_corners(mesh);
    const Vec2 extent = max_ - min_;
    tolerance_ = boundary_tolerance * extent.maxCoeff();
    const double side = std::sqrt(extent.x() * extent.y() / std::max(1, n_cells()));
    for (int d = 0; d < 2; ++d) {
      bins_[d] = std::clamp(static_cast<int>(std::ceil(extent[d] / side)), 1, 20000);
      width_[d] = extent[d] / bins_[d];
    }
    fill();
  }

  int locate(const Vec2& x, int hint) const override {
    // A point on an inner line must not depend on the hint: the hint counts only well inside of the cell.
    if (hint >= 0 && hint < n_cells() && inside(hint, x, tolerance_)) return hint;
    if (!(x.x() >= min_.x() - tolerance_ && x.x() <= max_.x() + tolerance_ && x.y() >= min_.y() - tolerance_ &&
          x.y() <= max_.y() + tolerance_))
      return -1;
    const int bin = index(1, x.y()) * bins_[0] + index(0, x.x());
    for (int k = start_[bin]; k < start_[bin + 1]; ++k)
      if (inside(candidates_[k], x, -tolerance_)) return candidates_[k];
    return -1;
  }

private:
  int n_cells() const { return static_cast<int>(first_.size()) - 1; }

  void copy_corners(const Mesh& mesh) {
    first_.assign(1, 0);
    min_ = max_ = mesh.nodes[mesh.connectivity.at(0)];
    for (int c = 0; c < mesh.n_cells(); ++c) {
      for (int i = 0; i < corners_of(mesh.kinds[c]); ++i) corners_.push_back(mesh.nodes[mesh.cell(c)[i]]);
      first_.push_back(static_cast<int>(corners_.size()));
    }
    for (const Vec2& p : corners_) {
      min_ = min_.cwiseMin(p);
      max_ = max_.cwiseMax(p);
    }
  }

  int index(int d, double x) const {
    return std::clamp(static_cast<int>(std::floor((x - min_[d]) / width_[d])), 0, bins_[d] - 1);
  }

  template <class Visit>
  void for_bins_of(int c, Visit visit) const {
    Vec2 lo = corners_[first_[c]], hi = lo;
    for (int k = first_[c]; k < first_[c + 1]; ++k) {
      lo = lo.cwiseMin(corners_[k]);
      hi = hi.cwiseMax(corners_[k]);
    }
    for (int j = index(1, lo.y() - tolerance_); j <= index(1, hi.y() + tolerance_); ++j)
      for (int i = index(0, lo.x() - tolerance_); i <= index(0, hi.x() + tolerance_); ++i) visit(j * bins_[0] + i);
  }

  void fill() {
    start_.assign(static_cast<std::size_t>(bins_[0]) * bins_[1] + 1, 0);
    for (int c = 0; c < n_cells(); ++c) for_bins_of(c, [&](int b) { ++start_[b + 1]; });
    for (std::size_t b = 1; b < start_.size(); ++b) start_[b] += start_[b - 1];
    candidates_.resize(start_.back());
    std::vector<int> next(start_.begin(), start_.end() - 1);
    for (int c = 0; c < n_cells(); ++c) for_bins_of(c, [&](int b) { candidates_[next[b]++] = c; });
  }

  /// Is x at least `margin` inside of every side of the convex cell?
  bool inside(int c, const Vec2& x, double margin) const {
    const int begin = first_[c], end = first_[c + 1];
    for (int k = begin; k < end; ++k) {
      const Vec2& a = corners_[k];
      const Vec2 side = corners_[k + 1 < end ? k + 1 : begin] - a;
      if (cross(side, x - a) < margin * side.norm()) return false;
    }
    return true;
  }

  std::vector<Vec2> corners_;  ///< of all cells, one after the other
  std::vector<int> first_;     ///< of cell c: corners_[first_[c] .. first_[c+1])
  std::vector<int> start_, candidates_;
  Vec2 min_, max_, width_;
  int bins_[2];
  double tolerance_;
};

void check(const StructuredGrid& spec) {
  if (spec.nx < 1 || spec.ny < 1)
    throw InputError(fmt::format("grid: {} x {} cells (at least one a direction is needed)", spec.nx, spec.ny));
  if (!(spec.cell_size.x() > 0.0 && spec.cell_size.y() > 0.0))
    throw InputError(
        fmt::format("grid: cell size {:g} x {:g} m (it must be positive)", spec.cell_size.x(), spec.cell_size.y()));
  if (2.0 * (spec.nx + 1.0) * (spec.ny + 1.0) > 5e8)
    throw InputError(fmt::format("grid: {} x {} cells are too many (take larger cells)", spec.nx, spec.ny));
}

/// Every corner of every cell must turn left by more than a rounding error.
void check_convex(const Mesh& mesh) {
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const int n = corners_of(mesh.kinds[c]);
    if (nodes_of(mesh.kinds[c]) != n)
      throw InputError("grid: quadratic cells are not supported (save a mesh of order 1)");
    const int* nodes = mesh.cell(c);
    for (int i = 0; i < n; ++i) {
      const Vec2& p = mesh.nodes[nodes[i]];
      const Vec2 ahead = mesh.nodes[nodes[(i + 1) % n]] - p, behind = mesh.nodes[nodes[(i + n - 1) % n]] - p;
      if (!(cross(ahead, behind) > 1e-10 * ahead.norm() * behind.norm()))
        throw InputError(
            fmt::format("grid: cell {} is inverted, flat or not convex at ({:g}, {:g})", c + 1, p.x(), p.y()));
    }
  }
}

}  // namespace

Grid make_structured_grid(const StructuredGrid& spec) {
  check(spec);
  Grid grid;
  Mesh& mesh = grid.mesh;
  const int nx = spec.nx, ny = spec.ny;
  const Mat2 r = rotation(spec.angle);
  mesh.nodes.reserve(static_cast<std::size_t>(nx + 1) * (ny + 1));
  for (int j = 0; j <= ny; ++j)
    for (int i = 0; i <= nx; ++i) {
      const Vec2 x = spec.origin + Vec2(i * spec.cell_size.x(), j * spec.cell_size.y());
      mesh.nodes.push_back(spec.angle == 0.0 ? x : Vec2(r * x));
    }
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
  grid.locator = std::make_unique<StructuredLocator>(spec);
  return grid;
}

Grid make_unstructured_grid(Mesh mesh) {
  if (mesh.kinds.empty()) throw InputError("grid: the mesh has no cells");
  check_convex(mesh);
  interior_edges(mesh);  // throws if an edge has more than two cells
  Grid grid;
  grid.locator = std::make_unique<BinLocator>(mesh);
  grid.mesh = std::move(mesh);
  return grid;
}

}  // namespace berm
