#pragma once
/// The driver of every isotropic damage law sigma = (1 - d) C : e (docs/theory/damage.md; equation numbers refer to
/// it). A law supplies its measure of strain, the gradient of the measure, and its softening function; the driver does
/// the three integrations, the energies and the state.

#include <algorithm>
#include <cmath>

#include "law/elasticity.hpp"
#include "law/law.hpp"

namespace berm {

/// No point breaks altogether: a residual stiffness of 1e-5 keeps the tangent regular, eq. (5).
constexpr double max_damage = 1.0 - 1e-5;

/// Layout of a damage point's state. Weights of composite damage (Mazars) follow at `first_weight`.
namespace damage_state {
enum Index {
  r = 0,             ///< largest measure reached, eq. (2)
  rate = 1,          ///< growth of r per unit of step-control time in the last step, eq. (11)
  damage = 2,        ///< damage at r
  used = 3,          ///< damage in the stress; equals `damage` with implicit integration
  energy = 4,        ///< Y = e : C : e / 2 [J/m3]
  first_weight = 5,  ///< number of the above
};
}

/// Damage and its slope d(damage)/dr.
struct Softened {
  double damage = 0.0;
  double slope = 0.0;
};

/// Exponential softening, eq. (4), cut off at max_damage, eq. (5).
inline Softened exponential_softening(double r, double r0, double a) {
  const double remaining = r0 / r * std::exp(a * (1.0 - r / r0));
  if (remaining <= 1.0 - max_damage) return {max_damage, 0.0};
  return {1.0 - remaining, remaining * (1.0 / r + a / r0)};
}

/// What the driver asks of a law besides the interface of law.hpp:
///   static constexpr int n_weights;  number of weights in the state
///   Scratch                          what `measure` hands on to the two below
///   double threshold() const;
///   bool softens(length) const;      false: no softening modulus exists for that length
///   double measure(strain, s, two_y, r_old, Scratch&) const;  may return r_old as soon as a bound shows measure <=
///   r_old Softened soften(r, length, const double* weights) const; Voigt damage_gradient(const LawInput&, s, Softened,
///   const Scratch&) const;  d damage / d strain, stress-like
/// and with n_weights > 0: void weights(Scratch&, double* weights) const.
template <class L>
void initial_damage_state(const L& law, double* state) {
  std::fill(state, state + L::n_state, 0.0);
  state[damage_state::r] = law.threshold();
}

/// Damage that enters the stress with the explicit integrations: eq. (11) for impl_ex, the old one for lagged.
template <class L>
double explicit_damage(const L& law, const LawInput& in, const double* old_state) {
  using namespace damage_state;
  const double grown = in.integration == Integration::impl_ex ? old_state[rate] * in.dt : 0.0;
  if (!(grown > 0.0)) return old_state[damage];
  const double d = law.soften(old_state[r] + grown, in.length, old_state + first_weight).damage;
  return std::max(d, old_state[damage]);
}

/// Energies of the step, eqs. (13) and (14), with the damage that the stress was computed with.
inline void set_energies(double y, double used, const double* old_state, LawOutput& out) {
  using namespace damage_state;
  out.stored_energy = (1.0 - used) * y;
  out.dissipated = 0.5 * (old_state[energy] + y) * (used - old_state[damage_state::used]);
}

/// The update of law.hpp for an isotropic damage law. Status not_admissible: the strain is not finite, or the point
/// would soften with a crack-band length that `check` refuses.
template <class L>
Status update_isotropic_damage(const L& law, const LawInput& in, const double* old_state, double* new_state,
                               LawOutput& out) {
  using namespace damage_state;
  const Lame c = law.lame();
  const Voigt s = c.stress(in.strain);
  const double two_y = in.strain.dot(s);
  if (!std::isfinite(two_y)) return Status::not_admissible;

  typename L::Scratch scratch;
  const double r_old = old_state[r];
  const double r_new = law.measure(in.strain, s, two_y, r_old, scratch);
  const bool loading = r_new > r_old;
  if (loading && !law.softens(in.length)) return Status::not_admissible;

  for (int i = first_weight; i < L::n_state; ++i) new_state[i] = old_state[i];
  Softened now{old_state[damage], 0.0};
  if (loading) {
    if constexpr (L::n_weights > 0) law.weights(scratch, new_state + first_weight);
    now = law.soften(r_new, in.length, new_state + first_weight);
  }
  const bool grows = loading && now.damage > old_state[damage];
  const double d = grows ? now.damage : old_state[damage];
  const double d_used = in.integration == Integration::implicit ? d : explicit_damage(law, in, old_state);

  out.stress = (1.0 - d_used) * s;
  out.damage = d;
  out.extrapolation_error = std::abs(d_used - d) * r_new / law.threshold();  // eq. (11a)
  set_energies(0.5 * two_y, d_used, old_state, out);
  if (in.want_tangent) {
    c.stiffness(1.0 - d_used, out.tangent);
    if (grows && in.integration == Integration::implicit) {  // eq. (10)
      out.tangent.noalias() -= s * law.damage_gradient(in, s, now, scratch).transpose();
    }
  }

  if (in.dt > 0.0)
    new_state[rate] = loading ? (r_new - r_old) / in.dt : 0.0;
  else
    new_state[rate] = old_state[rate];
  new_state[r] = loading ? r_new : r_old;
  new_state[damage] = d;
  new_state[used] = d_used;
  new_state[energy] = 0.5 * two_y;
  return Status::ok;
}

}  // namespace berm
