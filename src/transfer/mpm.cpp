#include "transfer/mpm.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "method/crack_band.hpp"
#include "shape/linear.hpp"

namespace berm {

MpmDiscretisation::MpmDiscretisation(Grid grid, double ghost_penalty, Formulation formulation)
    : grid_(std::move(grid)),
      ghost_penalty_(ghost_penalty),
      total_lagrangian_(formulation == Formulation::total_lagrangian) {
  nodes = grid_.mesh.nodes;
  active.assign(nodes.size(), 0);
  active_index_.assign(grid_.mesh.n_cells(), -1);
  double sum = 0.0;
  for (int c = 0; c < grid_.mesh.n_cells(); ++c) {
    cell_area_.push_back(cell_area(grid_.mesh, c));
    sum += cell_area_.back() * (corners_of(grid_.mesh.kinds[c]) == 3 ? 2.0 : 1.0);
  }
  cell_size_ = std::sqrt(sum / grid_.mesh.n_cells());
  grid_edges_ = interior_edges(grid_.mesh);
}

void MpmDiscretisation::add_body(int body, const std::string& name, const Material& spec, const SeededPoints& points,
                                 double thickness) {
  const double youngs = std::visit([](const auto& law) { return law.youngs_modulus; }, spec.law);
  std::vector<double> volume, length;
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    const int cell = grid_.locator->locate(points.x[p], -1);
    if (cell < 0)
      throw InputError(
          fmt::format("body \"{}\": a material point at ({:.6g}, {:.6g}) lies outside the background grid: "
                      "make the grid larger or move the body",
                      name, points.x[p].x(), points.x[p].y()));
    volume.push_back(points.area[p] * thickness);
    length.push_back(crack_band_length(spec, grid_.mesh, cell));
    const std::string problem = std::visit([&](const auto& law) { return law.check(length.back()); }, spec.law);
    if (!problem.empty()) throw InputError(fmt::format("body \"{}\", material \"{}\": {}", name, spec.name, problem));
    X_.push_back(points.x[p]);
    x_.push_back(points.x[p]);
    u_.push_back(Vec2::Zero());
    mass_.push_back(spec.density * volume.back());
    area_.push_back(points.area[p]);
    youngs_.push_back(youngs * thickness);
    cell_.push_back(cell);
    home_.push_back(points.shift.empty() ? -1 : cell);
    shift_.push_back(points.shift.empty() ? Vec2::Zero() : points.shift[p]);
  }
  material.add(body, spec.law, volume, length);
  shape_.resize(x_.size());
  push_.resize(x_.size());
}

void MpmDiscretisation::begin_step(std::vector<Anchor*>& anchors) {
  for (std::size_t p = 0; p < x_.size(); ++p) {
    if (total_lagrangian_) break;  // the cells of the start hold
    cell_[p] = grid_.locator->locate(x_[p], cell_[p]);
    if (cell_[p] < 0)
      throw RunError(
          fmt::format("material point {} has left the background grid at ({:.6g}, {:.6g}): make the grid "
                      "larger, or stop the run earlier",
                      p, x_[p].x(), x_[p].y()));
  }
  for (Anchor* a : anchors) {
    a->cell = grid_.locator->locate(seen(*a) + 1e-6 * cell_size_ * a->inward, a->cell);
    if (a->cell < 0)
      throw RunError(
          fmt::format("a surface point has left the background grid at ({:.6g}, {:.6g}): make the grid larger",
                      a->x.x(), a->x.y()));
  }
  sort_points(anchors);
  evaluate_shapes();
  for (Anchor* a : anchors) {
    Shape4 shape{};
    linear_shape(grid_.mesh, a->cell, seen(*a), shape);
    a->block = active_index_[a->cell];
    a->stencil.n = shape.n;
    for (int k = 0; k < shape.n; ++k) {
      a->stencil.node[k] = shape.nodes[k];
      a->stencil.N[k] = shape.N[k];
    }
  }
  build_faces();
}

