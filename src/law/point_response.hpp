#pragma once
/// From a deformation gradient to stress and tangent, small or finite, in the plane, around an axis or in space: what
/// the kernels of both methods call. docs/theory/damage.md, section "Finite strain".

#include <cmath>

#include "law/hencky.hpp"
#include "law/law.hpp"
#include "law/plane_stress.hpp"

namespace berm {

/// What kind of model: how many components its deformation has.
///
/// | space | independent components of grad u, in the order of the tangent | strain components |
/// | plane_strain, plane_stress | xx, xy, yx, yy | xx, yy, xy |
/// | axisymmetric: x is the radius, y the axis, zz the hoop | xx, xy, yx, yy, zz | xx, yy, xy, zz |
/// | solid | xx, xy, xz, yx, ..., zz | all six |
enum class Space { plane_strain, plane_stress, axisymmetric, solid };
enum class Kinematics { finite, small };

constexpr int dimension_of(Space space) { return space == Space::solid ? 3 : 2; }
/// Models with a thickness.
constexpr bool is_plane(Space space) { return space == Space::plane_strain || space == Space::plane_stress; }
/// Components of grad u that a model has: rows and columns of its tangent.
constexpr int components_of(Space space) { return space == Space::solid ? 9 : space == Space::axisymmetric ? 5 : 4; }

struct PointResponse {
  Voigt stress = Voigt::Zero();  ///< Kirchhoff (finite) or Cauchy (small) stress [Pa]
  Voigt strain = Voigt::Zero();  ///< what the law was given: Hencky (finite) or small strain, engineering shear [-]
  double damage = 0.0;           ///< see LawOutput for these five
  double plastic_strain = 0.0;
  double stored_energy = 0.0;
  double dissipated = 0.0;
  double extrapolation_error = 0.0;
};

/// a_ijkl by the components of grad u: d(force)_i = sum_jl g_I,j a_ijkl g_J,l du_k with g the shape gradients on the
/// current configuration (finite; includes the geometric part) or the reference one (small) [Pa]
template <int components>
using Modulus = Eigen::Matrix<double, components, components>;

namespace response_detail {

inline Mat3 tensor(const Voigt& v) {
  Mat3 m;
  m << v[XX], v[XY], v[ZX], v[XY], v[YY], v[YZ], v[ZX], v[YZ], v[ZZ];
  return m;
}

/// Strain of F = I + h and, if asked for, its rate; false if det F <= 0.
template <int components>
bool strain_of(const Mat3& h, Kinematics kinematics, Voigt& strain, StrainRate<components>* rate) {
  if (kinematics == Kinematics::finite) return hencky_strain<components>(h, strain, rate);
  strain << h(0, 0), h(1, 1), components > 4 ? h(2, 2) : 0.0, h(0, 1) + h(1, 0), 0.0, 0.0;
  if constexpr (components == 9) {
    strain[YZ] = h(1, 2) + h(2, 1);
    strain[ZX] = h(2, 0) + h(0, 2);
  }
  if (rate) *rate = symmetric_part<components>();
  return true;
}

/// Trial elastic strain of the step from old_f to f and, if asked for, its rate; false if a determinant is not
/// positive. [plasticity (1)]
template <int components>
bool trial_strain_of(const Mat3& old_f, const Mat3& f, Kinematics kinematics, const Voigt& elastic, Voigt& strain,
                     StrainRate<components>* rate) {
  const Mat3 increment = f - old_f;
  if (kinematics == Kinematics::finite)
    return trial_elastic_strain<components>(increment * old_f.inverse(), elastic, strain, rate);
  strain_of<components>(increment, kinematics, strain, rate);
  strain += elastic;
  return true;
}

/// a = D : d(strain)/dl - tau l^T (the second part for finite strain only), eq. (45).
template <int components>
void modulus(const Voigt66& d, const StrainRate<components>& rate, const Voigt& stress, Kinematics kinematics,
             Modulus<components>& a) {
  constexpr int n = strains_of(components);
  Eigen::Matrix<double, n, n> reduced;
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j) reduced(i, j) = d(voigt_of(components, i), voigt_of(components, j));
  const Eigen::Matrix<double, n, components> m = reduced * rate;
  const Mat3 tau = tensor(stress);
  if constexpr (components == 9) {
    constexpr int row_of[9] = {XX, XY, ZX, XY, YY, YZ, ZX, YZ, ZZ};
    for (int i = 0; i < 9; ++i) a.row(i) = m.row(row_of[i]);
    if (kinematics == Kinematics::small) return;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        for (int l = 0; l < 3; ++l) a(3 * i + j, 3 * j + l) -= tau(i, l);
  } else {
    a.row(0) = m.row(0);
    a.row(1) = m.row(2);
    a.row(2) = m.row(2);
    a.row(3) = m.row(1);
    if constexpr (components == 5) a.row(4) = m.row(3);
    if (kinematics == Kinematics::small) return;
    for (int i = 0; i < 2; ++i)
      for (int j = 0; j < 2; ++j)
        for (int l = 0; l < 2; ++l) a(2 * i + j, 2 * j + l) -= tau(i, l);
    if constexpr (components == 5) a(4, 4) -= tau(2, 2);
  }
}

/// The law's answer. Plane stress: strain_zz is the total strain, whatever strain the law sees.
template <Law L>
Status ask(const L& law, Space space, LawInput& in, const double* old_state, double* new_state, LawOutput& out,
           double& strain_zz) {
  if (space != Space::plane_stress) return law.update(in, old_state, new_state, out);
  double already = 0.0;  // plastic strain
  if constexpr (keeps_elastic_strain<L>) already = strain_zz - old_state[L::elastic_strain + ZZ];
  double seen = strain_zz - already;
  const Status status = update_plane_stress(law, in, old_state, new_state, out, seen);
  in.strain[ZZ] = seen;
  strain_zz = seen + already;
  return status;
}

}  // namespace response_detail

