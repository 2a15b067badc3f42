#pragma once
/// Return to a circular cone or cylinder in stress space with linear hardening, in closed form: Drucker-Prager, von
/// Mises. docs/theory/plasticity.md, section "Cones".

#include "law/invariants.hpp"

namespace berm {

/// q/sqrt(3) + friction p <= strength + hardening kappa; flow along the gradient of q/sqrt(3) + dilatancy p, eq. (40).
struct Cone {
  double friction = 0.0;
  double dilatancy = 0.0;
  double strength = 0.0;   ///< [Pa]
  double hardening = 0.0;  ///< [Pa]
};

/// State after the step in (p, q), and the derivatives of both by the trial (e_v, e_s).
struct ConeReturn {
  bool plastic = false;
  bool apex = false;
  double p = 0.0, q_per_shear = 0.0, kappa = 0.0;
  Mat2 d = Mat2::Zero();
};

/// Side of the cone, eqs. (41)-(43). False if it would have to pass the apex.
inline bool return_to_side(const Cone& y, const Lame& c, const StrainInvariants& e, double excess, ConeReturn& r) {
  const double root = std::sqrt(3.0), k = c.bulk();
  const double kappa_rate = std::sqrt(1.0 / 3.0 + 2.0 / 9.0 * y.dilatancy * y.dilatancy);
  const double modulus = c.mu + k * y.friction * y.dilatancy + y.hardening * kappa_rate;
  const double multiplier = excess / modulus;
  const double share = 1.0 - multiplier / (root * e.shear);
  if (!(share >= 0.0)) return false;
  r.p = k * (e.volume - y.dilatancy * multiplier);
  r.q_per_shear = 3.0 * c.mu * share;
  r.kappa += kappa_rate * multiplier;
  const Vec2 rate = Vec2(k * y.friction, root * c.mu) / modulus;  // of the multiplier
  r.d << k * (1.0 - y.dilatancy * rate[0]), -k * y.dilatancy * rate[1], -root * c.mu * rate[0],
      3.0 * c.mu - root * c.mu * rate[1];
  return true;
}

/// Apex: q = 0, p = (strength + hardening kappa)/friction, with all of the trial deviator plastic; eqs. (44) and (45).
/// Newton's method for the plastic volume is monotone from above, as the equation is concave and falls.
inline void return_to_apex(const Cone& y, const Lame& c, const StrainInvariants& e, ConeReturn& r) {
  const double k = c.bulk(), h = y.hardening / y.friction, old = r.kappa;
  const auto amount = [&](double x) { return std::sqrt(e.shear * e.shear + 2.0 / 9.0 * x * x); };
  const double tip = (y.strength + y.hardening * old) / y.friction;
  double x = e.volume - tip / k, slope = k;
  double measure = amount(x);
  for (int i = 0; i < 50 && h > 0.0; ++i) {
    slope = k + (measure > 0.0 ? h * 2.0 / 9.0 * x / measure : 0.0);
    const double step = (k * (e.volume - x) - tip - h * measure) / slope;
    x += step;
    measure = amount(x);
    if (std::abs(step) <= 1e-15 * std::abs(x)) break;
  }
  r.apex = true;
  r.kappa = old + measure;
  r.p = tip + h * measure;
  r.q_per_shear = 0.0;
  if (measure > 0.0) {
    const double by_x = h * 2.0 / 9.0 * x / measure, by_shear = h * e.shear / measure;
    r.d(0, 0) = k * by_x / (k + by_x);
    r.d(0, 1) = k * by_shear / (k + by_x);
  }
}

/// kappa: accumulated plastic strain before the step.
inline ConeReturn return_to_cone(const Cone& y, const Lame& c, const StrainInvariants& e, double kappa) {
  ConeReturn r;
  r.kappa = kappa;
  const double side = std::sqrt(3.0) * c.mu * e.shear, p = c.bulk() * e.volume;
  const double excess = side + y.friction * p - (y.strength + y.hardening * kappa);
  const double rounding = 2e-14 * ((3.0 * c.mu + 3.0 * c.bulk()) * e.shear + std::abs(p));
  r.plastic = excess > rounding;
  if (r.plastic && !return_to_side(y, c, e, excess, r)) return_to_apex(y, c, e, r);
  return r;
}

/// Share of the elastic stiffness in the tangent of a point at the apex, where the true one is zero; see
/// mohr_coulomb.hpp.
constexpr double cone_residual_stiffness = 1e-5;

/// Law::update of a law with such a surface and linear elasticity. State: elastic strain, accumulated plastic strain.
inline Status update_cone(const Cone& y, const Lame& c, const LawInput& in, const double* old_state, double* new_state,
                          LawOutput& out) {
  if (!in.strain.allFinite()) return Status::not_admissible;
  const StrainInvariants e(in.strain);
  const ConeReturn r = return_to_cone(y, c, e, old_state[6]);
  new_state[6] = out.plastic_strain = r.kappa;
  if (!r.plastic) {
    elastic_step(c, in, new_state, out);
  } else {
    plastic_step(c, in, e.strain(r.p / c.bulk(), r.q_per_shear / (3.0 * c.mu)), new_state, out);
    if (in.want_tangent) {
      invariant_tangent(e, r.q_per_shear, r.d, out.tangent);
      if (r.apex) {
        Voigt66 residual;
        c.stiffness(cone_residual_stiffness, residual);
        out.tangent += residual;
      }
    }
  }
  return std::isfinite(out.stored_energy) ? Status::ok : Status::not_admissible;
}

}  // namespace berm
