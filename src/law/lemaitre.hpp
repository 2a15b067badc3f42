#pragma once
/// Lemaitre's isotropic damage with two norms of the strain as measure. docs/theory/damage.md.

#include "law/exponential_damage.hpp"
#include "law/principal.hpp"

namespace berm {

/// Equivalent strain sqrt(e : e), eq. (25).
struct LemaitreStrain : ExponentialDamage {
  static constexpr std::string_view name = "lemaitre_strain";
  static constexpr std::string_view doc =
      "Isotropic damage driven by the norm of the strain, sqrt(e:e) (Lemaitre 1992), crack-band exponential softening; "
      "as weak in compression as in tension.";

  static std::vector<Parameter<LemaitreStrain>> parameters() { return exponential_damage_parameters<LemaitreStrain>(); }
  /// Norm of the strain of uniaxial tension ft, so that the onset is ft.
  double threshold() const {
    return tensile_strength / youngs_modulus * std::sqrt(1.0 + 2.0 * poisson_ratio * poisson_ratio);
  }
  void initial_state(double* state) const { initial_damage_state(*this, state); }

  struct Scratch {
    double norm;
  };

  double measure(const Voigt& strain, const Voigt&, double, double, Scratch& w) const {
    w.norm = std::sqrt(strain.head<3>().squaredNorm() + 0.5 * strain.tail<3>().squaredNorm());
    return w.norm;
  }

  Voigt damage_gradient(const LawInput& in, const Voigt&, const Softened& now, const Scratch& w) const {
    return now.slope / w.norm * tensor_components(in.strain);
  }

  Softened soften(double r, double length, const double*) const {
    return exponential_softening(r, threshold(), softening_modulus(length));
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return update_isotropic_damage(*this, in, old_state, new_state, out);
  }
};

/// Equivalent strain sqrt(e : C : e), eq. (26).
struct LemaitreEnergy : ExponentialDamage {
  static constexpr std::string_view name = "lemaitre_energy";
  static constexpr std::string_view doc =
      "Isotropic damage driven by the energy norm of the strain, sqrt(e:C:e) (Lemaitre 1992), crack-band exponential "
      "softening; as weak in compression as in tension.";

  static std::vector<Parameter<LemaitreEnergy>> parameters() { return exponential_damage_parameters<LemaitreEnergy>(); }
  double threshold() const { return tensile_strength / std::sqrt(youngs_modulus); }
  void initial_state(double* state) const { initial_damage_state(*this, state); }

  struct Scratch {
    double norm;
  };

  double measure(const Voigt&, const Voigt&, double two_y, double, Scratch& w) const {
    w.norm = std::sqrt(two_y);
    return w.norm;
  }

  Voigt damage_gradient(const LawInput&, const Voigt& s, const Softened& now, const Scratch& w) const {
    return now.slope / w.norm * s;
  }

  Softened soften(double r, double length, const double*) const {
    return exponential_softening(r, threshold(), softening_modulus(length));
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return update_isotropic_damage(*this, in, old_state, new_state, out);
  }
};

}  // namespace berm
