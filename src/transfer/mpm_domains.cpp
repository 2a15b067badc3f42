/// Points that stand for domains: which nodes they see, which cells they cover, when they are split (docs/adr/0014,
/// docs/theory/formulation.md, section 16).

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "base/sort_unique.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// The layered cell of the lowest corner of a box; all cells with corners of a parallelogram or parallelepiped.
using PatchKey = std::array<int, 8>;

struct Patch {
  std::vector<int> nodes;  ///< of the basis; -1: none; filled up with it to a size for which there are kernels
  std::vector<int> cells;  ///< that its points cover
  std::vector<int> points;
};

/// Number of nodes, at least n, for which there are kernels.
int kernel_size(int n, int dimension) {
  for (const int size : dimension == 3 ? std::array{4, 8, 27, 64} : std::array{3, 4, 9, 16})
    if (n <= size) return size;
  throw std::logic_error("a patch has too many nodes");
}

/// Diagonal of the square root of a symmetric positive matrix; in the plane, where the third row is that of the identity,
/// from Cayley and Hamilton's equation.
Vec3 root_diagonal(const Mat3& A, int dimension) {
  if (dimension == 3) return Eigen::SelfAdjointEigenSolver<Mat3>(A).operatorSqrt().diagonal();
  const double root = std::sqrt(A(0, 0) * A(1, 1) - A(0, 1) * A(1, 0)), size = std::sqrt(A(0, 0) + A(1, 1) + 2.0 * root);
  return {(A(0, 0) + root) / size, (A(1, 1) + root) / size, 1.0};
}

/// Adds the nodes that a patch does not have, unless there would be too many for any kernel.
bool take_nodes(std::vector<int>& nodes, std::span<const int> more, int dimension) {
  std::vector<int> all = nodes;
  for (const int node : more)
    if (std::find(all.begin(), all.end(), node) == all.end()) all.push_back(node);
  if (static_cast<int>(all.size()) > (dimension == 3 ? 64 : 16)) return false;
  nodes = std::move(all);
  return true;
}

template <class List>
bool has(const List& list, int value) {
  return std::find(list.begin(), list.end(), value) != list.end();
}

}  // namespace

/// Columns: edges of the domain as the grid sees it.   [(61)]
Mat3 MpmDiscretisation::edges(int p) const { return shapes_.follows ? Mat3(material.F[p] * edges_[p]) : edges_[p]; }

/// Along the axes of the grid.   [(62)]
Vec3 MpmDiscretisation::box_edges(int p) const {
  const int d = dimension();
  Mat3 E = Mat3::Identity();
  E.topLeftCorner(d, d) = (basis_.to_own_axes() * edges(p)).topLeftCorner(d, d);
  Vec3 box = E.diagonal();
  if (shapes_.follows) {
    box = root_diagonal(E * E.transpose(), d);
    box.head(d) *= std::pow(std::abs(E.determinant()) / box.head(d).prod(), 1.0 / d);
  }
  return box;
}

/// No longer than cells.
Vec3 MpmDiscretisation::domain_box(int p) const { return box_edges(p).cwiseMin(grid_.structure->cell_size); }

int MpmDiscretisation::deciding_cell(int p) const {
  const bool boxes = shapes_.domain == ShapeChoice::Domain::box;
  return f_bar_ && boxes ? basis_.lowest_cell(seen(p), domain_box(p)) : cell_[p];
}

Cover MpmDiscretisation::cover_of(int p, BasisAt& shape) const {
  if (shapes_.domain == ShapeChoice::Domain::parallelepiped)
    return basis_.average_corners(seen(p), edges(p), cell_[p], shape);
  return basis_.average_box(seen(p), domain_box(p), shape);
}

