#pragma once
/// Shared by the tests of the laws of plasticity: stress-controlled paths, energy balance, random returns.

#include <cmath>
#include <numbers>

#include "law_fixture.hpp"

namespace berm::test {

constexpr double degree = std::numbers::pi / 180.0;

inline Voigt strain_of(double xx, double yy, double zz, double xy = 0.0) {
  Voigt e;
  e << xx, yy, zz, xy, 0.0, 0.0;
  return e;
}

/// A point that starts at the hydrostatic stress -pressure.
template <class L>
Point<L> confined_point(const L& law, double pressure) {
  Point<L> point(law);
  const double strain = -pressure / (3.0 * law.lame().bulk());
  Eigen::Map<Voigt>(point.state.data() + L::elastic_strain) = strain_of(strain, strain, strain);
  point.last_stress = law.lame().stress(point.elastic());
  return point;
}

/// Axial strain `xx` with the stresses yy and zz held at -pressure (triaxial), or only yy (plane strain): Newton's
/// method for the lateral strain. Returns the strain.
template <class L>
Voigt lateral_control(const Point<L>& point, double xx, double pressure, bool triaxial) {
  Voigt strain = point.last_strain;
  strain[XX] = xx;
  const double scale = pressure + point.law.stiffness() * std::abs(xx);
  for (int i = 0; i < 100; ++i) {
    const LawOutput out = point.trial(strain);
    const double rest = out.stress[YY] + pressure;
    if (std::abs(rest) < 1e-14 * scale) return strain;
    const double step = rest / (out.tangent(YY, YY) + (triaxial ? out.tangent(YY, ZZ) : 0.0));
    strain[YY] -= step;
    if (triaxial) strain[ZZ] -= step;
    if (std::abs(step) < 1e-16 * std::abs(strain[YY])) return strain;
  }
  ADD_FAILURE() << "no lateral strain found at " << xx;
  return strain;
}

/// Every step along a path: dissipation is not negative, and the trapezoidal work differs from what is stored and
/// dissipated by half the change of stress times the plastic strain, eq. (6b) of docs/theory/plasticity.md. Returns the
/// work that is not accounted for, relative to all of it.
template <class L, class Path>
double energy_defect(const L& law, Path path, int steps) {
  Point<L> point(law);
  point.last_stress = point.trial(Voigt::Zero()).stress;
  double stored = 0.0;
  for (int i = 1; i <= steps; ++i) {
    const Voigt old_elastic = point.elastic(), old_stress = point.last_stress, old_strain = point.last_strain;
    const double old_work = point.work;
    point.step(path(double(i) / steps));
    EXPECT_GE(point.out.dissipated, -1e-15 * point.out.stress.norm() * (point.last_strain - old_strain).norm());
    const Voigt flow = point.last_strain - old_strain - (point.elastic() - old_elastic);
    const double rest = point.work - old_work - (point.out.stored_energy - stored) - point.out.dissipated;
    if constexpr (requires { law.lame(); }) {  // linear elasticity
      EXPECT_NEAR(rest, -0.5 * (point.out.stress - old_stress).dot(flow), 1e-10 * point.work);
    }
    stored = point.out.stored_energy;
  }
  EXPECT_GT(point.dissipated, 0.02 * point.work) << "hardly any plastic flow on the path";
  return std::abs(point.work - stored - point.dissipated) / point.work;
}

/// Smooth, not proportional, about `size` large.
inline Voigt winding_path(double size, double t) {
  Voigt a, b;
  a << 2, -3, -1, 3, 0, 0;
  b << 1, 2, -3, 2, 2, -1;
  return size * (t * a + 0.3 * std::sin(5.0 * t) * b);
}

}  // namespace berm::test
