#pragma once
/// Isotropic damage driven by the largest principal effective stress (Rankine). docs/theory/damage.md.

#include "law/exponential_damage.hpp"
#include "law/principal.hpp"

namespace berm {

struct Rankine : ExponentialDamage {
  static constexpr std::string_view name = "rankine";
  static constexpr std::string_view doc =
      "Isotropic damage driven by the largest principal effective stress (Rankine), crack-band exponential softening; "
      "never fails in compression.";

  static std::vector<Parameter<Rankine>> parameters() { return exponential_damage_parameters<Rankine>(); }
  double threshold() const { return tensile_strength / std::sqrt(youngs_modulus); }
  void initial_state(double* state) const { initial_damage_state(*this, state); }

  struct Scratch {
    Voigt projector;  // n n^T of the largest principal stress
  };

  /// tau = <s_1> / sqrt(E), eq. (23). The norm of s bounds s_1.
  double measure(const Voigt&, const Voigt& s, double, double r_old, Scratch& w) const {
    const double limit = r_old * r_old * youngs_modulus;
    if (s.head<3>().squaredNorm() + 2.0 * s.tail<3>().squaredNorm() <= limit) return r_old;
    const Principal axes(s);
    int largest;
    const double s1 = axes.value.maxCoeff(&largest);
    if (!(s1 > 0.0) || s1 * s1 <= limit) return r_old;
    w.projector = axes.assemble(Vec3::Unit(largest));
    return s1 / std::sqrt(youngs_modulus);
  }

  /// eq. (24). Where two principal stresses tie, tau has a corner and one of the two gradients is taken.
  Voigt damage_gradient(const LawInput&, const Voigt&, const Softened& now, const Scratch& w) const {
    return now.slope / std::sqrt(youngs_modulus) * lame().contract(w.projector);
  }

  Softened soften(double r, double length, const double*) const {
    return exponential_softening(r, threshold(), softening_modulus(length));
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return update_isotropic_damage(*this, in, old_state, new_state, out);
  }
};

}  // namespace berm
