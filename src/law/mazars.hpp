#pragma once
/// Mazars's isotropic damage with one equivalent strain and two softening branches. docs/theory/damage.md.

#include <cmath>
#include <string>

#include "law/exponential_damage.hpp"
#include "law/principal.hpp"

namespace berm {

/// Shares of tension and compression in the equivalent strain, before the power beta, with their gradients in principal
/// strains, eqs. (29)-(31).
struct MazarsShares {
  double tension = 0.0, compression = 0.0;
  Vec3 d_tension = Vec3::Zero(), d_compression = Vec3::Zero();
};

inline MazarsShares mazars_shares(const Vec3& e, const IsotropicElastic& solid) {
  const auto [lambda, mu] = solid.lame();
  const double nu = solid.poisson_ratio, young = solid.youngs_modulus;
  const Vec3 s = (2.0 * mu * e).array() + lambda * e.sum();
  const Vec3 tensile = s.unaryExpr(&heaviside);
  const double sum = s.dot(tensile), count = tensile.sum();
  MazarsShares share;
  for (int i = 0; i < 3; ++i) {
    if (!(e[i] > 0.0)) continue;
    const double et = ((1.0 + nu) * tensile[i] * s[i] - nu * sum) / young, ec = e[i] - et;
    // d et / d e_j = own * delta_ij + common_j
    const double own = (1.0 + nu) * tensile[i] * 2.0 * mu / young;
    const Vec3 common =
        (((1.0 + nu) * tensile[i] - nu * count) * lambda - (2.0 * nu * mu * tensile).array()).matrix() / young;
    if (et > 0.0) {
      share.tension += et * e[i];
      share.d_tension += e[i] * common;
      share.d_tension[i] += e[i] * own + et;
    }
    if (ec > 0.0) {
      share.compression += ec * e[i];
      share.d_compression -= e[i] * common;
      share.d_compression[i] += e[i] * (1.0 - own) + ec;
    }
  }
  return share;
}

/// One classical branch, eq. (33).
inline Softened mazars_branch(double kappa, double kappa0, double a, double b) {
  const double e = a * std::exp(-b * (kappa - kappa0)), h = kappa0 * (1.0 - a) / kappa;
  return {1.0 - h - e, h / kappa + b * e};
}

/// Everything but the tension branch, which `Derived` gives: Softened tension(kappa, length).
template <class Derived>
struct MazarsBase : IsotropicElastic {
  double tensile_strength = 0.0;  ///< ft [Pa]; 0: kappa0 is given
  double kappa0 = 0.0;            ///< strain at the onset of damage [-]; 0: ft / E
  double compression_a = 0.0;     ///< Ac [-]
  double compression_b = 0.0;     ///< Bc [-]
  double beta = 1.0;              ///< power of the weights [-]

  static constexpr int n_weights = 2;
  static constexpr int n_state = damage_state::first_weight + n_weights;

  double threshold() const { return kappa0 > 0.0 ? kappa0 : tensile_strength / youngs_modulus; }
  void initial_state(double* state) const { initial_damage_state(derived(), state); }

  struct Scratch {
    Principal axes;  // of the strain
    double measure;
    MazarsShares share;
  };

  /// sqrt(sum <e_i>^2), eq. (28); the norm of the strain bounds it.
  double measure(const Voigt& strain, const Voigt&, double, double r_old, Scratch& w) const {
    if (strain.head<3>().squaredNorm() + 0.5 * strain.tail<3>().squaredNorm() <= r_old * r_old) return r_old;
    w.axes = Principal(tensor_components(strain));
    w.measure = w.axes.value.unaryExpr(&positive_part).norm();
    return w.measure;
  }

  /// alpha_t, alpha_c of eq. (31).
  void weights(Scratch& w, double* alpha) const {
    w.share = mazars_shares(w.axes.value, *this);
    const double q = w.measure * w.measure;
    alpha[0] = power(w.share.tension / q, beta);
    alpha[1] = power(w.share.compression / q, beta);
  }

  /// eq. (32). The slope is that at constant weights.
  Softened soften(double kappa, double length, const double* alpha) const {
    const Softened t = derived().tension(kappa, length), c = compression(kappa);
    const double d = alpha[0] * t.damage + alpha[1] * c.damage;
    if (d >= max_damage) return {max_damage, 0.0};
    return {d, alpha[0] * t.slope + alpha[1] * c.slope};
  }

