#pragma once
/// Plane stress for any law: the out-of-plane strain that makes stress zz vanish, and the condensed tangent.

#include <algorithm>
#include <cmath>
#include <limits>

#include "law/law.hpp"

namespace berm {

/// Removes the row and column zz from a tangent along stress_zz = 0. False if it is singular.
inline bool condense_zz(Voigt66& d) {
  const double pivot = d(ZZ, ZZ);
  if (!(std::abs(pivot) > 0.0)) return false;
  const Voigt column = d.col(ZZ);
  const Voigt row = d.row(ZZ).transpose() / pivot;
  d.noalias() -= column * row.transpose();
  d.row(ZZ).setZero();
  d.col(ZZ).setZero();
  return true;
}

/// Law::update with in.strain[ZZ] solved for such that |stress_zz| <= 1e-12 |stress|, or what rounding of the strain makes of it (close
/// to Poisson's ratio 0.5 the more). `strain_zz`: first guess in (last
/// converged value), solution out; left alone on failure. Laws with an elastic effective stress say the answer
/// themselves
/// (`free_strain_zz`), so that one evaluation is enough. The tangent comes condensed: row and column ZZ are zero.
/// Returns the law's status, or not_converged after 50 Newton iterations.
template <Law L>
Status update_plane_stress(const L& law, LawInput in, const double* old_state, double* new_state, LawOutput& out,
                           double& strain_zz) {
  constexpr double tolerance = 1e-12;
  constexpr int max_iterations = 50;
  const bool want_tangent = in.want_tangent;
  in.strain[ZZ] = strain_zz;
  if constexpr (requires { law.free_strain_zz(in.strain); })
    in.strain[ZZ] = law.free_strain_zz(in.strain);
  else
    in.want_tangent = true;
  for (int i = 0; i < max_iterations; ++i) {
    const Status status = law.update(in, old_state, new_state, out);
    if (status != Status::ok) return status;
    const double rounded = in.want_tangent ? 2.0 * std::numeric_limits<double>::epsilon() * std::abs(out.tangent(ZZ, ZZ)) * in.strain.norm() : 0.0;
    if (std::abs(out.stress[ZZ]) <= std::max(tolerance * out.stress.norm(), rounded)) {
      if (want_tangent && !condense_zz(out.tangent)) return Status::not_converged;
      strain_zz = in.strain[ZZ];
      return Status::ok;
    }
    if (!in.want_tangent) {  // the law's own answer was not exact: go on with Newton
      in.want_tangent = true;
      continue;
    }
    const double step = out.stress[ZZ] / out.tangent(ZZ, ZZ);
    if (!std::isfinite(step)) return Status::not_converged;
    in.strain[ZZ] -= step;
  }
  return Status::not_converged;
}

}  // namespace berm