/// Counting sort of the points by cell; cells of anchors are active even without points.
void MpmDiscretisation::sort_points(const std::vector<Anchor*>& anchors) {
  const int n_cells = grid_.mesh.n_cells();
  std::vector<int> count(n_cells, 0);
  std::vector<char> used(n_cells, 0);
  for (int c : cell_) {
    ++count[c];
    used[c] = 1;
  }
  for (const Anchor* a : anchors) used[a->cell] = 1;

  active_cells_.clear();
  first_.assign(1, 0);
  blocks = Blocks{};
  std::fill(active.begin(), active.end(), 0);
  for (int c = 0; c < n_cells; ++c) {
    active_index_[c] = -1;
    if (!used[c]) continue;
    active_index_[c] = static_cast<int>(active_cells_.size());
    active_cells_.push_back(c);
    first_.push_back(first_.back() + count[c]);
    const std::span<const int> list(grid_.mesh.cell(c), nodes_of(grid_.mesh.kinds[c]));
    blocks.add(list);
    for (int node : list) active[node] = 1;
  }
  holds_rigid_.assign(active_cells_.size(), 0);
  for (const Anchor* a : anchors)
    if (a->rigid) holds_rigid_[active_index_[a->cell]] = 1;
  order_.resize(x_.size());
  std::vector<int> fill(first_.begin(), first_.end() - 1);
  for (std::size_t p = 0; p < x_.size(); ++p) order_[fill[active_index_[cell_[p]]]++] = static_cast<int>(p);
}

std::vector<Vec2> MpmDiscretisation::points_inside(const Region& region, const std::string& body) const {
  return seed_from_grid(region, grid_, {}, body).x;
}

void MpmDiscretisation::evaluate_shapes() {
  Shape4 shape{};
  fill_.assign(active_cells_.size(), 0.0);
  cell_stiffness_.assign(active_cells_.size(), 0.0);
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    double area = 0.0, stiffness = 0.0;
    for (int p : points_in(static_cast<int>(a))) {
      if (!linear_shape(grid_.mesh, active_cells_[a], seen(p), shape))
        throw RunError(fmt::format("cell {} of the background grid is too distorted", active_cells_[a]));
      shape_[p] = {shape.N, shape.grad};
      area += area_[p];
      stiffness += area_[p] * youngs_[p] * (1.0 - material.damage[p]);
    }
    fill_[a] = area / cell_area_[active_cells_[a]];
    cell_stiffness_[a] = area > 0.0 ? stiffness / area : 0.0;
  }
}

/// Ghost stabilisation (Burman 2010; for MPM: Coombs 2023): faces between active cells of which one is cut.
void MpmDiscretisation::build_faces() {
  faces_.clear();
  if (ghost_penalty_ <= 0.0) return;
  constexpr double whole = 0.9;  // filled more than this: a cell does not need help
  const double g = 1.0 / std::sqrt(3.0);
  Shape4 sa{}, sb{};
  for (const InteriorEdge& e : grid_edges_) {
    const int a = active_index_[e.cell_a], b = active_index_[e.cell_b];
    if (a < 0 || b < 0 || (fill_[a] > whole && fill_[b] > whole) || holds_rigid_[a] || holds_rigid_[b]) continue;
    const Vec2 p0 = nodes[e.node_a], p1 = nodes[e.node_b];
    const double length = (p1 - p0).norm();
    const Vec2 normal(-(p1 - p0).y() / length, (p1 - p0).x() / length);

    Face face;
    face.cell_a = a;
    face.cell_b = b;
    // The softer side counts (a broken cell must not be held by its neighbour); empty cells take the other side's
    // value.
    const double ka = cell_stiffness_[a], kb = cell_stiffness_[b];
    const double stiffness = ka > 0.0 && kb > 0.0 ? std::min(ka, kb) : std::max(ka, kb);
    face.weight = ghost_penalty_ * stiffness * length * 0.5 * length;

    std::array<int, 8> list{};
    int n = 0;
    for (int q = 0; q < 2; ++q) {
      const Vec2 x = 0.5 * (p0 + p1) + (q == 0 ? -0.5 : 0.5) * g * (p1 - p0);
      linear_shape(grid_.mesh, e.cell_a, x, sa);
      linear_shape(grid_.mesh, e.cell_b, x, sb);
      if (q == 0) {
        n = sa.n;
        std::copy_n(sa.nodes.begin(), sa.n, list.begin());
        for (int k = 0; k < sb.n; ++k)
          if (std::find(list.begin(), list.begin() + n, sb.nodes[k]) == list.begin() + n) list[n++] = sb.nodes[k];
      }
      face.jump[q].fill(0.0);
      for (int k = 0; k < n; ++k) {
        for (int i = 0; i < sa.n; ++i)
          if (sa.nodes[i] == list[k]) face.jump[q][k] += sa.grad[i].dot(normal);
        for (int i = 0; i < sb.n; ++i)
          if (sb.nodes[i] == list[k]) face.jump[q][k] -= sb.grad[i].dot(normal);
      }
    }
    face.block = blocks.size();
    blocks.add({list.data(), static_cast<std::size_t>(n)});
    faces_.push_back(face);
  }
}

