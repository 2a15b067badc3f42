/// Von Mises: closed forms of uniaxial tension with hardening and of shear, the radial return of one step, energies.

#include "plasticity_fixture.hpp"

namespace berm::test {
namespace {

VonMises steel(double hardening = 2e9) {
  VonMises law;
  law.youngs_modulus = 210e9;
  law.poisson_ratio = 0.3;
  law.yield_stress = 240e6;
  law.hardening_modulus = hardening;
  return law;
}

double mises(const Voigt& s) {
  Voigt d = s;
  d.head<3>().array() -= s.head<3>().sum() / 3.0;
  return std::sqrt(1.5 * (d.head<3>().squaredNorm() + 2.0 * d.tail<3>().squaredNorm()));
}

/// s = sy + E H/(E + H) (e - sy/E); elastic unloading, and yield in compression at the stress reached (isotropic).
TEST(VonMises, UniaxialTensionWithHardening) {
  for (double h : {0.0, 2e9, 50e9}) {
    const VonMises law = steel(h);
    const double e = law.youngs_modulus, sy = law.yield_stress, et = e * h / (e + h), onset_strain = sy / e;
    Point<VonMises> point(law);
    double reached = 0.0;
    for (double x : {0.5, 1.0, 1.5, 4.0, 20.0}) {
      point.step(lateral_control(point, x * onset_strain, 0.0, true));
      reached = x <= 1.0 ? x * sy : sy + et * (x - 1.0) * onset_strain;
      EXPECT_NEAR(point.out.stress[XX], reached, 1e-10 * sy) << x;
      EXPECT_LT(point.out.stress.tail<5>().norm(), 1e-9 * sy);
      const double plastic = x * onset_strain - reached / e;
      EXPECT_NEAR(point.out.plastic_strain, plastic, 1e-10 * onset_strain);
      EXPECT_NEAR(point.last_strain[YY], -0.3 * reached / e - 0.5 * plastic, 1e-10 * onset_strain);
    }
    const double top = point.last_strain[XX];
    point.step(lateral_control(point, top - 1.999 * reached / e, 0.0, true));
    EXPECT_NEAR(point.out.stress[XX], -0.999 * reached, 1e-9 * sy);
    point.step(lateral_control(point, top - 3.0 * reached / e, 0.0, true));
    EXPECT_NEAR(point.out.stress[XX], -reached - et * reached / e, 1e-9 * sy);
  }
}

TEST(VonMises, ShearYieldsAtTheStressOverRootThree) {
  Point<VonMises> point(steel(0.0));
  point.step(strain_of(0, 0, 0, 0.1));
  EXPECT_NEAR(point.out.stress[XY], 240e6 / std::sqrt(3.0), 1e-3);
  EXPECT_NEAR(point.out.plastic_strain, (0.1 - point.elastic()[XY]) / std::sqrt(3.0), 1e-12);
}

/// One step from rest: q = (q_trial H + 3 G sy)/(3 G + H), mean stress as if elastic.
TEST(VonMises, OneStepIsTheRadialReturn) {
  RandomStrain random;
  for (int k = 0; k < 500; ++k) {
    const VonMises law = steel(k % 3 * 10e9);
    const Voigt strain = random(0.01, k % 2 == 0), elastic = law.lame().stress(strain);
    Point<VonMises> point(law);
    point.step(strain);
    const double g = law.lame().mu, h = law.hardening_modulus, q = mises(elastic);
    if (q < law.yield_stress) continue;
    const double expected = (q * h + 3.0 * g * law.yield_stress) / (3.0 * g + h);
    EXPECT_NEAR(mises(point.out.stress), expected, 1e-11 * q);
    EXPECT_NEAR(point.out.stress.head<3>().sum(), elastic.head<3>().sum(), 1e-11 * q);
    EXPECT_NEAR(point.out.plastic_strain, (q - law.yield_stress) / (3.0 * g + h), 1e-12);
    const Voigt66 d = point.trial(2.0 * strain).tangent;
    EXPECT_LT((d - d.transpose()).norm(), 1e-12 * d.norm());
    EXPECT_LT(tangent_error(point, random(0.02, false)), 1e-7);
  }
}

TEST(VonMises, WorkIsStoredOrDissipated) {
  for (const VonMises& law : {steel(0.0), steel(20e9)}) {
    const auto path = [](double t) { return winding_path(0.01, t); };
    const double coarse = energy_defect(law, path, 500), fine = energy_defect(law, path, 1000);
    EXPECT_LT(fine, 2e-3);
    EXPECT_GT(coarse / fine, 1.9);
  }
}

}  // namespace
}  // namespace berm::test
