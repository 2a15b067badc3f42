#include "fem/fem.hpp"

#include <fmt/format.h>

#include <cmath>

#include "base/error.hpp"
#include "method/crack_band.hpp"

namespace berm {
namespace {

/// The corner cells of a mesh (straight-sided), for point location.
Mesh corner_mesh(const Mesh& mesh) {
  Mesh out;
  out.nodes = mesh.nodes;
  for (int c = 0; c < mesh.n_cells(); ++c)
    out.add_cell(corners_of(mesh.kinds[c]) == 3 ? CellKind::tri3 : CellKind::quad4, mesh.cell(c));
  return out;
}

/// Local coordinates of x in element c by Newton; true if it lies inside within `tolerance`.
bool invert(const Mesh& mesh, int c, const Vec2& x, double tolerance, Vec2& xi) {
  const CellKind kind = mesh.kinds[c];
  const bool tri = corners_of(kind) == 3;
  xi = tri ? Vec2(1.0 / 3.0, 1.0 / 3.0) : Vec2(0.0, 0.0);
  for (int it = 0; it < 30; ++it) {
    const fem::ElementShape s = fem::element_shape(kind, xi);
    Vec2 r = x;
    Mat2 J = Mat2::Zero();
    for (int k = 0; k < s.n; ++k) {
      r -= s.N[k] * mesh.nodes[mesh.cell(c)[k]];
      J += mesh.nodes[mesh.cell(c)[k]] * s.dN[k].transpose();
    }
    const Vec2 step = J.inverse() * r;
    xi += step;
    if (step.norm() < 1e-13) break;
    if (!(xi.norm() < 10.0)) return false;
  }
  if (tri) return xi.x() >= -tolerance && xi.y() >= -tolerance && xi.sum() <= 1.0 + tolerance;
  return xi.cwiseAbs().maxCoeff() <= 1.0 + 2.0 * tolerance;
}

}  // namespace

void FemDiscretisation::add_body(int body, const std::string& name, const Material& spec, const Mesh& mesh,
                                 double thickness) {
  const int node0 = mesh_.n_nodes(), element0 = mesh_.n_cells();
  mesh_.nodes.insert(mesh_.nodes.end(), mesh.nodes.begin(), mesh.nodes.end());
  for (const auto& [group, list] : mesh.node_groups)
    for (int node : list) mesh_.node_groups[group].push_back(node0 + node);

  std::vector<double> volume, length;
  for (int c = 0; c < mesh.n_cells(); ++c) {
    const CellKind kind = mesh.kinds[c];
    std::array<int, 8> list{};
    for (int k = 0; k < nodes_of(kind); ++k) list[k] = node0 + mesh.cell(c)[k];
    mesh_.add_cell(kind, list.data());
    body_of_element_.push_back(body);
    const double l = crack_band_length(spec, mesh, c);
    const std::string problem = std::visit([&](const auto& law) { return law.check(l); }, spec.law);
    if (!problem.empty()) throw InputError(fmt::format("body \"{}\", material \"{}\": {}", name, spec.name, problem));

    for (const QuadraturePoint& q : fem::element_rule(kind)) {
      const fem::ElementShape s = fem::element_shape(kind, q.xi);
      Mat2 J = Mat2::Zero();
      for (int k = 0; k < s.n; ++k) J += mesh.nodes[mesh.cell(c)[k]] * s.dN[k].transpose();
      const double det = J.determinant();
      if (!(det > 0.0))
        throw InputError(
            fmt::format("body \"{}\": element {} of its mesh is turned inside out (Jacobian {:.3g})", name, c, det));
      GaussPoint g;
      g.N = s.N;
      const Mat2 inverse = J.inverse().transpose();
      for (int k = 0; k < s.n; ++k) g.grad[k] = inverse * s.dN[k];
      points_.push_back(g);
      volume.push_back(q.weight * det * thickness);
      mass_.push_back(spec.density * volume.back());
      length.push_back(l);
      area_ += q.weight * det;
    }
    first_.push_back(static_cast<int>(points_.size()));
  }
  material.add(body, spec.law, volume, length);
  push_.resize(points_.size());
  u_.assign(mesh_.nodes.size(), Vec2::Zero());
  nodes = mesh_.nodes;
  active.assign(nodes.size(), 1);
  bodies_.push_back({body, element0, make_unstructured_grid(corner_mesh(mesh))});

  blocks = Blocks{};
  for (int e = 0; e < mesh_.n_cells(); ++e)
    blocks.add({mesh_.cell(e), static_cast<std::size_t>(nodes_of(mesh_.kinds[e]))});
  cell_size_ = std::sqrt(area_ / mesh_.n_cells());
}

int FemDiscretisation::first_element(int body) const {
  for (const BodyMesh& b : bodies_)
    if (b.body == body) return b.first_element;
  return -1;
}

/// The element that holds an anchor's reference position. Meshes of curved bodies leave slivers outside: the nearest
/// element within half a cell serves, its functions extended.
void FemDiscretisation::attach(Anchor& anchor) const {
  for (const BodyMesh& b : bodies_) {
    if (b.body != anchor.body) continue;
    const Mesh& local = b.corners.mesh;
    Vec2 xi;
    int element = b.corners.locator->locate(anchor.X, -1);
    if (element >= 0 && !invert(mesh_, b.first_element + element, anchor.X, 0.2, xi)) element = -1;
    double best = 0.0;
    for (int c = 0; element < 0 && c < local.n_cells(); ++c)
      if (invert(mesh_, b.first_element + c, anchor.X, 1e-9, xi)) element = c;
    if (element < 0)
      for (int c = 0; c < local.n_cells(); ++c) {
        Vec2 trial;
        if (!invert(mesh_, b.first_element + c, anchor.X, 0.5, trial)) continue;
        Vec2 centre = Vec2::Zero();
        const int n = corners_of(local.kinds[c]);
        for (int k = 0; k < n; ++k) centre += local.nodes[local.cell(c)[k]] / n;
        const double distance = (centre - anchor.X).norm();
        if (element < 0 || distance < best) {
          best = distance;
          element = c;
        }
      }
    if (element < 0) break;
    invert(mesh_, b.first_element + element, anchor.X, 1.0, xi);
    anchor.cell = anchor.block = b.first_element + element;
    const fem::ElementShape s = fem::element_shape(mesh_.kinds[anchor.cell], xi);
    anchor.stencil.n = s.n;
    anchor.stencil.N = s.N;
    for (int k = 0; k < s.n; ++k) anchor.stencil.node[k] = mesh_.cell(anchor.cell)[k];
    return;
  }
  throw InputError(
      fmt::format("the point ({:.6g}, {:.6g}) lies in no element of its body's mesh", anchor.X.x(), anchor.X.y()));
}

void FemDiscretisation::begin_step(std::vector<Anchor*>& anchors) {
  for (Anchor* a : anchors)
    if (a->stencil.n == 0) attach(*a);
}

/// F = I + sum u_I (x) grad_X N_I, gradients pushed forward by F^-T.   [formulation (11)]
Status FemDiscretisation::evaluate(const NodalVector& du, const LawSettings& settings, bool tangent) {
  for (int e = 0; e < mesh_.n_cells(); ++e) {
    const std::span<const int> list = blocks[e];
    for (int p = first_[e]; p < first_[e + 1]; ++p) {
      Mat2 F = Mat2::Identity();
      for (std::size_t k = 0; k < list.size(); ++k)
        F.noalias() += (u_[list[k]] + du[list[k]]) * points_[p].grad[k].transpose();
      material.trial_F[p] = F;
      if (settings.kinematics == Kinematics::small) {
        push_[p] = points_[p].grad;
        continue;
      }
      const Mat2 push = F.inverse().transpose();
      for (std::size_t k = 0; k < list.size(); ++k) push_[p][k] = push * points_[p].grad[k];
    }
  }
  return material.respond(settings, tangent);
}

void FemDiscretisation::add_internal_force(NodalVector& f) const {
  for (int e = 0; e < mesh_.n_cells(); ++e) {
    const std::span<const int> list = blocks[e];
    for (int p = first_[e]; p < first_[e + 1]; ++p) {
      const Mat2 tau = material.trial[p].stress * material.volume[p];
      for (std::size_t k = 0; k < list.size(); ++k) f[list[k]] += tau * push_[p][k];
    }
  }
}

void FemDiscretisation::add_tangent(BlockAssembler& matrix) const {
  std::array<double, 256> K;
  for (int e = 0; e < mesh_.n_cells(); ++e) {
    const int n = static_cast<int>(blocks[e].size());
    std::fill_n(K.begin(), 4 * n * n, 0.0);
    for (int p = first_[e]; p < first_[e + 1]; ++p) {
      const Eigen::Matrix4d a = material.trial[p].tangent * material.volume[p];
      for (int J = 0; J < n; ++J) {
        const Vec2& gJ = push_[p][J];
        // Columns: stress increments for a unit displacement of node J in x and y.
        const Eigen::Vector4d tx = a.col(0) * gJ.x() + a.col(1) * gJ.y();
        const Eigen::Vector4d ty = a.col(2) * gJ.x() + a.col(3) * gJ.y();
        for (int I = 0; I < n; ++I) {
          const Vec2& gI = push_[p][I];
          double* row_x = K.data() + (2 * I) * 2 * n + 2 * J;
          double* row_y = row_x + 2 * n;
          row_x[0] += gI.x() * tx[0] + gI.y() * tx[1];
          row_x[1] += gI.x() * ty[0] + gI.y() * ty[1];
          row_y[0] += gI.x() * tx[2] + gI.y() * tx[3];
          row_y[1] += gI.x() * ty[2] + gI.y() * ty[3];
        }
      }
    }
    matrix.add(e, K.data());
  }
}

void FemDiscretisation::add_body_force(const Vec2& acceleration, NodalVector& f) const {
  for (int e = 0; e < mesh_.n_cells(); ++e) {
    const std::span<const int> list = blocks[e];
    for (int p = first_[e]; p < first_[e + 1]; ++p)
      for (std::size_t k = 0; k < list.size(); ++k) f[list[k]] += points_[p].N[k] * mass_[p] * acceleration;
  }
}

void FemDiscretisation::commit(const NodalVector& du, std::vector<Anchor*>& anchors) {
  material.commit();
  for (std::size_t i = 0; i < u_.size(); ++i) u_[i] += du[i];
  for (Anchor* a : anchors) {
    a->u = a->stencil.interpolate(u_);
    a->x = a->X + a->u;
  }
}

std::vector<Vec2> FemDiscretisation::point_positions() const {
  std::vector<Vec2> x;
  for (int e = 0; e < mesh_.n_cells(); ++e)
    for (int p = first_[e]; p < first_[e + 1]; ++p) {
      Vec2 sum = Vec2::Zero();
      for (std::size_t k = 0; k < blocks[e].size(); ++k)
        sum += points_[p].N[k] * (mesh_.nodes[blocks[e][k]] + u_[blocks[e][k]]);
      x.push_back(sum);
    }
  return x;
}

std::vector<Vec2> FemDiscretisation::point_displacements() const {
  std::vector<Vec2> u;
  for (int e = 0; e < mesh_.n_cells(); ++e)
    for (int p = first_[e]; p < first_[e + 1]; ++p) {
      Vec2 sum = Vec2::Zero();
      for (std::size_t k = 0; k < blocks[e].size(); ++k) sum += points_[p].N[k] * u_[blocks[e][k]];
      u.push_back(sum);
    }
  return u;
}

}  // namespace berm
