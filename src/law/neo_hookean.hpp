#pragma once
/// Compressible neo-Hookean solid (Simo and Pister 1984), in logarithmic strain. docs/theory/plasticity.md.

#include <cmath>
#include <string>

#include "law/isotropic_return.hpp"

namespace berm {

struct NeoHookean : YieldingElastic {
  static constexpr std::string_view name = "neo_hookean";
  static constexpr std::string_view doc =
      "Compressible neo-Hookean hyperelasticity (Simo and Pister 1984): rubber and other solids at large strain; "
      "meant for finite kinematics.";
  static constexpr int n_state = 0;

  static std::vector<Parameter<NeoHookean>> parameters() { return elastic_parameters<NeoHookean>(); }
  std::string check(double) const { return {}; }
  void initial_state(double*) const {}

  /// Kirchhoff stress, eqs. (70)-(72).
  Status update(const LawInput& in, const double*, double*, LawOutput& out) const {
    if (!in.strain.allFinite()) return Status::not_admissible;
    const Lame c = lame();
    const SortedPrincipal axes(in.strain);
    const double log_j = in.strain.head<3>().sum();
    const Vec3 excess = (2.0 * axes.value).unaryExpr([](double x) { return std::expm1(x); });  // b_i - 1
    const Vec3 stress = c.mu * excess + Vec3::Constant(c.lambda * log_j);
    out.stress = axes.assemble(stress);
    out.stored_energy = 0.5 * c.mu * excess.sum() - c.mu * log_j + 0.5 * c.lambda * log_j * log_j;
    out.damage = out.dissipated = out.extrapolation_error = 0.0;
    if (in.want_tangent) {
      const Vec3 stretching = 2.0 * c.mu * (excess + Vec3::Ones());
      axes.tangent(stress, Mat3::Constant(c.lambda) + Mat3(stretching.asDiagonal()), out.tangent);
    }
    return std::isfinite(out.stored_energy) ? Status::ok : Status::not_admissible;
  }
};

}  // namespace berm
