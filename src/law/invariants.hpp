#pragma once
/// Isotropic responses in the two strain invariants e_v and e_s. docs/theory/plasticity.md, section "Two invariants".

#include <cmath>

#include "law/isotropic_return.hpp"

namespace berm {

/// e_v = tr e, e_s = sqrt(2/3 e':e') with the deviator e' = e - e_v/3 I, eq. (10).
struct StrainInvariants {
  double volume = 0.0;
  double shear = 0.0;
  Voigt deviator = Voigt::Zero();  ///< in tensor components

  explicit StrainInvariants(const Voigt& strain) : deviator(tensor_components(strain)) {
    volume = strain.head<3>().sum();
    deviator.head<3>().array() -= volume / 3.0;
    shear = std::sqrt(2.0 / 3.0 * (deviator.head<3>().squaredNorm() + 2.0 * deviator.tail<3>().squaredNorm()));
  }

  /// Strain with that volume and `share` times this deviator; engineering shear.
  Voigt strain(double new_volume, double share) const {
    Voigt e = engineering_shear(share * deviator);
    e.head<3>().array() += new_volume / 3.0;
    return e;
  }
};

/// d stress / d strain of stress = p I + 2/3 q/e_s e', eq. (12). q_per_shear: q / e_s; d: derivatives of (p, q) by
/// (e_v, e_s).
inline void invariant_tangent(const StrainInvariants& e, double q_per_shear, const Mat2& d, Voigt66& tangent) {
  const double root = std::sqrt(2.0 / 3.0);
  const Voigt n = e.shear > 0.0 ? Voigt(root / e.shear * e.deviator) : Voigt(Voigt::Zero());
  const Voigt one(1.0, 1.0, 1.0, 0.0, 0.0, 0.0);
  const double mu = q_per_shear / 3.0;
  Lame{d(0, 0) - 2.0 / 3.0 * mu, mu}.stiffness(1.0, tangent);
  tangent += root * (d(0, 1) * one * n.transpose() + d(1, 0) * n * one.transpose());
  tangent += (2.0 / 3.0 * d(1, 1) - 2.0 * mu) * n * n.transpose();
}

}  // namespace berm
