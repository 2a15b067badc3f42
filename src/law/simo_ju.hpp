#pragma once
/// Simo-Ju isotropic damage with exponential softening (Simo and Ju 1987; Oliver et al. 1990). docs/theory/damage.md.

#include "law/exponential_damage.hpp"
#include "law/principal.hpp"

namespace berm {

struct SimoJu : ExponentialDamage {
  double strength_ratio = 1.0;  ///< n = fc / ft [-]

  static constexpr std::string_view name = "simo_ju";
  static constexpr std::string_view doc =
      "Isotropic damage driven by the energy norm of the strain, weighted by the share of tension (Simo and Ju 1987, "
      "Oliver et al. 1990), crack-band exponential softening.";

  static std::vector<Parameter<SimoJu>> parameters() {
    auto p = exponential_damage_parameters<SimoJu>();
    p.push_back({"strength_ratio",
                 &SimoJu::strength_ratio,
                 Unit::none,
                 Range{1.0, infinity},
                 {},
                 "compressive over tensile strength, n = fc/ft"});
    return p;
  }

  double threshold() const { return tensile_strength / std::sqrt(youngs_modulus); }
  void initial_state(double* state) const { initial_damage_state(*this, state); }

  struct Scratch {
    double root;      // sqrt(e : s)
    double tension;   // sum <s_i>
    double absolute;  // sum |s_i|
    double weight;    // k = theta + (1 - theta) / n
    Voigt projector;  // sum of n_i n_i^T over s_i > 0
  };

  /// tau = k sqrt(e : s), eq. (20). As k <= 1, the energy norm alone tells most elastic points.
  double measure(const Voigt&, const Voigt& s, double two_y, double r_old, Scratch& w) const {
    if (two_y <= r_old * r_old) return r_old;
    const Principal axes(s);
    const Vec3 sign = axes.value.unaryExpr(&heaviside);
    w.tension = axes.value.dot(sign);
    w.absolute = 2.0 * w.tension - axes.value.sum();
    const double theta = w.tension / w.absolute;
    w.weight = theta + (1.0 - theta) / strength_ratio;
    w.root = std::sqrt(two_y);
    const double tau = w.weight * w.root;
    if (tau > r_old) w.projector = axes.assemble(sign);
    return tau;
  }

  /// eq. (22); the projector over positive principal stresses is the derivative of sum <s_i>, eq. (21).
  Voigt damage_gradient(const LawInput&, const Voigt& s, const Softened& now, const Scratch& w) const {
    Voigt theta = -(2.0 * w.tension - w.absolute) * w.projector;  // d theta / d s, times (sum |s_i|)^2
    theta.head<3>().array() += w.tension;
    const double f = (1.0 - 1.0 / strength_ratio) * w.root / (w.absolute * w.absolute);
    return now.slope * (w.weight / w.root * s + f * lame().contract(theta));
  }

  Softened soften(double r, double length, const double*) const {
    return exponential_softening(r, threshold(), softening_modulus(length));
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return update_isotropic_damage(*this, in, old_state, new_state, out);
  }
};

}  // namespace berm