/// Patches, shape functions, and what lies in the cells.
void MpmDiscretisation::look_at_domains(const std::vector<Anchor*>& anchors) {
  const int d = dimension();
  const bool boxes = shapes_.domain == ShapeChoice::Domain::box;
  // The mean dilatation is that of the points in a cell: these have one list, whatever cells their corners lie in.
  const bool by_cell = f_bar_ && !boxes;
  Blocks own_nodes;  // by point
  shape_.resize(x_.size() * stride_);
  layered_.resize(x_.size());
  std::map<PatchKey, Patch> patches;
  std::map<int, CellState> covered;
  const auto look_at = [&](int p, int slice, BasisAt& shape) {
    const int layer = layered_cell(0, material.slices[slice].body);
    layered_[p] = cell_[p] + layer;
    const Cover cover = cover_of(p, shape);
    if (cover.n == 0)
      throw RunError(fmt::format("the domain of material point {} reaches out of the background grid: make the grid larger",
                                 id_[p]));
    PatchKey key;
    key.fill(-1);
    const std::span<const int> own{shape.nodes.data(), static_cast<std::size_t>(shape.n)};
    if (by_cell) {
      own_nodes.add(own);
      key[0] = layered_[p];
    }
    if (!by_cell || !take_nodes(patches[key].nodes, own, d))
      for (int c = 0; c < (boxes ? 1 : cover.n); ++c) key[c] = cover.cell[c] + layer;
    Patch& patch = patches[key];
    if (patch.nodes.empty()) patch.nodes.assign(own.begin(), own.end());
    patch.points.push_back(p);
    const double size = measure_[p] * swollen(p), youngs = youngs_of_slice_[slice] * (1.0 - material.damage[p]);
    for (int c = 0; c < cover.n; ++c) {
      if (!has(patch.cells, cover.cell[c])) patch.cells.push_back(cover.cell[c]);
      CellState& cell = covered[cover.cell[c] + layer];
      cell.fill += cover.share[c] * size;
      cell.stiffness += cover.share[c] * size * youngs;
    }
    store_shape(p, by_cell ? shape.n : kernel_size(shape.n, d), shape);
  };
  comm_.agree([&] {
    BasisAt shape;
    for (std::size_t slice = 0; slice < material.slices.size(); ++slice)
      for (int p = material.slices[slice].begin; p < material.slices[slice].end; ++p)
        look_at(p, static_cast<int>(slice), shape);
  });

  patch_nodes_ = {};
  order_.clear();
  first_.assign(1, 0);
  for (auto& [key, patch] : patches) {
    if (patch.points.empty()) continue;
    patch.nodes.resize(kernel_size(static_cast<int>(patch.nodes.size()), d), -1);
    if (by_cell)
      for (const int p : patch.points) spread_shape(p, own_nodes[p], patch.nodes);
    std::vector<int> seen;
    for (const int c : patch.cells)
      for (const int node : basis_.nodes_of(c)) seen.push_back(node);
    // Nodes of no covered cell have zero values, and would be unknowns without stiffness.
    for (int& node : patch.nodes) node = (node >= 0 && has(seen, node) ? node : patch.nodes[0]);
    for (int& node : patch.nodes) node += field_of(key[0]) * basis_.n_nodes();
    patch_nodes_.add(patch.nodes);
    order_.insert(order_.end(), patch.points.begin(), patch.points.end());
    first_.push_back(static_cast<int>(order_.size()));
  }
  weigh_covered_cells(covered, anchors);
}

/// From the order of the point's own nodes to that of its patch, which has more.
void MpmDiscretisation::spread_shape(int p, std::span<const int> own, std::span<const int> nodes) {
  const int d = dimension(), n = static_cast<int>(own.size());
  double* s = shape_.data() + std::size_t(p) * stride_;
  BasisAt shape;
  shape.n = static_cast<int>(nodes.size());
  for (int k = 0; k < shape.n; ++k) {
    const auto at = std::find(own.begin(), own.end(), nodes[k]) - own.begin();
    shape.N[k] = at < n ? s[at] : 0.0;
    shape.grad[k].setZero();
    if (at < n) std::copy_n(s + n + d * at, d, shape.grad[k].data());
  }
  store_shape(p, shape.n, shape);
}

/// `covered`: measure, and Young's moduli times it, of this process's points in cells, whose owners want to know.
void MpmDiscretisation::weigh_covered_cells(const std::map<int, CellState>& covered,
                                            const std::vector<Anchor*>& anchors) {
  std::map<int, CellState> own;
  std::vector<std::vector<double>> to(comm_.size());
  for (const auto& [cell, state] : covered) {
    const int rank = comm_.size() == 1 ? 0 : owner_of_cell(grid_cell(cell));
    if (rank == comm_.rank())
      own[cell] = state;
    else
      to[rank].insert(to[rank].end(), {double(cell), state.fill, state.stiffness});
  }
  for (const auto& from : comm_.exchange(to))
    for (std::size_t k = 0; k < from.size(); k += 3) {
      CellState& state = own[static_cast<int>(from[k])];
      state.fill += from[k + 1];
      state.stiffness += from[k + 2];
    }
  find_carriers(anchors, [&own](int c) { return own.count(c) > 0; });
  anchor_cells_ = carrier_;
  sort_unique(anchor_cells_);
  for (std::size_t i = 0; i < anchors.size(); ++i) {
    const bool here = comm_.size() == 1 || owner_of_cell(grid_cell(carrier_[i])) == comm_.rank();
    if (here && anchors[i]->rigid) own[carrier_[i]].holds_rigid = 1;
    if (here) own[carrier_[i]];  // active even if it is empty
  }

  for (int c : active_cells_) active_index_[c] = -1;
  active_cells_.clear();
  cells_.clear();
  for (const auto& [cell, sums] : own) {
    active_index_[cell] = static_cast<int>(active_cells_.size());
    active_cells_.push_back(cell);
    cells_.push_back(sums);
  }
  average_cells();
}

