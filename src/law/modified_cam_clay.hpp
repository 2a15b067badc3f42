#pragma once
/// Modified Cam-Clay at finite strain (Roscoe and Burland 1968; Borja and Tamagnini 1998). docs/theory/plasticity.md.

#include <Eigen/LU>
#include <cmath>
#include <string>

#include "law/bracketed_newton.hpp"
#include "law/invariants.hpp"

namespace berm {

struct ModifiedCamClay {
  double lambda_star = 0.0;                ///< [-]
  double kappa_star = 0.0;                 ///< [-]
  double shear_modulus = 0.0;              ///< [Pa]
  double critical_state_slope = 0.0;       ///< [-]
  double preconsolidation_pressure = 0.0;  ///< at the start [Pa]
  double reference_pressure = 0.0;         ///< at zero elastic strain, where a point starts [Pa]

  static constexpr std::string_view name = "modified_cam_clay";
  static constexpr std::string_view doc =
      "Modified Cam-Clay in logarithmic strain (Borja and Tamagnini 1998): soft clay; hyperelastic with a constant "
      "shear "
      "modulus. A point starts at the reference pressure and carries no tension.";
  static constexpr int n_state = 8;
  static constexpr int elastic_strain = 0;
  static constexpr bool no_plane_stress = true;
  enum State { preconsolidation = 6, accumulated = 7 };

  static std::vector<Parameter<ModifiedCamClay>> parameters() {
    using L = ModifiedCamClay;
    return {{"lambda_star",
             &L::lambda_star,
             Unit::none,
             Range{0.0, 1.0, true, false},
             {},
             "slope of the virgin compression line, ln(volume) over ln(pressure)"},
            {"kappa_star",
             &L::kappa_star,
             Unit::none,
             Range{0.0, 0.5, true, false},
             {},
             "slope of the unloading line, ln(volume) over ln(pressure)"},
            {"shear_modulus", &L::shear_modulus, Unit::stress, positive(), {}, "elastic, constant"},
            {"critical_state_slope",
             &L::critical_state_slope,
             Unit::none,
             Range{0.0, 3.0, true, true},
             {},
             "M = q/p at the critical state; 6 sin(phi)/(3 - sin(phi)) in triaxial compression"},
            {"preconsolidation_pressure",
             &L::preconsolidation_pressure,
             Unit::stress,
             positive(),
             {},
             "largest pressure that the soil has carried"},
            {"reference_pressure",
             &L::reference_pressure,
             Unit::stress,
             positive(),
             {},
             "pressure at which a point starts, with zero elastic strain"}};
  }

  std::string check(double) const {
    if (lambda_star <= kappa_star) return "lambda_star must be larger than kappa_star";
    if (preconsolidation_pressure < reference_pressure)
      return "preconsolidation_pressure is smaller than reference_pressure: the soil could not be at rest";
    return {};
  }

  void initial_state(double* state) const {
    std::fill(state, state + n_state, 0.0);
    state[preconsolidation] = preconsolidation_pressure;
  }

  /// Young's modulus at the reference pressure.
  double stiffness() const {
    const double k = reference_pressure / kappa_star;
    return 9.0 * k * shear_modulus / (3.0 * k + shear_modulus);
  }

  /// Eq. (55); compression positive.
  double pressure(double elastic_volume) const { return reference_pressure * std::exp(-elastic_volume / kappa_star); }

  /// What a step returns to, and the trial state it came from.
  struct Returned {
    bool plastic = false;
    double volume = 0.0;      ///< elastic
    double share = 1.0;       ///< of the trial deviator that stays elastic
    double multiplier = 0.0;  ///< [1/Pa]
    double preconsolidation = 0.0;
  };

  /// Residuals of the return, eqs. (60) and (61), and their derivatives by (volume, multiplier).
  struct Residuals {
    Vec2 value;
    Mat2 slope;
  };

  Residuals residuals(const StrainInvariants& e, double old_pc, double volume, double multiplier) const {
    const double m2 = critical_state_slope * critical_state_slope, width = lambda_star - kappa_star;
    const double p = pressure(volume), pc = old_pc * std::exp((volume - e.volume) / width);
    const double softness = 6.0 * shear_modulus / m2, share = 1.0 / (1.0 + softness * multiplier);
    const double q = 3.0 * shear_modulus * share * e.shear, shear_part = q * q / (m2 * p), sum = p + shear_part;
    Residuals r;
    r.value << volume - e.volume - multiplier * (2.0 * p - pc), std::log(sum / pc);
    r.slope << 1.0 + multiplier * (2.0 * p / kappa_star + pc / width), -(2.0 * p - pc),
        -(p - shear_part) / (kappa_star * sum) - 1.0 / width, -2.0 * shear_part / sum * softness * share;
    return r;
  }