/// F_{n+1} = (I + grad_n du) F_n and grad_{n+1} N = dF^-T grad_n N   [formulation (5), (7)];
/// small strain: F_{n+1} = F_n + grad du on the frozen configuration.
void MpmDiscretisation::trial_gradients(const NodalVector& du, Kinematics kinematics) {
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const std::span<const int> list = blocks[static_cast<int>(a)];
    const int n = static_cast<int>(list.size());
    std::array<Vec2, 4> d;
    for (int k = 0; k < n; ++k) d[k] = du[list[k]];
    for (int p : points_in(static_cast<int>(a))) {
      const Gradients& s = shape_[p];
      Mat2 grad = d[0] * s.grad[0].transpose();
      for (int k = 1; k < n; ++k) grad.noalias() += d[k] * s.grad[k].transpose();
      if (kinematics == Kinematics::small) {
        material.trial_F[p] = material.F[p] + grad;
        push_[p] = s.grad;
        continue;
      }
      // Gradients by reference coordinates (total, formulation (25)) or by those at t_n (updated).
      const Mat2 dF = total_lagrangian_ ? Mat2(material.F[p] + grad) : Mat2(Mat2::Identity() + grad);
      material.trial_F[p] = total_lagrangian_ ? dF : Mat2(dF * material.F[p]);
      const Mat2 push = dF.inverse().transpose();
      for (int k = 0; k < n; ++k) push_[p][k] = push * s.grad[k];
    }
  }
}

Status MpmDiscretisation::evaluate(const NodalVector& du, const LawSettings& settings, bool tangent) {
  kinematics_ = settings.kinematics;
  trial_gradients(du, settings.kinematics);
  return material.respond(settings, tangent);
}

/// f_I = sum_p tau_p grad_{n+1} N_I V0   [formulation (8)]
void MpmDiscretisation::add_internal_force(NodalVector& f) const {
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const std::span<const int> list = blocks[static_cast<int>(a)];
    const int n = static_cast<int>(list.size());
    std::array<Vec2, 4> sum = {Vec2::Zero(), Vec2::Zero(), Vec2::Zero(), Vec2::Zero()};
    for (int p : points_in(static_cast<int>(a))) {
      const Mat2 tau = material.trial[p].stress * material.volume[p];
      for (int k = 0; k < n; ++k) sum[k].noalias() += tau * push_[p][k];
    }
    for (int k = 0; k < n; ++k) f[list[k]] += sum[k];
  }
}

