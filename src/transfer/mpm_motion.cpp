/// Motion between points and nodes (docs/theory/dynamics.md).

#include "transfer/mpm.hpp"

namespace berm {

void MpmDiscretisation::start_motion(const std::function<Vec3(int body, const Vec3& X)>& velocity) {
  for (const Slice& slice : material.slices)
    for (int p = slice.begin; p < slice.end; ++p) v_[p] = velocity(slice.body, X_[p]);
  std::fill(a_.begin(), a_.end(), Vec3::Zero());
  std::fill(C_.begin(), C_.end(), Mat3::Zero());
}

/// sum m N, sum m N (v + C (x_I - x)), sum m N a   [dynamics (1), (2); C: (9)]
void MpmDiscretisation::add_motion(std::vector<double>& mass, NodalVector& momentum, NodalVector& inertia) const {
  for_points([&](std::span<const int> list, int p, const double* N) {
    const Vec3 origin = v_[p] - C_[p] * seen(p);
    for (std::size_t k = 0; k < list.size(); ++k) {
      const double m = mass_[p] * N[k];
      mass[list[k]] += m;
      momentum[list[k]] += m * (origin + C_[p] * nodes[list[k]]);
      inertia[list[k]] += m * a_[p];
    }
  });
}

/// M_IJ = sum m N_I N_J   [dynamics (3)]
void MpmDiscretisation::add_inertia(double factor, const NodalVector& a, NodalVector& f, BlockAssembler* matrix) const {
  const int d = dimension();
  const std::size_t most = most_nodes_;
  std::vector<double> M(most * most), K(d * most * d * most);
  for (int block = 0; block < n_patches(); ++block) {
    const std::span<const int> list = blocks[block];
    const int n = static_cast<int>(list.size());
    std::fill_n(M.begin(), n * n, 0.0);
    for (int p : points_in(block)) {
      const double* N = shape(p);
      for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) M[n * i + j] += mass_[p] * N[i] * N[j];
    }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) f[list[i]] += M[n * i + j] * a[list[j]];
    if (!matrix) continue;
    std::fill_n(K.begin(), d * n * d * n, 0.0);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j)
        for (int c = 0; c < d; ++c) K[(d * i + c) * d * n + d * j + c] = factor * M[n * i + j];
    matrix->add(block, K.data());
  }
}

void MpmDiscretisation::start_accelerations(const NodalVector& a) {
  for_points([&](std::span<const int> list, int p, const double* N) {
    a_[p].setZero();
    for (std::size_t k = 0; k < list.size(); ++k) a_[p] += N[k] * a[list[k]];
  });
}

/// Velocities and accelerations: flip of what the point had and the change of the nodes, the rest what the nodes have.
/// [dynamics (7), (8)]   apic: only the latter, and C = sum v1 (x) grad N   [(9)]
void MpmDiscretisation::commit_motion(const NodalVector& v0, const NodalVector& a0, const NodalVector& v1,
                                      const NodalVector& a1, const Dynamics& how) {
  using Transfer = Dynamics::Transfer;
  const bool apic = how.transfer == Transfer::apic;
  const double flip = how.transfer == Transfer::flip ? 1.0 : how.transfer == Transfer::blend ? how.flip_fraction : 0.0;
  const bool mean = how.integrator == Dynamics::Integrator::newmark;  // a hint for the next step, no state
  const double keep = mean ? 0.0 : flip;  // of the acceleration
  const int d = dimension();
  for_points([&](std::span<const int> list, int p, const double* s) {
    const int n = static_cast<int>(list.size());
    Vec3 v = flip * v_[p], a = keep * a_[p];
    for (int k = 0; k < n; ++k) {
      v += s[k] * (v1[list[k]] - flip * v0[list[k]]);
      a += s[k] * (a1[list[k]] - keep * a0[list[k]]);
    }
    v_[p] = v;
    a_[p] = a;
    if (!apic) return;
    C_[p].setZero();
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < d; ++j) C_[p].col(j) += s[n + d * k + j] * v1[list[k]];
  });
}

/// Of the points; what their gradients carry counts too: 1/2 m sum N |C (x_I - x)|^2.
double MpmDiscretisation::kinetic_energy(const Dynamics&) const {
  double sum = 0.0;
  for_points([&](std::span<const int> list, int p, const double* N) {
    sum += 0.5 * mass_[p] * v_[p].squaredNorm();
    if (C_[p].isZero(0.0)) return;
    for (std::size_t k = 0; k < list.size(); ++k)
      sum += 0.5 * mass_[p] * N[k] * (C_[p] * (nodes[list[k]] - seen(p))).squaredNorm();
  });
  return sum;
}

void MpmDiscretisation::reset_displacements() { std::fill(u_.begin(), u_.end(), Vec3::Zero()); }

}  // namespace berm
