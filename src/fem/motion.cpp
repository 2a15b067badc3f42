/// Mass and motion of the nodes (docs/theory/dynamics.md).

#include "fem/element.hpp"
#include "fem/fem.hpp"

namespace berm {
namespace {

constexpr int most = fem::most_nodes;
using ElementMass = std::array<double, most * most>;

}  // namespace

/// M_IJ = sum rho N_I N_J V0 of an element, and its mass.   [dynamics (3)]
double FemDiscretisation::element_mass(int k, double* M) const {
  const int n = static_cast<int>(blocks[k].size());
  std::fill_n(M, n * n, 0.0);
  double total = 0.0;
  int p = first_[k];
  for (const fem::RulePoint& q : fem::element_rule(mesh_.kinds[elements_[k]])) {
    const double m = density_[k] * material.volume[p++];
    total += m;
    for (int I = 0; I < n; ++I)
      for (int J = 0; J < n; ++J) M[n * I + J] += m * q.shape.N[I] * q.shape.N[J];
  }
  return total;
}

/// Velocities are those of the nodes of the body that stands first in the case where bodies share none.
void FemDiscretisation::start_motion(const std::function<Vec3(int body, const Vec3& X)>& velocity) {
  std::fill(a_.begin(), a_.end(), Vec3::Zero());
  std::fill(v_.begin(), v_.end(), Vec3::Zero());
  for (std::size_t k = 0; k < elements_.size(); ++k)
    for (int node : blocks[static_cast<int>(k)]) v_[node] = velocity(body_of_element_[elements_[k]], nodes[node]);
}

/// The diagonal of the consistent mass, scaled to the mass of the element: positive for quadratic elements too (Hinton,
/// Rock and Zienkiewicz 1976).   [dynamics (3)]
void FemDiscretisation::add_motion(std::vector<double>& mass, NodalVector& momentum, NodalVector& inertia) const {
  ElementMass M;
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::span<const int> list = blocks[static_cast<int>(k)];
    const std::size_t n = list.size();
    const double total = element_mass(static_cast<int>(k), M.data());
    double diagonal = 0.0;
    for (std::size_t I = 0; I < n; ++I) diagonal += M[(n + 1) * I];
    for (std::size_t I = 0; I < n; ++I) {
      const double m = M[(n + 1) * I] * total / diagonal;
      mass[list[I]] += m;
      momentum[list[I]] += m * v_[list[I]];
      inertia[list[I]] += m * a_[list[I]];
    }
  }
}

void FemDiscretisation::add_inertia(double factor, const NodalVector& a, NodalVector& f, BlockAssembler* matrix) const {
  const int d = dimension();
  ElementMass M;
  std::array<double, 9 * most * most> K;
  for (std::size_t k = 0; k < elements_.size(); ++k) {
    const std::span<const int> list = blocks[static_cast<int>(k)];
    const int n = static_cast<int>(list.size());
    element_mass(static_cast<int>(k), M.data());
    for (int I = 0; I < n; ++I)
      for (int J = 0; J < n; ++J) f[list[I]] += M[n * I + J] * a[list[J]];
    if (!matrix) continue;
    std::fill_n(K.begin(), d * n * d * n, 0.0);
    for (int I = 0; I < n; ++I)
      for (int J = 0; J < n; ++J)
        for (int c = 0; c < d; ++c) K[(d * I + c) * d * n + d * J + c] = factor * M[n * I + J];
    matrix->add(static_cast<int>(k), K.data());
  }
}

void FemDiscretisation::commit_motion(const NodalVector&, const NodalVector&, const NodalVector& v1,
                                      const NodalVector& a1, const Dynamics&) {
  v_ = v1;
  a_ = a1;
}

/// With the mass of the equation of motion.
double FemDiscretisation::kinetic_energy(const Dynamics& how) const {
  if (how.mass == Dynamics::Mass::lumped) {
    std::vector<double> mass(nodes.size(), 0.0);
    NodalVector unused(nodes.size(), Vec3::Zero());
    add_motion(mass, unused, unused);
    double sum = 0.0;
    for (std::size_t i = 0; i < nodes.size(); ++i) sum += 0.5 * mass[i] * v_[i].squaredNorm();
    return sum;
  }
  NodalVector momentum(nodes.size(), Vec3::Zero());
  add_inertia(0.0, v_, momentum, nullptr);
  double sum = 0.0;
  for (std::size_t i = 0; i < nodes.size(); ++i) sum += 0.5 * momentum[i].dot(v_[i]);
  return sum;
}

}  // namespace berm
