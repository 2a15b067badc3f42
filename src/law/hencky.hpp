#pragma once
/// The logarithmic (Hencky) strain and its exact rate. docs/theory/damage.md, section "Finite strain".

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <cmath>

#include "law/principal.hpp"

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

/// In-plane part: ln(b)/2 from b - I and ln(det b)/2, exact to rounding for any size of it, eqs. (40)-(42), and its
/// derivative, eq. (44), also for equal stretches.
template <class Rate>
void plane_part(const Mat2& b, double log_area, Voigt& strain, Rate* rate) {
  const double half = 0.5 * (b(0, 0) - b(1, 1)), radius = std::sqrt(half * half + b(0, 1) * b(0, 1));
  const double cos2 = radius > 0.0 ? half / radius : 1.0, sin2 = radius > 0.0 ? b(0, 1) / radius : 0.0;
  const double larger = 1.0 + 0.5 * b.trace() + radius;                // eigenvalues: larger, and ...
  const double smaller = std::exp(2.0 * log_area) / larger;            // ... smaller, without cancellation
  const double x = 2.0 * radius / smaller, ratio_log = std::log1p(x);  // ratio of the two = 1 + x
  const double mean = 0.5 * log_area, deviator = 0.25 * ratio_log;
  strain << mean + deviator * cos2, mean - deviator * cos2, 0.0, 2.0 * deviator * sin2, 0.0, 0.0;
  if (rate == nullptr || x == 0.0) return;
  const double c12 = ratio_log / x - 1.0, c21 = (1.0 + x) * (ratio_log / x) - 1.0;
  const Vec3 direction(-0.5 * sin2, 0.5 * sin2, cos2);  // unit shear in the principal axes
  const Eigen::Vector4d n1n2(-0.5 * sin2, 0.5 * (1.0 + cos2), -0.5 * (1.0 - cos2), 0.5 * sin2);
  const Eigen::Vector4d n2n1(-0.5 * sin2, -0.5 * (1.0 - cos2), 0.5 * (1.0 + cos2), 0.5 * sin2);
  rate->template topLeftCorner<3, 4>() += direction * (c12 * n1n2 + c21 * n2n1).transpose();
}

/// The whole tensor by the spectrum of b - I, eqs. (46), (47).
inline bool solid(const Mat3& b, Voigt& strain, StrainRate<9>* rate) {
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

/// ln(b)/2 from b - I, which keeps the digits of small strains (4 and 5 components: b_xz = b_yz = 0); log_area: half
/// the logarithm of its in-plane determinant, for these. `rate`, if asked for, is its exact derivative by l where db =
/// l b + b l^T, also for equal stretches. False if b is not positive definite.
template <int components>
bool half_logarithm(const Mat3& b, double log_area, Voigt& strain, StrainRate<components>* rate) {
  if constexpr (components == 9) {
    return hencky_detail::solid(b, strain, rate);
  } else {
    if (!(b(2, 2) > -1.0)) return false;
    if (rate) *rate = symmetric_part<components>();
    hencky_detail::plane_part(b.topLeftCorner<2, 2>(), log_area, strain, rate);
    strain[ZZ] = 0.5 * std::log1p(b(2, 2));
    return true;
  }
}

namespace hencky_detail {

/// True if I + h has a positive determinant; log_area: the logarithm of its in-plane part (not in space).
template <int components>
bool is_regular(const Mat3& h, double& log_area) {
  if constexpr (components == 9) {
    return (h + Mat3::Identity()).determinant() > 0.0;
  } else {
    const Mat2 plane = h.topLeftCorner<2, 2>();
    const double area = plane.trace() + plane.determinant();
    log_area = std::log1p(area);
    return area > -1.0;
  }
}

}  // namespace hencky_detail

/// Hencky strain ln(F F^T)/2 from h = F - I (4 components: zz is left zero; 5: F_xz = F_yz = 0), and its rate. False if
/// det F <= 0.
template <int components>
bool hencky_strain(const Mat3& h, Voigt& strain, StrainRate<components>* rate) {
  double log_area = 0.0;
  if (!hencky_detail::is_regular<components>(h, log_area)) return false;
  Mat3 b = h + h.transpose() + h * h.transpose();
  if constexpr (components == 4) b(2, 2) = 0.0;
  if constexpr (components == 5)
    if (!(h(2, 2) > -1.0)) return false;
  return half_logarithm<components>(b, log_area, strain, rate);
}

/// Trial elastic Hencky strain of a step with dF = I + g from the elastic strain at its start: ln(dF exp(2 e) dF^T)/2,
/// and its rate. False if det dF <= 0.   [plasticity (1)]
template <int components>
bool trial_elastic_strain(const Mat3& g, const Voigt& elastic, Voigt& strain, StrainRate<components>* rate) {
  double log_area = 0.0;
  if (!hencky_detail::is_regular<components>(g, log_area)) return false;
  if constexpr (components == 5)
    if (!(g(2, 2) > -1.0)) return false;
  const Principal axes(tensor_components(elastic));
  const Voigt v = axes.assemble((2.0 * axes.value).unaryExpr([](double e) { return std::expm1(e); }));
  Mat3 b;  // - I
  b << v[XX], v[XY], v[ZX], v[XY], v[YY], v[YZ], v[ZX], v[YZ], v[ZZ];
  const Mat3 half = g + g * b;
  const Mat3 trial = b + half + half.transpose() + half * g.transpose();
  return half_logarithm<components>(trial, log_area + elastic[XX] + elastic[YY], strain, rate);
}

}  // namespace berm