namespace {

/// K_(Ii)(Jk) = g_I,j a_ijkl g_J,l V0, summed over the points of a cell with N nodes.   [formulation (10)]
template <int N>
void cell_tangent(std::span<const int> points, const std::vector<std::array<Vec2, 4>>& gradients,
                  const MaterialState& material, Eigen::Matrix<double, 2 * N, 2 * N, Eigen::RowMajor>& K) {
  K.setZero();
  Eigen::Matrix<double, 4, 2 * N> G = Eigen::Matrix<double, 4, 2 * N>::Zero();
  Eigen::Matrix<double, 4, 2 * N> aG;
  for (int p : points) {
    for (int k = 0; k < N; ++k) {
      const Vec2& g = gradients[p][k];
      G(0, 2 * k) = g.x();
      G(1, 2 * k) = g.y();
      G(2, 2 * k + 1) = g.x();
      G(3, 2 * k + 1) = g.y();
    }
    aG.noalias() = (material.trial[p].tangent * material.volume[p]).lazyProduct(G);
    K.noalias() += G.transpose().lazyProduct(aG);
  }
}

}  // namespace

void MpmDiscretisation::add_tangent(BlockAssembler& matrix) const {
  Eigen::Matrix<double, 8, 8, Eigen::RowMajor> K4;
  Eigen::Matrix<double, 6, 6, Eigen::RowMajor> K3;
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const int block = static_cast<int>(a);
    if (blocks[block].size() == 4) {
      cell_tangent<4>(points_in(block), push_, material, K4);
      matrix.add(block, K4.data());
    } else {
      cell_tangent<3>(points_in(block), push_, material, K3);
      matrix.add(block, K3.data());
    }
  }
}

/// j(du, w) = sum_faces gamma E h int [d_n du] . [d_n w] ds   [formulation (14)]
void MpmDiscretisation::add_stabilisation(const NodalVector& du, NodalVector& f, BlockAssembler* matrix) const {
  std::array<double, 144> K;
  for (const Face& face : faces_) {
    const std::span<const int> list = blocks[face.block];
    const int n = static_cast<int>(list.size());
    for (const auto& jump : face.jump) {
      Vec2 total = Vec2::Zero();
      for (int k = 0; k < n; ++k) total += jump[k] * du[list[k]];
      for (int k = 0; k < n; ++k) f[list[k]] += face.weight * jump[k] * total;
    }
    if (!matrix) continue;
    std::fill_n(K.begin(), 4 * n * n, 0.0);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        double value = 0.0;
        for (const auto& jump : face.jump) value += face.weight * jump[i] * jump[j];
        K[(2 * i) * 2 * n + 2 * j] = value;
        K[(2 * i + 1) * 2 * n + 2 * j + 1] = value;
      }
    matrix->add(face.block, K.data());
  }
}

void MpmDiscretisation::add_body_force(const Vec2& acceleration, NodalVector& f) const {
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const std::span<const int> list = blocks[static_cast<int>(a)];
    for (int p : points_in(static_cast<int>(a)))
      for (std::size_t k = 0; k < list.size(); ++k) f[list[k]] += shape_[p].N[k] * mass_[p] * acceleration;
  }
}

void MpmDiscretisation::commit(const NodalVector& du, std::vector<Anchor*>& anchors) {
  material.commit();
  const bool move = kinematics_ == Kinematics::finite;
  for (std::size_t a = 0; a < active_cells_.size(); ++a) {
    const std::span<const int> list = blocks[static_cast<int>(a)];
    for (int p : points_in(static_cast<int>(a))) {
      // A point with a fitted quadrature sees the functions of a shifted place, but moves with its own.
      const Vec2 back = cell_[p] == home_[p] ? shift_[p] : Vec2::Zero();
      Vec2 step = Vec2::Zero();
      for (std::size_t k = 0; k < list.size(); ++k)
        step += (shape_[p].N[k] - shape_[p].grad[k].dot(back)) * du[list[k]];
      u_[p] += step;
      if (!move) continue;
      x_[p] += step;
      const double J = material.F[p].determinant();
      if (!(J > 0.0) || !std::isfinite(J))
        throw RunError(
            fmt::format("material point {} at ({:.6g}, {:.6g}) is turned inside out (det F = {:.3g}): take "
                        "smaller steps",
                        p, x_[p].x(), x_[p].y(), J));
    }
  }
  for (Anchor* a : anchors) {
    const Vec2 step = a->stencil.interpolate(du);
    a->u += step;
    if (move) a->x += step;
  }
}

}  // namespace berm
