#pragma once
/// Von Mises plasticity with linear isotropic hardening (Simo and Hughes 1998). docs/theory/plasticity.md.

#include <string>

#include "law/cone_return.hpp"

namespace berm {

struct VonMises : YieldingElastic {
  double yield_stress = 0.0;       ///< [Pa]
  double hardening_modulus = 0.0;  ///< [Pa]

  static constexpr std::string_view name = "von_mises";
  static constexpr std::string_view doc =
      "Von Mises plasticity with linear isotropic hardening, radial return (Simo and Hughes 1998): metals, soil "
      "without "
      "drainage.";
  static constexpr int n_state = 7;
  static constexpr int elastic_strain = 0;

  static std::vector<Parameter<VonMises>> parameters() {
    using L = VonMises;
    auto p = elastic_parameters<L>();
    p.push_back({"yield_stress", &L::yield_stress, Unit::stress, positive(), {}, "yield stress in uniaxial tension"});
    p.push_back({"hardening_modulus", &L::hardening_modulus, Unit::stress, non_negative(), 0.0,
                 "growth of the yield stress (Drucker-Prager: of the cohesion) with the accumulated plastic strain"});
    return p;
  }
  std::string check(double) const { return {}; }
  void initial_state(double* state) const { std::fill(state, state + n_state, 0.0); }

  /// Eq. (46).
  Cone cone() const {
    const double root = std::sqrt(3.0);
    return {0.0, 0.0, yield_stress / root, hardening_modulus / root};
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return update_cone(cone(), lame(), in, old_state, new_state, out);
  }
};

}  // namespace berm
