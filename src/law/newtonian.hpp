#pragma once
/// Weakly compressible Newtonian fluid. docs/theory/plasticity.md.

#include <cmath>
#include <string>

#include "law/invariants.hpp"

namespace berm {

struct Newtonian {
  double bulk_modulus = 0.0;  ///< [Pa]
  double viscosity = 0.0;     ///< [Pa s]

  static constexpr std::string_view name = "newtonian";
  static constexpr std::string_view doc =
      "Weakly compressible Newtonian fluid: pressure from the change of volume, shear stress from the rate of strain "
      "in "
      "the step; also carries tension (no cavitation).";
  static constexpr int n_state = 6;
  static constexpr int elastic_strain = 0;
  static constexpr bool no_plane_stress = true;

  static std::vector<Parameter<Newtonian>> parameters() {
    using L = Newtonian;
    return {{"bulk_modulus", &L::bulk_modulus, Unit::stress, positive(), {}, "pressure over relative change of volume"},
            {"viscosity", &L::viscosity, Unit::viscosity, non_negative(), {}, "dynamic viscosity"}};
  }
  std::string check(double) const { return {}; }
  void initial_state(double* state) const { std::fill(state, state + n_state, 0.0); }

  /// A fluid has no Young's modulus: its bulk modulus takes the place where penalties are scaled.
  double stiffness() const { return bulk_modulus; }

  /// Eqs. (75)-(77). The deviator of the trial strain is all of this step, as none is kept.
  Status update(const LawInput& in, const double*, double* new_state, LawOutput& out) const {
    if (!in.strain.allFinite() || !(in.dt > 0.0)) return Status::not_admissible;
    const StrainInvariants e(in.strain);
    const double eta = viscosity * std::exp(e.volume) / in.dt;  // Kirchhoff stress: J times Cauchy stress
    out.stress = 2.0 * eta * e.deviator;
    out.stress.head<3>().array() += bulk_modulus * e.volume;
    out.stored_energy = 0.5 * bulk_modulus * e.volume * e.volume;
    out.dissipated = 3.0 * eta * e.shear * e.shear;
    out.damage = out.plastic_strain = out.extrapolation_error = 0.0;
    const Voigt kept = e.strain(e.volume, 0.0);
    std::copy(kept.begin(), kept.end(), new_state);
    if (in.want_tangent) {
      Lame{bulk_modulus - 2.0 / 3.0 * eta, eta}.stiffness(1.0, out.tangent);
      out.tangent.leftCols<3>().colwise() += 2.0 * eta * e.deviator;
    }
    return std::isfinite(out.stored_energy) && std::isfinite(out.dissipated) ? Status::ok : Status::not_admissible;
  }
};

}  // namespace berm
