#pragma once
/// From a plane deformation gradient to stress and tangent, small or finite, plane strain or plane stress: what the
/// kernels of both methods call. docs/theory/damage.md, section "Finite strain".

#include <cmath>

#include "law/law.hpp"
#include "law/plane_stress.hpp"

namespace berm {

enum class Plane { strain, stress };
enum class Kinematics { finite, small };

struct PlaneResponse {
  Mat2 stress = Mat2::Zero();  ///< Kirchhoff (finite) or Cauchy (small) stress in the plane [Pa]
  double stress_zz = 0.0;      ///< [Pa]
  /// a_ijkl, row 2i+j, column 2k+l: d(force)_i = sum_jl g_I,j a_ijkl g_J,l du_k with g the shape gradients on the
  /// current configuration (finite; includes the geometric part) or the reference one (small) [Pa]
  Eigen::Matrix4d tangent = Eigen::Matrix4d::Zero();
  double strain_zz = 0.0;        ///< [-]
  Voigt strain = Voigt::Zero();  ///< Hencky (finite) or small strain, engineering shear, with zz [-]
  double damage = 0.0;           ///< see LawOutput for these four
  double stored_energy = 0.0;
  double dissipated = 0.0;
  double extrapolation_error = 0.0;
};

/// d(strain xx, yy, engineering xy) / d(l_xx, l_xy, l_yx, l_yy), l = dF F^-1.
using StrainOperator = Eigen::Matrix<double, 3, 4>;

/// The operator of small strain: the symmetric part of l.
inline StrainOperator symmetric_part() {
  StrainOperator m;
  m << 1, 0, 0, 0,  //
      0, 0, 0, 1,   //
      0, 1, 1, 0;
  return m;
}

/// Hencky strain ln(F F^T)/2 from h = F - I, exact to rounding for any size of h, eqs. (40)-(42); `rate`, if asked for,
/// is its exact derivative, eq. (44), also for equal stretches. False if det F <= 0.
inline bool hencky_strain(const Mat2& h, Voigt& strain, StrainOperator* rate) {
  const double volume = h.trace() + h.determinant();  // J - 1
  if (!(volume > -1.0)) return false;
  const Mat2 b = h + h.transpose() + h * h.transpose();  // b - I
  const double half = 0.5 * (b(0, 0) - b(1, 1)), radius = std::sqrt(half * half + b(0, 1) * b(0, 1));
  const double cos2 = radius > 0.0 ? half / radius : 1.0, sin2 = radius > 0.0 ? b(0, 1) / radius : 0.0;
  const double larger = 1.0 + 0.5 * b.trace() + radius;                // eigenvalues of b: larger, and ...
  const double smaller = (1.0 + volume) * (1.0 + volume) / larger;     // ... smaller, without cancellation
  const double x = 2.0 * radius / smaller, ratio_log = std::log1p(x);  // ratio of the two = 1 + x
  const double mean = 0.5 * std::log1p(volume), deviator = 0.25 * ratio_log;
  strain << mean + deviator * cos2, mean - deviator * cos2, 0.0, 2.0 * deviator * sin2, 0.0, 0.0;
  if (rate == nullptr) return true;
  *rate = symmetric_part();
  if (x == 0.0) return true;
  const double c12 = ratio_log / x - 1.0, c21 = (1.0 + x) * (ratio_log / x) - 1.0;
  const Vec3 direction(-0.5 * sin2, 0.5 * sin2, cos2);  // unit shear in the principal axes
  const Eigen::Vector4d n1n2(-0.5 * sin2, 0.5 * (1.0 + cos2), -0.5 * (1.0 - cos2), 0.5 * sin2);
  const Eigen::Vector4d n2n1(-0.5 * sin2, -0.5 * (1.0 - cos2), 0.5 * (1.0 + cos2), 0.5 * sin2);
  *rate += direction * (c12 * n1n2 + c21 * n2n1).transpose();
  return true;
}

/// a = D : d(strain)/dl - tau l^T (the second part for finite strain only), eq. (45).
inline void plane_tangent(const Voigt66& d, const StrainOperator& rate, const Mat2& stress, Kinematics kinematics,
                          Eigen::Matrix4d& a) {
  constexpr int voigt[3] = {XX, YY, XY};
  Eigen::Matrix3d plane;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) plane(i, j) = d(voigt[i], voigt[j]);
  const StrainOperator m = plane * rate;
  a.row(0) = m.row(0);
  a.row(1) = m.row(2);
  a.row(2) = m.row(2);
  a.row(3) = m.row(1);
  if (kinematics == Kinematics::small) return;
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j)
      for (int l = 0; l < 2; ++l) a(2 * i + j, 2 * j + l) -= stress(i, l);
}

/// Stress and tangent at the deformation gradient F. `settings` gives everything of LawInput but the strain.
/// `strain_zz` (plane stress: first guess in, solution out; plane strain: set to 0). Returns the law's status;
/// not_admissible if det F <= 0.
template <Law L>
Status plane_response(const L& law, Plane plane, Kinematics kinematics, const Mat2& f, LawInput settings,
                      const double* old_state, double* new_state, double& strain_zz, PlaneResponse& out) {
  const Mat2 h = f - Mat2::Identity();
  StrainOperator rate;
  if (kinematics == Kinematics::small) {
    settings.strain << h(0, 0), h(1, 1), 0.0, h(0, 1) + h(1, 0), 0.0, 0.0;
    rate = symmetric_part();
  } else if (!hencky_strain(h, settings.strain, settings.want_tangent ? &rate : nullptr)) {
    return Status::not_admissible;
  }

  LawOutput law_out;
  if (plane == Plane::strain) strain_zz = 0.0;
  const Status status = plane == Plane::strain
                            ? law.update(settings, old_state, new_state, law_out)
                            : update_plane_stress(law, settings, old_state, new_state, law_out, strain_zz);
  if (status != Status::ok) return status;

  settings.strain[ZZ] = strain_zz;
  out.strain = settings.strain;
  out.strain_zz = strain_zz;
  out.stress << law_out.stress[XX], law_out.stress[XY], law_out.stress[XY], law_out.stress[YY];
  out.stress_zz = law_out.stress[ZZ];
  out.damage = law_out.damage;
  out.stored_energy = law_out.stored_energy;
  out.dissipated = law_out.dissipated;
  out.extrapolation_error = law_out.extrapolation_error;
  if (settings.want_tangent) plane_tangent(law_out.tangent, rate, out.stress, kinematics, out.tangent);
  return Status::ok;
}

}  // namespace berm
