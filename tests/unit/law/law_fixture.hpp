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
#include "law/point_response.hpp"
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
/// Laws that know the strain alone, with a damage between 0 and 1 (or none at all).
using DamageLaws =
    ::testing::Types<LinearElastic, SimoJu, Rankine, Mazars, MazarsClassic, LemaitreStrain, LemaitreEnergy>;

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
                                                {"tension_b", 17000.0},
                                                {"cohesion", 2e6},
                                                {"friction_angle", 0.6},
                                                {"dilatancy_angle", 0.2},
                                                {"yield_stress", 3e6},
                                                {"shear_modulus", 2e9},
                                                {"lambda_star", 2e-3},
                                                {"kappa_star", 5e-4},
                                                {"critical_state_slope", 1.2},
                                                {"preconsolidation_pressure", 1.5e6},
                                                {"reference_pressure", 1e6},
                                                {"bulk_modulus", 2e9},
                                                {"viscosity", 1e7}};
  L law;
  for (const auto& p : L::parameters()) {
    const auto found = values.find(p.key);
    if (found == values.end() && !p.default_value) ADD_FAILURE() << "no value for " << p.key;
    law.*p.member = found != values.end() ? found->second : p.default_value.value_or(0.0);
  }
  return law;
}

/// A material point in small strain: commits every step. Steps take the total strain; a law that keeps its elastic
/// strain is given that of the last step and the increment.
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
    now.strain = law_strain(strain);
    LawOutput result;
    std::vector<double> next(L::n_state);
    EXPECT_EQ(law.update(now, state.data(), next.data(), result), Status::ok);
    return result;
  }

  const LawOutput& step(const Voigt& strain) {
    in.strain = law_strain(strain);
    std::vector<double> next(L::n_state);
    EXPECT_EQ(law.update(in, state.data(), next.data(), out), Status::ok);
    work += 0.5 * (last_stress + out.stress).dot(strain - last_strain);
    last_stress = out.stress;
    last_strain = strain;
    dissipated += out.dissipated;
    state = next;
    return out;
  }

  /// Laws that keep it: the elastic strain after the last step.
  Voigt elastic() const { return Eigen::Map<const Voigt>(state.data() + L::elastic_strain); }

  /// What the law is given for a total strain.
  Voigt law_strain(const Voigt& strain) const {
    if constexpr (keeps_elastic_strain<L>)
      return elastic() + (strain - last_strain);
    else
      return strain;
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
/// Plane strain: without the columns of the strains that stay zero, where a law may have a corner. Laws with a residual
/// stiffness where their stress cannot change: without that.
template <class L>
double tangent_error(const Point<L>& point, const Voigt& strain, bool plane = false) {
  const double h = 1e-6 * strain.norm();
  const Voigt66 tangent = point.trial(strain).tangent;
  Voigt66 error = tangent;
  for (int j = 0; j < 6; ++j) {
    const Voigt step = h * Voigt::Unit(j);
    error.col(j) -= (point.trial(strain + step).stress - point.trial(strain - step).stress) / (2.0 * h);
    if (plane && (j == ZZ || j == YZ || j == ZX)) error.col(j).setZero();
  }
  double distance = error.norm();
  if constexpr (requires { L::residual_stiffness; }) {
    Voigt66 residual;
    point.law.lame().stiffness(L::residual_stiffness, residual);
    if (plane) residual.col(ZZ).setZero(), residual.col(YZ).setZero(), residual.col(ZX).setZero();
    distance = std::min(distance, (error - residual).norm());
  }
  return std::max(0.0, distance - 2e-10 * point.law.stiffness()) / tangent.norm();
}

/// Components of grad u that a model has, as it orders them: row and column of each.
inline std::vector<std::pair<int, int>> places(Space space) {
  switch (space) {
    case Space::solid:
      return {{0, 0}, {0, 1}, {0, 2}, {1, 0}, {1, 1}, {1, 2}, {2, 0}, {2, 1}, {2, 2}};
    case Space::axisymmetric:
      return {{0, 0}, {0, 1}, {1, 0}, {1, 1}, {2, 2}};
    default:
      return {{0, 0}, {0, 1}, {1, 0}, {1, 1}};
  }
}

}  // namespace berm::test
