/// Stresses at Gauss points out of those at the points of a cell.   [docs/theory/formulation.md, section 18]

#include <Eigen/LU>
#include <algorithm>

#include "mesh/cell_map.hpp"
#include "shape/quadrature.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// Exact for linear stresses times gradients; these are constant in simplices.
std::vector<QuadraturePoint> rule_of(CellKind kind) {
  if (is_simplex(kind)) return dimension_of(kind) == 2 ? gauss_triangle(1) : gauss_tetrahedron(1);
  return dimension_of(kind) == 2 ? gauss_square(2) : gauss_cube(2);
}

/// 1 and the place in units of the cell size.
Eigen::Vector4d linear_terms(const Vec3& r, int dimension) { return {1.0, r.x(), r.y(), dimension == 3 ? r.z() : 0.0}; }

}  // namespace

/// Whether the body fills the cell, as far as one can tell from the cells about it: none of them is empty, except where
/// the grid ends.
bool MpmDiscretisation::is_inside(int active) const {
  constexpr double full = 0.75, present = 0.25;
  const int cell = active_cells_[active];
  if (cells_[active].fill < full) return false;
  for (int f = 0; f < max_faces; ++f) {
    const int other = neighbour(cell, f);
    if (other < 0) continue;
    const CellState* state = cell_state(other);
    if (!state || state->fill < present) return false;
  }
  return true;
}

/// Gradients with which the forces are formed, in place of those of the points, for the cells inside of the body: f_I =
/// sum_p V_p S_p g_pI with V_p g_pI = sum_g w_g phi_p(x_g) grad N_I(x_g).   [formulation (66), (67)]
void MpmDiscretisation::look_at_gauss_points() {
  const int d = dimension();
  std::vector<int> slice_of(x_.size());
  for (std::size_t k = 0; k < material.slices.size(); ++k)
    std::fill(slice_of.begin() + material.slices[k].begin, slice_of.begin() + material.slices[k].end,
              static_cast<int>(k));
  force_gradient_.resize(x_.size() * std::size_t(d) * most_nodes_);
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const int active = static_cast<int>(a);
    const int n = static_cast<int>(patch_nodes_[active].size());
    const std::span<const int> points = points_in(active);
    for (const int p : points)
      std::copy_n(shape(p) + n, n * d, force_gradient_.data() + std::size_t(p) * d * most_nodes_);
    const bool one_body =
        std::all_of(points.begin(), points.end(), [&](int p) { return slice_of[p] == slice_of[points[0]]; });
    if (!points.empty() && one_body && is_inside(active)) fit_forces(active);
  }
}

void MpmDiscretisation::fit_forces(int active) {
  const int d = dimension(), cell = grid_cell(active_cells_[active]);
  const int n = static_cast<int>(patch_nodes_[active].size());
  const CellKind kind = grid_.mesh.kinds[cell];
  const Corners p = corners(grid_.mesh, cell);
  const Vec3 centre = cell_centre(grid_.mesh, cell);
  const std::span<const int> points = points_in(active);

  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  double volume = 0.0;
  for (const int q : points) {
    const Eigen::Vector4d t = linear_terms((seen(q) - centre) / cell_size_, d);
    const double size = measure_[q] * swollen(q);
    moments += size * t * t.transpose();
    volume += size;
  }
  moments /= volume;
  if (d == 2) moments(3, 3) = 1.0;
  const Eigen::FullPivLU<Eigen::Matrix4d> lu(moments);
  constexpr double determined = 1e-3;  // points in two rows of a fifth of a cell
  if (!lu.isInvertible() || lu.rcond() < determined) return;

  for (const int q : points) std::fill_n(force_gradient_.data() + std::size_t(q) * d * most_nodes_, n * d, 0.0);
  BasisAt at;
  for (const QuadraturePoint& g : rule_of(kind)) {
    LocalShape local;
    local_shape(kind, g.xi, local);
    Vec3 place = Vec3::Zero();
    for (int k = 0; k < p.n; ++k) place += local.N[k] * p.x[k];
    const double weight = g.weight * cell_jacobian(p, d, local).determinant();
    basis_.evaluate(cell, place, at);
    const Eigen::Vector4d fit = lu.solve(linear_terms((place - centre) / cell_size_, d)) / volume;
    for (const int q : points) {
      // phi_q(x_g) V_q of the fit over V_q of the point
      const double share = weight * fit.dot(linear_terms((seen(q) - centre) / cell_size_, d));
      double* out = force_gradient_.data() + std::size_t(q) * d * most_nodes_;
      for (int k = 0; k < n; ++k)
        for (int i = 0; i < d; ++i) out[d * k + i] += share * at.grad[k][i];
    }
  }
}

}  // namespace berm
