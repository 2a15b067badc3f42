#pragma once
/// Principal values and axes of symmetric 3x3 tensors, and gradients of their isotropic functions.

#include <Eigen/Eigenvalues>
#include <cmath>

#include "base/tensor.hpp"

namespace berm {

/// Spectral decomposition of t = sum_i value_i n_i n_i^T. Without yz, zx shear (every plane problem) by the closed form
/// of the 2x2 block, value[2] = t_zz; else by Eigen's iterative solver. The order of the values is not sorted.
class Principal {
public:
  Principal() = default;
  /// t in tensor components (shear not doubled), Voigt order.
  explicit Principal(const Voigt& t) : plane_(t[YZ] == 0.0 && t[ZX] == 0.0) {
    if (!plane_) {
      general(t);
      return;
    }
    const double mean = 0.5 * (t[XX] + t[YY]), half = 0.5 * (t[XX] - t[YY]);
    const double radius = std::sqrt(half * half + t[XY] * t[XY]);
    value = Vec3(mean + radius, mean - radius, t[ZZ]);
    cos2_ = radius > 0.0 ? half / radius : 1.0;
    sin2_ = radius > 0.0 ? t[XY] / radius : 0.0;
  }

  Vec3 value;

  /// sum_i f_i n_i n_i^T in tensor components. If f_i = d phi / d value_i for an isotropic phi, this is the gradient
  /// of phi; where values coincide, so do the f_i, and the choice of axes does not matter.
  Voigt assemble(const Vec3& f) const {
    Voigt g;
    if (plane_) {
      const double mean = 0.5 * (f[0] + f[1]), half = 0.5 * (f[0] - f[1]);
      g << mean + half * cos2_, mean - half * cos2_, f[2], half * sin2_, 0.0, 0.0;
      return g;
    }
    const Mat3 m = axes_ * f.asDiagonal() * axes_.transpose();
    g << m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(0, 2);
    return g;
  }

  /// Columns n_i, right-handed.
  Mat3 axes() const {
    if (!plane_) return axes_;
    // Half of the angle: the larger of its cosine and sine by a root, the other one without cancellation.
    const double large = std::sqrt(0.5 * (1.0 + std::abs(cos2_))), small = 0.5 * sin2_ / large;
    const double c = cos2_ >= 0.0 ? large : small, s = cos2_ >= 0.0 ? small : large;
    Mat3 n;
    n << c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0;
    return n;
  }

private:
  void general(const Voigt& t) {
    Mat3 m;
    m << t[XX], t[XY], t[ZX], t[XY], t[YY], t[YZ], t[ZX], t[YZ], t[ZZ];
    const Eigen::SelfAdjointEigenSolver<Mat3> solver(m);
    value = solver.eigenvalues();
    axes_ = solver.eigenvectors();
  }

  bool plane_;
  double cos2_, sin2_;  // cosine and sine of twice the angle of n_1 with x (plane case)
  Mat3 axes_;           // columns n_i (general case)
};

/// Strain with engineering shear to tensor components.
inline Voigt tensor_components(const Voigt& strain) {
  Voigt t = strain;
  t.tail<3>() *= 0.5;
  return t;
}

/// Macaulay bracket <x> and its derivative.
inline double positive_part(double x) { return x > 0.0 ? x : 0.0; }
inline double heaviside(double x) { return x > 0.0 ? 1.0 : 0.0; }

}  // namespace berm
