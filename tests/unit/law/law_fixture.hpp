#pragma once
/// Shared by the law tests: the concrete of the reference cases, a point that is led along a strain path, random
/// strains.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <map>
#include <random>
#include <string>
#include <vector>

#include "law/all.hpp"
#include "law/principal.hpp"

namespace berm::test {

constexpr double young = 35.5e9, nu = 0.2, ft = 3.05e6, strength_ratio = 12.3, gf = 100.0;
constexpr double onset = ft / young;  ///< strain at the peak of uniaxial tension

/// Every law in turn, for typed tests.
template <class>
struct TypesOf;
template <class... L>
struct TypesOf<std::variant<L...>> {
  using Type = ::testing::Types<L...>;
};
using AllLaws = TypesOf<AnyLaw>::Type;

/// The law with the values of the reference concrete, set through its parameter table as the case reader does.
template <class L>
L concrete() {
  const std::map<std::string, double> values = {{"youngs_modulus", young},
                                                {"poisson_ratio", nu},
                                                {"tensile_strength", ft},
                                                {"fracture_energy", gf},
                                                {"compression_a", 1.20402},
                                                {"compression_b", 1607.06},
                                                {"strength_ratio", strength_ratio},
                                                {"tension_a", 0.8},
                                                {"tension_b", 17000.0}};
  L law;
  for (const auto& p : L::parameters()) {
    const auto found = values.find(p.key);
    if (found == values.end() && !p.default_value) ADD_FAILURE() << "no value for " << p.key;
    law.*p.member = found != values.end() ? found->second : p.default_value.value_or(0.0);
  }
  return law;
}

/// A material point: commits every step.
template <class L>
struct Point {
  explicit Point(const L& law_, double length = 0.05, Integration integration = Integration::implicit)
      : law(law_), state(L::n_state) {
    in.length = length;
    in.integration = integration;
    law.initial_state(state.data());
  }

  /// Trial step: nothing is committed.
  LawOutput trial(const Voigt& strain) const {
    LawInput now = in;
    now.strain = strain;
    LawOutput result;
    std::vector<double> next(L::n_state);
    EXPECT_EQ(law.update(now, state.data(), next.data(), result), Status::ok);
    return result;
  }

  const LawOutput& step(const Voigt& strain) {
    in.strain = strain;
    std::vector<double> next(L::n_state);
    EXPECT_EQ(law.update(in, state.data(), next.data(), out), Status::ok);
    work += 0.5 * (last_stress + out.stress).dot(strain - last_strain);
    last_stress = out.stress;
    last_strain = strain;
    dissipated += out.dissipated;
    state = next;
    return out;
  }

  L law;
  LawInput in;
  LawOutput out;
  std::vector<double> state;
  Voigt last_stress = Voigt::Zero(), last_strain = Voigt::Zero();
  double work = 0.0, dissipated = 0.0;
};

/// Strain of the stress s in the undamaged solid.
inline Voigt compliance(const Voigt& s) {
  Voigt e = (1.0 + nu) / young * s;
  e.head<3>().array() -= nu / young * s.head<3>().sum();
  e.tail<3>() *= 2.0;
  return e;
}

/// E S : C^-1 : S.
inline double energy_of_pattern(const Voigt& s) { return young * compliance(s).dot(s); }

/// Share of the work to full failure that an exponential path has not dissipated where it is cut off at x = e/e*: the
/// stored energy and the area under the rest of the curve, eq. (18).
inline double undissipated_share(double x, double length) {
  const double a = 1.0 / (young * gf / (length * ft * ft) - 0.5);
  return std::exp(a * (1.0 - x)) * (0.5 * x + 1.0 / a) / (0.5 + 1.0 / a);
}

/// Random strains about `size` large; plane strain or all six components.
class RandomStrain {
public:
  Voigt operator()(double size, bool plane) {
    Voigt e;
    for (double& x : e) x = size * normal_(generator_);
    if (plane) e[ZZ] = e[YZ] = e[ZX] = 0.0;
    return e;
  }
  Mat3 rotation() {
    Eigen::Quaterniond q(normal_(generator_), normal_(generator_), normal_(generator_), normal_(generator_));
    return q.normalized().toRotationMatrix();
  }

private:
  std::mt19937 generator_{20260101};
  std::normal_distribution<double> normal_;
};

inline Mat3 tensor(const Voigt& t) {
  Mat3 m;
  m << t[XX], t[XY], t[ZX], t[XY], t[YY], t[YZ], t[ZX], t[YZ], t[ZZ];
  return m;
}
inline Voigt voigt(const Mat3& m) {
  Voigt t;
  t << m(0, 0), m(1, 1), m(2, 2), m(0, 1), m(1, 2), m(0, 2);
  return t;
}
inline Voigt engineering(Voigt t) {
  t.tail<3>() *= 2.0;
  return t;
}
inline Voigt rotate_strain(const Mat3& q, const Voigt& strain) {
  return engineering(voigt(q * tensor(tensor_components(strain)) * q.transpose()));
}

/// Distance of the tangent from central differences of the stress over its norm, less what rounding of 1 - d explains.
/// Plane strain: without the columns of the strains that stay zero, where a law may have a corner.
template <class L>
double tangent_error(const Point<L>& point, const Voigt& strain, bool plane = false) {
  const double h = 1e-6 * strain.norm();
  Voigt66 error = point.trial(strain).tangent;
  const double norm = error.norm();
  for (int j = 0; j < 6; ++j) {
    const Voigt step = h * Voigt::Unit(j);
    error.col(j) -= (point.trial(strain + step).stress - point.trial(strain - step).stress) / (2.0 * h);
    if (plane && (j == ZZ || j == YZ || j == ZX)) error.col(j).setZero();
  }
  return std::max(0.0, error.norm() - 1e-10 * young) / norm;
}

}  // namespace berm::test
