#pragma once
/// Isotropic laws in principal values: from a response to the three principal strains to stress and tangent.
/// docs/theory/plasticity.md, section "Principal axes".

#include <algorithm>
#include <array>
#include <cmath>

#include "law/elasticity.hpp"
#include "law/law.hpp"
#include "law/principal.hpp"

namespace berm {

/// Shear strain in tensor components to engineering shear: the inverse of tensor_components.
inline Voigt engineering_shear(const Voigt& t) {
  Voigt strain = t;
  strain.tail<3>() *= 2.0;
  return strain;
}

/// Principal strains in falling order, and what is assembled from values in that order.
class SortedPrincipal {
public:
  /// `strain` with engineering shear.
  explicit SortedPrincipal(const Voigt& strain) : axes_(tensor_components(strain)) {
    std::sort(order_.begin(), order_.end(), [&](int i, int j) { return axes_.value[i] > axes_.value[j]; });
    for (int i = 0; i < 3; ++i) value[i] = axes_.value[order_[i]];
  }

  Vec3 value;

  /// sum_i f_i n_i n_i^T in tensor components.
  Voigt assemble(const Vec3& f) const {
    Vec3 unsorted;
    for (int i = 0; i < 3; ++i) unsorted[order_[i]] = f[i];
    return axes_.assemble(unsorted);
  }

  /// d stress / d strain from the principal stresses and a = d stress_i / d value_j, eq. (8).
  void tangent(const Vec3& stress, const Mat3& a, Voigt66& d) const {
    const Voigt66 r = rotation();
    Voigt66 local = Voigt66::Zero();
    local.topLeftCorner<3, 3>() = a;
    for (int k = 0; k < 3; ++k) {
      const int i = k, j = (k + 1) % 3;
      local(3 + k, 3 + k) = spin_modulus(i, j, stress, a);
    }
    d.noalias() = r.transpose() * local * r;
  }

private:
  /// Shear modulus between the axes i and j, eq. (9); its limit where the strains coincide.
  double spin_modulus(int i, int j, const Vec3& stress, const Mat3& a) const {
    const double gap = value[i] - value[j];
    if (std::abs(gap) > 1e-8 * value.cwiseAbs().maxCoeff()) return 0.5 * (stress[i] - stress[j]) / gap;
    return 0.25 * (a(i, i) - a(i, j) - a(j, i) + a(j, j));
  }

  /// Strain in Voigt form to the same in the sorted principal axes.
  Voigt66 rotation() const {
    const Mat3 n = axes_.axes();
    Voigt66 r;
    for (int k = 0; k < 3; ++k) {
      const Vec3 a = n.col(order_[k]), b = n.col(order_[(k + 1) % 3]);
      r.row(k) << a[0] * a[0], a[1] * a[1], a[2] * a[2], a[0] * a[1], a[1] * a[2], a[2] * a[0];
      r.row(3 + k) << 2.0 * a[0] * b[0], 2.0 * a[1] * b[1], 2.0 * a[2] * b[2], a[0] * b[1] + a[1] * b[0],
          a[1] * b[2] + a[2] * b[1], a[2] * b[0] + a[0] * b[2];
    }
    return r;
  }

  Principal axes_;
  std::array<int, 3> order_{0, 1, 2};
};

/// Step without plastic flow of a law with linear elasticity: the strain is kept to the last bit.
inline void elastic_step(const Lame& c, const LawInput& in, double* new_elastic, LawOutput& out) {
  out.stress = c.stress(in.strain);
  out.stored_energy = 0.5 * in.strain.dot(out.stress);
  out.damage = out.dissipated = out.extrapolation_error = 0.0;
  if (in.want_tangent) c.stiffness(1.0, out.tangent);
  std::copy(in.strain.begin(), in.strain.end(), new_elastic);
}

/// Stress, energies and state of a step with plastic flow, from the elastic strain that it ends with. Hooke's law is
/// applied to that strain, so that the next step starts from this very stress. Eqs. (5) and (6).
inline void plastic_step(const Lame& c, const LawInput& in, const Voigt& elastic, double* new_elastic, LawOutput& out) {
  out.stress = c.stress(elastic);
  out.stored_energy = 0.5 * elastic.dot(out.stress);
  out.dissipated = out.stress.dot(in.strain - elastic);
  out.damage = out.extrapolation_error = 0.0;
  std::copy(elastic.begin(), elastic.end(), new_elastic);
}

}  // namespace berm
