#pragma once
/// Isotropic linear elasticity (Hooke). With Hencky strain and Kirchhoff stress: Hencky's hyperelastic solid.

#include <cmath>
#include <string>

#include "law/elasticity.hpp"
#include "law/law.hpp"

namespace berm {

struct LinearElastic : IsotropicElastic {
  static constexpr std::string_view name = "linear_elastic";
  static constexpr std::string_view doc =
      "Isotropic linear elasticity; in logarithmic strain with finite kinematics (Hencky's solid).";
  static constexpr int n_state = 0;

  static std::vector<Parameter<LinearElastic>> parameters() { return elastic_parameters<LinearElastic>(); }
  std::string check(double) const { return {}; }
  void initial_state(double*) const {}

  Status update(const LawInput& in, const double*, double*, LawOutput& out) const {
    const Lame c = lame();
    out.stress = c.stress(in.strain);
    if (in.want_tangent) c.stiffness(1.0, out.tangent);
    out.stored_energy = 0.5 * in.strain.dot(out.stress);
    out.damage = out.dissipated = out.extrapolation_error = 0.0;
    return std::isfinite(out.stored_energy) ? Status::ok : Status::not_admissible;
  }
};

}  // namespace berm
