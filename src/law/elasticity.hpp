#pragma once
/// Isotropic linear elasticity: the part that every law of this folder shares.

#include <vector>

#include "base/parameter.hpp"
#include "base/tensor.hpp"

namespace berm {

/// Lame constants [Pa].
struct Lame {
  double lambda, mu;

  /// s = lambda tr(e) I + 2 mu e, e with engineering shear.
  Voigt stress(const Voigt& strain) const {
    const double p = lambda * (strain[XX] + strain[YY] + strain[ZZ]);
    Voigt s;
    s << p + 2.0 * mu * strain[XX], p + 2.0 * mu * strain[YY], p + 2.0 * mu * strain[ZZ], mu * strain[XY],
        mu * strain[YZ], mu * strain[ZX];
    return s;
  }

  /// C : t for a symmetric t in tensor components (shear not doubled).
  Voigt contract(const Voigt& t) const {
    const double p = lambda * (t[XX] + t[YY] + t[ZZ]);
    return Voigt(2.0 * mu * t + p * Voigt(1.0, 1.0, 1.0, 0.0, 0.0, 0.0));
  }

  double bulk() const { return lambda + 2.0 / 3.0 * mu; }

  /// factor * C as a Voigt matrix.
  void stiffness(double factor, Voigt66& c) const {
    const double l = factor * lambda, m = factor * mu;
    c.setZero();
    c.topLeftCorner<3, 3>().setConstant(l);
    for (int i = 0; i < 3; ++i) {
      c(i, i) += 2.0 * m;
      c(i + 3, i + 3) = m;
    }
  }
};

/// Parameters of an isotropic elastic solid.
struct IsotropicElastic {
  double youngs_modulus = 0.0;  ///< [Pa]
  double poisson_ratio = 0.0;   ///< [-]

  Lame lame() const {
    const double nu = poisson_ratio, f = youngs_modulus / ((1.0 + nu) * (1.0 - 2.0 * nu));
    return {f * nu, 0.5 * f * (1.0 - 2.0 * nu)};
  }

  double stiffness() const { return youngs_modulus; }

  /// Out-of-plane strain at which the elastic (effective) stress zz vanishes; plane_stress.hpp starts from it.
  double free_strain_zz(const Voigt& strain) const {
    return -poisson_ratio / (1.0 - poisson_ratio) * (strain[XX] + strain[YY]);
  }
};

/// The same for a solid that is not linear elastic to its end: plane stress has no closed form for it.
struct YieldingElastic : IsotropicElastic {
  double free_strain_zz(const Voigt&) const = delete;
};

/// The case keys of IsotropicElastic for the law L that derives from it.
template <class L>
std::vector<Parameter<L>> elastic_parameters() {
  return {{"youngs_modulus", &L::youngs_modulus, Unit::stress, positive(), {}, "Young's modulus"},
          {"poisson_ratio", &L::poisson_ratio, Unit::none, Range{-1.0, 0.5, true, true}, {}, "Poisson's ratio"}};
}

}  // namespace berm