/// Stress, and tangent if `tangent` is given, at the deformation gradient F (axisymmetric: with the hoop stretch in zz;
/// plane: zz does not matter) after old_F at t_n, which only laws of plasticity look at. `components` must be
/// components_of(space). `settings` gives everything of LawInput but the strain. `strain_zz` (plane stress: first guess
/// in, solution out; else untouched). Returns the law's status; not_admissible if a determinant is not positive.
template <int components, Law L>
Status point_response(const L& law, Space space, Kinematics kinematics, const Mat3& old_f, const Mat3& f,
                      LawInput settings, const double* old_state, double* new_state, double& strain_zz,
                      PointResponse& out, Modulus<components>* tangent = nullptr) {
  StrainRate<components> rate;
  StrainRate<components>* wanted_rate = tangent ? &rate : nullptr;
  settings.want_tangent = tangent != nullptr;
  bool regular;
  if constexpr (keeps_elastic_strain<L>)
    regular = response_detail::trial_strain_of<components>(
        old_f, f, kinematics, Eigen::Map<const Voigt>(old_state + L::elastic_strain), settings.strain, wanted_rate);
  else
    regular = response_detail::strain_of<components>(f - Mat3::Identity(), kinematics, settings.strain, wanted_rate);
  if (!regular) return Status::not_admissible;

  LawOutput law_out;
  const Status status = response_detail::ask(law, space, settings, old_state, new_state, law_out, strain_zz);
  if (status != Status::ok) return status;

  out.strain = settings.strain;
  out.stress = law_out.stress;
  out.damage = law_out.damage;
  out.plastic_strain = law_out.plastic_strain;
  out.stored_energy = law_out.stored_energy;
  out.dissipated = law_out.dissipated;
  out.extrapolation_error = law_out.extrapolation_error;
  if (tangent) response_detail::modulus<components>(law_out.tangent, rate, out.stress, kinematics, *tangent);
  return Status::ok;
}

}  // namespace berm
