#pragma once
/// Parameters and softening common to the damage laws with crack-band exponential softening (docs/theory/damage.md).

#include <cmath>
#include <cstdio>
#include <string>

#include "law/isotropic_damage.hpp"

namespace berm {

/// 1/A + 1/2 is the ratio of fracture energy to elastic energy at the peak, eq. (6); not positive: no such softening.
inline double inverse_softening_modulus(double e, double ft, double gf, double length) {
  return e * gf / (length * ft * ft) - 0.5;
}

/// "" or why a crack-band length cannot carry the fracture energy, with both numbers and the remedy, eq. (7).
inline std::string check_crack_band(double e, double ft, double gf, double length) {
  if (inverse_softening_modulus(e, ft, gf, length) > 0.0 && length > 0.0) return {};
  char text[320];
  if (!(length > 0.0)) {
    std::snprintf(text, sizeof text, "the crack-band length must be positive, got %g m", length);
  } else {
    std::snprintf(
        text, sizeof text,
        "crack-band length %g m is not below 2 E Gf / ft^2 = %g m: the cell stores more elastic energy at the "
        "peak than the crack dissipates (use a smaller cell, a larger fracture_energy or a smaller "
        "tensile_strength)",
        length, 2.0 * e * gf / (ft * ft));
  }
  return text;
}

struct ExponentialDamage : IsotropicElastic {
  double tensile_strength = 0.0;  ///< ft [Pa]
  double fracture_energy = 0.0;   ///< Gf [J/m2]

  static constexpr int n_weights = 0;
  static constexpr int n_state = damage_state::first_weight;

  bool softens(double length) const {
    return inverse_softening_modulus(youngs_modulus, tensile_strength, fracture_energy, length) > 0.0;
  }
  double softening_modulus(double length) const {
    return 1.0 / inverse_softening_modulus(youngs_modulus, tensile_strength, fracture_energy, length);
  }
  std::string check(double length) const {
    return check_crack_band(youngs_modulus, tensile_strength, fracture_energy, length);
  }
};

/// The case keys of ExponentialDamage for the law L that derives from it.
template <class L>
std::vector<Parameter<L>> exponential_damage_parameters() {
  std::vector<Parameter<L>> p = elastic_parameters<L>();
  p.push_back({"tensile_strength", &L::tensile_strength, Unit::stress, positive(), {}, "uniaxial tensile strength ft"});
  p.push_back({"fracture_energy",
               &L::fracture_energy,
               Unit::energy_per_area,
               positive(),
               {},
               "mode I fracture energy Gf, regularised by the crack-band length"});
  return p;
}

}  // namespace berm