  /// eq. (34): kappa and the weights vary with the strain.
  Voigt damage_gradient(const LawInput& in, const Voigt&, const Softened& now, const Scratch& w) const {
    if (now.damage >= max_damage) return Voigt::Zero();
    const double kappa = w.measure;
    const Vec3 d_kappa = w.axes.value.unaryExpr(&positive_part) / kappa;
    const Vec3 f =
        now.slope * d_kappa +
        derived().tension(kappa, in.length).damage * d_weight(w.share.tension, w.share.d_tension, kappa, d_kappa) +
        compression(kappa).damage * d_weight(w.share.compression, w.share.d_compression, kappa, d_kappa);
    return w.axes.assemble(f);
  }

  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return update_isotropic_damage(derived(), in, old_state, new_state, out);
  }

protected:
  Softened compression(double kappa) const { return mazars_branch(kappa, threshold(), compression_a, compression_b); }

  std::string check_threshold() const {
    if ((tensile_strength > 0.0) != (kappa0 > 0.0)) return {};
    return "give one of tensile_strength and kappa0 (kappa0 = ft/E)";
  }

  static std::vector<Parameter<Derived>> common_parameters() {
    auto p = elastic_parameters<Derived>();
    p.push_back({"tensile_strength", &Derived::tensile_strength, Unit::stress, non_negative(), 0.0,
                 "uniaxial strength at the onset of damage in tension, ft = E kappa0; or give kappa0"});
    p.push_back({"kappa0", &Derived::kappa0, Unit::none, non_negative(), 0.0,
                 "equivalent strain at the onset of damage; or give tensile_strength"});
    p.push_back({"compression_a", &Derived::compression_a, Unit::none, positive(), {}, "Ac of the compression branch"});
    p.push_back({"compression_b",
                 &Derived::compression_b,
                 Unit::none,
                 positive(),
                 {},
                 "Bc of the compression branch; uniaxial peak at strain 1/(sqrt(2) nu Bc)"});
    p.push_back(
        {"beta", &Derived::beta, Unit::none, Range{1.0, infinity}, 1.0, "power of the tension/compression weights"});
    return p;
  }

private:
  const Derived& derived() const { return static_cast<const Derived&>(*this); }

  static double power(double x, double exponent) { return exponent == 1.0 ? x : std::pow(x, exponent); }

  /// d (share / kappa^2)^beta in principal strains.
  Vec3 d_weight(double share, const Vec3& d_share, double kappa, const Vec3& d_kappa) const {
    const double q = kappa * kappa;
    return beta * power(share / q, beta - 1.0) / q * (d_share - 2.0 * share / kappa * d_kappa);
  }
};

/// Crack-band exponential tension branch: dissipates Gf per area in uniaxial tension.
struct Mazars : MazarsBase<Mazars> {
  double fracture_energy = 0.0;  ///< Gf [J/m2]

  static constexpr std::string_view name = "mazars";
  static constexpr std::string_view doc =
      "Mazars's isotropic damage (1984) with separate evolution in tension and compression; the tension branch is the "
      "crack-band exponential one, compression is not regularised.";

  static std::vector<Parameter<Mazars>> parameters() {
    auto p = common_parameters();
    p.push_back({"fracture_energy",
                 &Mazars::fracture_energy,
                 Unit::energy_per_area,
                 positive(),
                 {},
                 "mode I fracture energy Gf, regularised by the crack-band length"});
    return p;
  }
  double strength() const { return youngs_modulus * threshold(); }
  bool softens(double length) const {
    return inverse_softening_modulus(youngs_modulus, strength(), fracture_energy, length) > 0.0;
  }
  std::string check(double length) const {
    const std::string why = check_threshold();
    return why.empty() ? check_crack_band(youngs_modulus, strength(), fracture_energy, length) : why;
  }
  Softened tension(double kappa, double length) const {
    const double a = 1.0 / inverse_softening_modulus(youngs_modulus, strength(), fracture_energy, length);
    return exponential_softening(kappa, threshold(), a);
  }
};

/// Mazars's own tension branch: no fracture energy, the result depends on the mesh.
struct MazarsClassic : MazarsBase<MazarsClassic> {
  double tension_a = 0.0;  ///< At [-]
  double tension_b = 0.0;  ///< Bt [-]

  static constexpr std::string_view name = "mazars_classic";
  static constexpr std::string_view doc =
      "Mazars's isotropic damage (1984) with his own tension branch (At, Bt): not regularised, for single points and "
      "comparisons.";

  static std::vector<Parameter<MazarsClassic>> parameters() {
    auto p = common_parameters();
    p.push_back({"tension_a", &MazarsClassic::tension_a, Unit::none, positive(), {}, "At of the tension branch"});
    p.push_back({"tension_b", &MazarsClassic::tension_b, Unit::none, positive(), {}, "Bt of the tension branch"});
    return p;
  }
  bool softens(double) const { return true; }
  std::string check(double) const { return check_threshold(); }
  Softened tension(double kappa, double) const { return mazars_branch(kappa, threshold(), tension_a, tension_b); }
};

}  // namespace berm
