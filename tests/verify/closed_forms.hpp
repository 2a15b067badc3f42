#pragma once
/// The laws' answers in principal axes, written again from docs/theory/damage.md (equation numbers) and not from the
/// code: stresses of a point along a path of growing principal strains.

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

namespace berm::verify {

using Triple = std::array<double, 3>;

/// The concrete of the tables (damage.md, end of section 2; Mazars's set is the fit of section 6).
struct Concrete {
  double E = 35.5e9, nu = 0.2, ft = 3.05e6, n = 12.3, Gf = 100.0;
  double Ac = 1.20402, Bc = 1607.06, At = 0.8, Bt = 17000.0;
  double kappa0() const { return ft / E; }
  /// eq. (6)
  double A(double l) const { return 1.0 / (E * Gf / (l * ft * ft) - 0.5); }
};

/// The same concrete in a case file, with the strengths that the law asks for.
inline std::string law_keys(const std::string& law) {
  std::string keys = "law = \"" + law + "\"\n";
  if (law == "simo_ju") keys += "strength_ratio = 12.3\n";
  if (law != "linear_elastic") keys += "tensile_strength = 3.05e6\n";
  if (law != "linear_elastic" && law != "mazars_classic") keys += "fracture_energy = 100.0\n";
  if (law.starts_with("mazars")) keys += "compression_a = 1.20402\ncompression_b = 1607.06\n";
  if (law == "mazars_classic") keys += "tension_a = 0.8\ntension_b = 17000.0\n";
  return keys;
}

inline double plus(double x) { return std::max(x, 0.0); }

/// C : e in principal axes.
inline Triple effective(const Concrete& c, const Triple& e) {
  const double mu2 = c.E / (1.0 + c.nu), lambda = mu2 * c.nu / (1.0 - 2.0 * c.nu), tr = e[0] + e[1] + e[2];
  return {lambda * tr + mu2 * e[0], lambda * tr + mu2 * e[1], lambda * tr + mu2 * e[2]};
}

/// Remembers the largest damage; `stress` must be called along the path.
class PathPoint {
public:
  PathPoint(std::string law, double l, Concrete c = {}) : law_(std::move(law)), l_(l), c_(c) {}

  Triple stress(const Triple& e) {
    const Triple s = effective(c_, e);
    damage_ = std::clamp(damage(e, s), damage_, 1.0 - 1e-5);  // eqs. (3), (5)
    return {(1.0 - damage_) * s[0], (1.0 - damage_) * s[1], (1.0 - damage_) * s[2]};
  }

private:
  /// eq. (4) with x = r / r0
  double exponential(double x) const { return x <= 1.0 ? 0.0 : 1.0 - std::exp(c_.A(l_) * (1.0 - x)) / x; }

  double damage(const Triple& e, const Triple& s) const {
    const double two_y = e[0] * s[0] + e[1] * s[1] + e[2] * s[2];
    if (law_ == "simo_ju") {  // eq. (20)
      const double positive = plus(s[0]) + plus(s[1]) + plus(s[2]);
      const double theta = positive / (std::abs(s[0]) + std::abs(s[1]) + std::abs(s[2]));
      return exponential((theta + (1.0 - theta) / c_.n) * std::sqrt(two_y * c_.E) / c_.ft);
    }
    if (law_ == "rankine") return exponential(std::max({s[0], s[1], s[2]}) / c_.ft);  // eq. (23)
    if (law_ == "lemaitre_strain")                                                    // eq. (25)
      return exponential(std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) /
                         (c_.kappa0() * std::sqrt(1.0 + 2.0 * c_.nu * c_.nu)));
    if (law_ == "lemaitre_energy") return exponential(std::sqrt(two_y * c_.E) / c_.ft);  // eq. (26)
    if (law_ == "mazars" || law_ == "mazars_classic") return mazars(e, s);
    return 0.0;  // linear_elastic
  }

  double branch(double kappa, double a, double b) const {  // eq. (33)
    return 1.0 - c_.kappa0() * (1.0 - a) / kappa - a * std::exp(-b * (kappa - c_.kappa0()));
  }

  double mazars(const Triple& e, const Triple& s) const {  // eqs. (28)-(33)
    const double kappa = std::sqrt(plus(e[0]) * plus(e[0]) + plus(e[1]) * plus(e[1]) + plus(e[2]) * plus(e[2]));
    if (kappa <= c_.kappa0()) return 0.0;
    const double positive = plus(s[0]) + plus(s[1]) + plus(s[2]);
    double tension = 0.0, compression = 0.0;
    for (int i = 0; i < 3; ++i) {
      const double et = ((1.0 + c_.nu) * plus(s[i]) - c_.nu * positive) / c_.E;
      tension += plus(et) * plus(e[i]) / (kappa * kappa);
      compression += plus(e[i] - et) * plus(e[i]) / (kappa * kappa);
    }
    const double dt = law_ == "mazars" ? exponential(kappa / c_.kappa0()) : branch(kappa, c_.At, c_.Bt);
    return tension * dt + compression * branch(kappa, c_.Ac, c_.Bc);
  }

  std::string law_;
  double l_;
  Concrete c_;
  double damage_ = 0.0;
};

}  // namespace berm::verify