// ---- domains that have become too long

/// Of a cell: with less than one and a half points a cell and direction functions have modes without strain at any point.
constexpr double longest_edge = 2.0 / 3.0;
/// Of a cell's edge, in every direction: smaller points are not split.
constexpr double smallest_point = 1.0 / 8.0;

/// Column of the edges to halve, or -1.
int MpmDiscretisation::edge_to_split(int p) const {
  constexpr double rounding = 1.0 + 1e-6;
  const int d = dimension();
  if (measure_[p] * swollen(p) <= std::pow(smallest_point * cell_size_, d) * rounding) return -1;
  const Mat3 E = edges(p);
  int longest = 0;
  if (shapes_.domain == ShapeChoice::Domain::parallelepiped)
    return E.colwise().norm().head(d).maxCoeff(&longest) > longest_edge * cell_size_ * rounding ? longest : -1;
  int along = 0;
  const Vec3 size = grid_.structure->cell_size;
  const auto is_short = [&](const Vec3& edge) {
    return edge.head(d).cwiseQuotient(size.head(d)).maxCoeff(&along) <= longest_edge * rounding;
  };
  // A diagonal entry of a root is at most the root of that of the square, and the factor of (62) at most 1 (Hadamard).
  if (is_short((basis_.to_own_axes() * E).rowwise().norm())) return -1;
  const Vec3 box = box_edges(p);
  if (is_short(box)) return -1;
  (basis_.to_own_axes() * E).row(along).head(d).cwiseAbs().maxCoeff(&longest);
  return longest;
}

/// Points whose domains have become too long become two of half the size. New ids follow the last one in the
/// order of the old ids: the same on any number of processes.
void MpmDiscretisation::split_points() {
  for (;;) {
    std::vector<std::int64_t> split;
    for (std::size_t p = 0; p < x_.size(); ++p)
      if (edge_to_split(static_cast<int>(p)) >= 0) split.push_back(id_[p]);
    if (!comm_.any(!split.empty())) return;
    split = comm_.all_gather(split);
    std::sort(split.begin(), split.end());
    std::vector<std::vector<double>> rows(material.slices.size());
    for (std::size_t s = 0; s < rows.size(); ++s) {
      const auto keep = [&, width = row_width(static_cast<int>(s))](int p) {
        rows[s].resize(rows[s].size() + width);
        write_row(p, rows[s].data() + rows[s].size() - width);
      };
      for (int p = material.slices[s].begin; p < material.slices[s].end; ++p) {
        const int edge = edge_to_split(p);
        if (edge < 0) {
          keep(p);
          continue;
        }
        const Vec3 at_start = 0.25 * edges_[p].col(edge), now = 0.25 * edges(p).col(edge);
        const auto move = [&](double factor) {
          X_[p] += factor * at_start;
          x_[p] += factor * now;
          u_[p] += factor * (now - at_start);
          v_[p] += factor * C_[p] * now;
          if (const double to = rim_[p].squaredNorm(); to > 0.0) rim_[p] *= std::max(0.0, 1.0 - factor * at_start.dot(rim_[p]) / to);
        };
        edges_[p].col(edge) *= 0.5;
        measure_[p] *= 0.5;
        // Around an axis the outer half has the longer way round.
        const double uneven = space_ == Space::axisymmetric ? at_start.x() / X_[p].x() : 0.0;
        const double mass = mass_[p], volume = material.volume[p];
        const auto take = [&](double share) {
          mass_[p] = share * mass;
          material.volume[p] = share * volume;
        };
        move(-1.0);
        take(0.5 * (1.0 - uneven));
        keep(p);
        move(2.0);
        take(0.5 * (1.0 + uneven));
        const auto at = std::lower_bound(split.begin(), split.end(), id_[p]);
        id_[p] = next_id_ + (at - split.begin());
        keep(p);
      }
    }
    next_id_ += static_cast<std::int64_t>(split.size());
    place_points(rows);
  }
}

}  // namespace berm