  /// Elastic volume at a multiplier: eq. (60) rises with the volume, and its root lies between the trial volume and the
  /// one of the critical state.
  double volume_at(const StrainInvariants& e, double old_pc, double multiplier, double guess) const {
    const double width = lambda_star - kappa_star;
    const double critical =
        (std::log(2.0 * reference_pressure / old_pc) + e.volume / width) / (1.0 / kappa_star + 1.0 / width);
    const auto balance = [&](double x) {
      const Residuals r = residuals(e, old_pc, x, multiplier);
      return Sample{r.value[0], r.slope(0, 0)};
    };
    return bracketed_newton(balance, e.volume, critical, guess);
  }

  /// Eq. (61) as a function of the multiplier alone, positive at 0 and negative for large ones.
  Returned return_map(const StrainInvariants& e, double old_pc) const {
    Returned r;
    r.volume = e.volume;
    r.preconsolidation = old_pc;
    const double rounding = 2e-14 * (10.0 + (std::abs(e.volume) + e.shear) / kappa_star);
    if (residuals(e, old_pc, e.volume, 0.0).value[1] <= rounding) return r;
    const auto yield = [&](double x) {
      r.volume = volume_at(e, old_pc, x, r.volume);
      const Residuals now = residuals(e, old_pc, r.volume, x);
      return Sample{now.value[1], now.slope(1, 1) - now.slope(1, 0) * now.slope(0, 1) / now.slope(0, 0)};
    };
    const double m2 = critical_state_slope * critical_state_slope;
    double low = 0.0, high = 1e-3 * std::min(m2 / (6.0 * shear_modulus), kappa_star / old_pc);
    for (int i = 0; i < 200 && yield(high).value > 0.0; ++i) low = high, high *= 4.0;
    r.plastic = true;
    r.multiplier = bracketed_newton(yield, low, high, 0.5 * (low + high));
    r.volume = volume_at(e, old_pc, r.multiplier, r.volume);
    r.share = 1.0 / (1.0 + 6.0 * shear_modulus / m2 * r.multiplier);
    r.preconsolidation = old_pc * std::exp((r.volume - e.volume) / (lambda_star - kappa_star));
    return r;
  }

  /// Derivatives of (p, q) by the trial (e_v, e_s), eqs. (62) and (63); p = -pressure.
  Mat2 tangent(const StrainInvariants& e, double old_pc, const Returned& r) const {
    const double mu = shear_modulus, p = pressure(r.volume), q = 3.0 * mu * r.share * e.shear;
    Mat2 d;
    if (!r.plastic) {
      d << p / kappa_star, 0.0, 0.0, 3.0 * mu;
      return d;
    }
    const double m2 = critical_state_slope * critical_state_slope, width = lambda_star - kappa_star;
    Mat2 by_trial;  // of the residuals
    by_trial << -1.0 - r.multiplier * r.preconsolidation / width, 0.0, 1.0 / width,
        2.0 * q / (m2 * p * (p + q * q / (m2 * p))) * 3.0 * mu * r.share;
    const Mat2 unknowns = -residuals(e, old_pc, r.volume, r.multiplier).slope.inverse() * by_trial;
    d.row(0) = p / kappa_star * unknowns.row(0);
    d.row(1) = -q * 6.0 * mu / m2 * r.share * unknowns.row(1);
    d(1, 1) += 3.0 * mu * r.share;
    return d;
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    if (!in.strain.allFinite()) return Status::not_admissible;
    const StrainInvariants trial(in.strain);
    const double old_pc = old_state[preconsolidation];
    const double far = 300.0 * kappa_star;  // e^300 times the reference pressure: beyond, numbers run out
    if (std::abs(trial.volume) > far) return Status::not_admissible;
    const Returned r = return_map(trial, old_pc);
    const Voigt elastic = r.plastic ? trial.strain(r.volume, r.share) : in.strain;
    // From the strain that is stored, so that the next step starts from this very stress.
    const StrainInvariants e(elastic);
    const double p = pressure(e.volume);
    out.stress = 2.0 * shear_modulus * e.deviator;
    out.stress.head<3>().array() -= p;
    out.stored_energy = kappa_star * (p - reference_pressure) + 1.5 * shear_modulus * e.shear * e.shear;
    out.damage = out.extrapolation_error = 0.0;
    out.dissipated = r.plastic ? out.stress.dot(in.strain - elastic) : 0.0;
    const StrainInvariants flow(in.strain - elastic);
    out.plastic_strain = old_state[accumulated];
    if (r.plastic) out.plastic_strain += std::sqrt(flow.shear * flow.shear + 2.0 / 9.0 * flow.volume * flow.volume);
    std::copy(elastic.begin(), elastic.end(), new_state);
    new_state[preconsolidation] = r.preconsolidation;
    new_state[accumulated] = out.plastic_strain;
    if (in.want_tangent)
      invariant_tangent(trial, 3.0 * shear_modulus * r.share, tangent(trial, old_pc, r), out.tangent);
    return std::isfinite(out.stored_energy) ? Status::ok : Status::not_admissible;
  }
};

}  // namespace berm
