#pragma once
/// Drucker-Prager plasticity (Drucker and Prager 1952), matched to Mohr-Coulomb in plane strain.
/// docs/theory/plasticity.md.

#include <numbers>
#include <string>

#include "law/cone_return.hpp"

namespace berm {

struct DruckerPrager : YieldingElastic {
  double cohesion = 0.0;           ///< [Pa]
  double friction_angle = 0.0;     ///< [rad]
  double dilatancy_angle = 0.0;    ///< [rad]
  double hardening_modulus = 0.0;  ///< of the cohesion [Pa]

  static constexpr std::string_view name = "drucker_prager";
  static constexpr std::string_view doc =
      "Drucker-Prager plasticity (1952): a circular cone that fails at the load of the Mohr-Coulomb law with the same "
      "angles in plane strain; no cap, no tension cut-off.";
  static constexpr int n_state = 7;
  static constexpr int elastic_strain = 0;
  static constexpr double residual_stiffness = cone_residual_stiffness;

  static std::vector<Parameter<DruckerPrager>> parameters() {
    using L = DruckerPrager;
    const Range angle{0.0, 0.5 * std::numbers::pi, false, true};
    auto p = elastic_parameters<L>();
    p.push_back({"cohesion", &L::cohesion, Unit::stress, non_negative(), {}, "cohesion"});
    p.push_back({"friction_angle",
                 &L::friction_angle,
                 Unit::angle,
                 angle,
                 {},
                 "angle of internal friction in plane strain; 0: von Mises"});
    p.push_back({"dilatancy_angle", &L::dilatancy_angle, Unit::angle, angle, 0.0, "at most the friction angle"});
    p.push_back({"hardening_modulus", &L::hardening_modulus, Unit::stress, non_negative(), 0.0,
                 "growth of the yield stress (Drucker-Prager: of the cohesion) with the accumulated plastic strain"});
    return p;
  }

  std::string check(double) const {
    if (dilatancy_angle > friction_angle) return "dilatancy_angle is larger than friction_angle";
    if (cohesion == 0.0 && friction_angle == 0.0)
      return "cohesion and friction_angle are both zero: no strength at all";
    return {};
  }

  void initial_state(double* state) const { std::fill(state, state + n_state, 0.0); }

  /// Eqs. (48) and (49).
  Cone cone() const {
    const double sin_phi = std::sin(friction_angle), cos_phi = std::cos(friction_angle);
    const double sin_psi = std::sin(dilatancy_angle), b = sin_psi / std::sqrt(1.0 + sin_psi * sin_psi / 3.0);
    const double f = 1.0 / (std::sqrt(1.0 - b * b / 3.0) + b * sin_phi / 3.0);
    return {f * sin_phi, b, f * cohesion * cos_phi, f * hardening_modulus * cos_phi};
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return update_cone(cone(), lame(), in, old_state, new_state, out);
  }
};

}  // namespace berm
