#pragma once
/// The logarithmic (Hencky) strain and its exact rate. docs/theory/damage.md, section "Finite strain".

#include <Eigen/Eigenvalues>
#include <cmath>

#include "base/tensor.hpp"

namespace berm {

/// Strain components of a model whose grad u has 4 (plane), 5 (around an axis) or 9 (space) components.
constexpr int strains_of(int components) { return components == 9 ? 6 : components == 5 ? 4 : 3; }
/// Voigt index of strain component i of such a model.
constexpr int voigt_of(int components, int i) {
  constexpr int plane[4] = {XX, YY, XY, ZZ};
  return components == 9 ? i : plane[i];
}

/// d(strain) / d(l), l = dF F^-1; rows: strain components with engineering shear, columns: components of l.
template <int components>
using StrainRate = Eigen::Matrix<double, strains_of(components), components>;

/// The rate of the small strain: the symmetric part of l.
template <int components>
StrainRate<components> symmetric_part() {
  StrainRate<components> m = StrainRate<components>::Zero();
  if constexpr (components == 9) {
    m(XX, 0) = m(YY, 4) = m(ZZ, 8) = 1.0;
    m(XY, 1) = m(XY, 3) = m(YZ, 5) = m(YZ, 7) = m(ZX, 2) = m(ZX, 6) = 1.0;
  } else {
    m(0, 0) = m(1, 3) = 1.0;
    m(2, 1) = m(2, 2) = 1.0;
    if constexpr (components == 5) m(3, 4) = 1.0;
  }
  return m;
}

namespace hencky_detail {

/// In-plane part: ln(F F^T)/2 from h = F - I, exact to rounding for any size of h, eqs. (40)-(42), and its derivative,
/// eq. (44), also for equal stretches. False if the in-plane det F <= 0.
template <class Rate>
bool plane_part(const Mat2& h, Voigt& strain, Rate* rate) {
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
  if (rate == nullptr || x == 0.0) return true;
  const double c12 = ratio_log / x - 1.0, c21 = (1.0 + x) * (ratio_log / x) - 1.0;
  const Vec3 direction(-0.5 * sin2, 0.5 * sin2, cos2);  // unit shear in the principal axes
  const Eigen::Vector4d n1n2(-0.5 * sin2, 0.5 * (1.0 + cos2), -0.5 * (1.0 - cos2), 0.5 * sin2);
  const Eigen::Vector4d n2n1(-0.5 * sin2, -0.5 * (1.0 - cos2), 0.5 * (1.0 + cos2), 0.5 * sin2);
  rate->template topLeftCorner<3, 4>() += direction * (c12 * n1n2 + c21 * n2n1).transpose();
  return true;
}

/// The whole tensor by the spectrum of b - I, eqs. (46), (47).
inline bool solid(const Mat3& h, Voigt& strain, StrainRate<9>* rate) {
  const Mat3 f = h + Mat3::Identity();
  const double det = f(0, 0) * (f(1, 1) * f(2, 2) - f(1, 2) * f(2, 1)) -
                     f(0, 1) * (f(1, 0) * f(2, 2) - f(1, 2) * f(2, 0)) +
                     f(0, 2) * (f(1, 0) * f(2, 1) - f(1, 1) * f(2, 0));
  if (!(det > 0.0)) return false;
  const Mat3 b = h + h.transpose() + h * h.transpose();  // b - I: small strains keep their digits
  if (!b.allFinite()) return false;
  const Eigen::SelfAdjointEigenSolver<Mat3> spectrum(b);
  const Vec3 beta = spectrum.eigenvalues();
  const Mat3& n = spectrum.eigenvectors();
  if (!(beta[0] > -1.0)) return false;
  const Vec3 logs(0.5 * std::log1p(beta[0]), 0.5 * std::log1p(beta[1]), 0.5 * std::log1p(beta[2]));
  const Mat3 e = n * logs.asDiagonal() * n.transpose();
  strain << e(0, 0), e(1, 1), e(2, 2), 2.0 * e(0, 1), 2.0 * e(1, 2), 2.0 * e(0, 2);
  if (rate == nullptr) return true;
  rate->setZero();
  const auto voigt = [](const Mat3& m) {
    Voigt v;
    v << m(0, 0), m(1, 1), m(2, 2), m(0, 1) + m(1, 0), m(1, 2) + m(2, 1), m(0, 2) + m(2, 0);
    return v;
  };
  const auto flat = [](const Mat3& m) {  // row-major
    Eigen::Matrix<double, 1, 9> v;
    v << m(0, 0), m(0, 1), m(0, 2), m(1, 0), m(1, 1), m(1, 2), m(2, 0), m(2, 1), m(2, 2);
    return v;
  };
  for (int i = 0; i < 3; ++i) {
    const Mat3 nn = n.col(i) * n.col(i).transpose();
    rate->noalias() += voigt(nn) * flat(nn);
  }
  for (int i = 0; i < 3; ++i)
    for (int j = i + 1; j < 3; ++j) {
      // 2 de_ij = g (b_j l_ij + b_i l_ji) with g the divided difference of ln; x = b_j / b_i - 1 >= 0.
      const double x = (beta[j] - beta[i]) / (1.0 + beta[i]);
      const double g = x > 0.0 ? std::log1p(x) / x : 1.0;  // times b_i
      const Mat3 ij = n.col(i) * n.col(j).transpose();
      rate->noalias() += voigt(ij) * (g * (1.0 + x) * flat(ij) + g * flat(ij.transpose()));
    }
  return true;
}

}  // namespace hencky_detail

/// Hencky strain ln(F F^T)/2 from h = F - I (4 components: zz is left zero; 5: zz = ln F_zz, F_xz = F_yz = 0). `rate`, if
/// asked for, is its exact derivative by l, also for equal stretches. False if det F <= 0.
template <int components>
bool hencky_strain(const Mat3& h, Voigt& strain, StrainRate<components>* rate) {
  if constexpr (components == 9) {
    return hencky_detail::solid(h, strain, rate);
  } else {
    if (rate) *rate = symmetric_part<components>();
    if (!hencky_detail::plane_part(h.topLeftCorner<2, 2>(), strain, rate)) return false;
    if constexpr (components == 5) {
      if (!(h(2, 2) > -1.0)) return false;
      strain[ZZ] = std::log1p(h(2, 2));
    }
    return true;
  }
}

}  // namespace berm
