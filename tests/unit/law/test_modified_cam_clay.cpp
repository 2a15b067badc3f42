/// Modified Cam-Clay: compression lines, drained and undrained triaxial tests, returns, tangents, energies.

#include "plasticity_fixture.hpp"

namespace berm::test {
namespace {

ModifiedCamClay clay(double overconsolidation = 1.5) {
  ModifiedCamClay law;
  law.lambda_star = 0.1;
  law.kappa_star = 0.02;
  law.shear_modulus = 5e6;
  law.critical_state_slope = 1.2;
  law.reference_pressure = 100e3;
  law.preconsolidation_pressure = overconsolidation * 100e3;
  return law;
}

double mean_pressure(const Voigt& s) { return -s.head<3>().sum() / 3.0; }

double deviator_stress(const Voigt& s) {
  Voigt d = s;
  d.head<3>().array() += mean_pressure(s);
  return std::sqrt(1.5 * (d.head<3>().squaredNorm() + 2.0 * d.tail<3>().squaredNorm()));
}

TEST(ModifiedCamClay, StartsAtTheReferencePressure) {
  const LawOutput out = Point<ModifiedCamClay>(clay()).trial(Voigt::Zero());
  EXPECT_EQ((out.stress + 100e3 * strain_of(1, 1, 1)).norm(), 0.0);
  EXPECT_EQ(out.stored_energy, 0.0);
}

/// e_v = -kappa ln(p/p0) up to p_c, -lambda ln(p/p_c) more beyond, kappa again on the way back.
TEST(ModifiedCamClay, IsotropicCompressionFollowsTheLines) {
  const ModifiedCamClay law = clay();
  Point<ModifiedCamClay> point(law);
  const auto squeeze = [&](double volume) {
    point.step(volume / 3.0 * strain_of(1, 1, 1));
    return mean_pressure(point.out.stress);
  };
  const double to_pc = law.kappa_star * std::log(1.5);
  EXPECT_NEAR(squeeze(-0.5 * to_pc), 100e3 * std::sqrt(1.5), 1e-10 * 100e3);
  EXPECT_EQ(point.out.plastic_strain, 0.0);
  double p = 0.0;
  for (double factor : {1.1, 2.0, 10.0}) {  // p / p_c
    p = 150e3 * factor;
    EXPECT_NEAR(squeeze(-to_pc - law.lambda_star * std::log(factor)), p, 1e-10 * p);
    EXPECT_NEAR(point.state[ModifiedCamClay::preconsolidation], p, 1e-10 * p);
  }
  EXPECT_EQ(point.out.stress.tail<3>().norm(), 0.0);
  const double volume = point.last_strain.head<3>().sum();
  EXPECT_NEAR(squeeze(volume + law.kappa_star * std::log(5.0)), p / 5.0, 1e-10 * p);
}

/// Drained test at constant lateral pressure: elastic q = 3 G e_s and p = p0 + q/3 first, q = M p with
/// p = s3 3/(3 - M) in the end, whether the soil is soft or stiff.
TEST(ModifiedCamClay, DrainedTriaxialTestEndsAtTheCriticalState) {
  for (double ocr : {1.2, 3.0, 8.0}) {
    const ModifiedCamClay law = clay(ocr);
    const double s3 = law.reference_pressure, m = law.critical_state_slope;
    Point<ModifiedCamClay> point(law);
    double peak = 0.0;
    for (int i = 1; i <= 1500; ++i) {
      const double e = i <= 10 ? -1e-5 * i : -1e-4 - 1e-3 * (i - 10);
      const Voigt strain = lateral_control(point, e, s3, true);
      point.step(strain);
      const double q = deviator_stress(point.out.stress), p = mean_pressure(point.out.stress);
      ASSERT_NEAR(p, s3 + q / 3.0, 1e-10 * p);
      if (point.out.plastic_strain == 0.0) {
        EXPECT_NEAR(q, 3.0 * law.shear_modulus * 2.0 / 3.0 * (strain[YY] - e), 1e-9 * p);
        EXPECT_NEAR(strain.head<3>().sum(), -law.kappa_star * std::log(p / s3), 1e-12);
      }
      peak = std::max(peak, q);
    }
    const double p_end = s3 * 3.0 / (3.0 - m);
    EXPECT_NEAR(mean_pressure(point.out.stress), p_end, 3e-6 * p_end) << ocr;
    EXPECT_NEAR(deviator_stress(point.out.stress), m * p_end, 3e-6 * p_end) << ocr;
    EXPECT_NEAR(point.state[ModifiedCamClay::preconsolidation], 2.0 * p_end, 1e-5 * p_end) << ocr;
    EXPECT_TRUE(ocr > 4.0 ? peak > 1.05 * m * p_end : peak < 1.001 * m * p_end) << "only stiff clay has a peak";
  }
}

/// Undrained: constant volume keeps p^kappa p_c^(lambda - kappa), and p_c = 2 p in the end:
/// p = p0^(kappa/lambda) (p_c0/2)^(1 - kappa/lambda).
TEST(ModifiedCamClay, UndrainedTestEndsAtTheStrengthOfItsVolume) {
  for (double ocr : {1.0, 1.5, 5.0}) {
    const ModifiedCamClay law = clay(ocr);
    const double l = law.lambda_star, k = law.kappa_star, m = law.critical_state_slope, p0 = law.reference_pressure;
    const double invariant = k * std::log(p0) + (l - k) * std::log(ocr * p0);
    Point<ModifiedCamClay> point(law);
    for (int i = 1; i <= 400; ++i) {
      point.step(1e-3 * i * strain_of(-1.0, 0.5, 0.5));
      const double p = mean_pressure(point.out.stress), q = deviator_stress(point.out.stress);
      const double pc = point.state[ModifiedCamClay::preconsolidation];
      ASSERT_NEAR(k * std::log(p) + (l - k) * std::log(pc), invariant, 1e-11);
      ASSERT_LE(q * q / (m * m) + p * (p - pc), 1e-10 * p * pc);
    }
    const double expected = std::pow(p0, k / l) * std::pow(0.5 * ocr * p0, 1.0 - k / l);
    EXPECT_NEAR(mean_pressure(point.out.stress), expected, 1e-8 * expected) << ocr;
    EXPECT_NEAR(deviator_stress(point.out.stress), m * expected, 1e-8 * expected) << ocr;
  }
}

TEST(ModifiedCamClay, RandomStepsNeverLeaveTheEllipse) {
  RandomStrain random;
  int wet = 0, dry = 0, elastic = 0;
  double worst = 0.0;
  for (double ocr : {1.0, 2.0, 10.0})
    for (int k = 0; k < 20000; ++k) {
      const ModifiedCamClay law = clay(ocr);
      const double m2 = law.critical_state_slope * law.critical_state_slope;
      Point<ModifiedCamClay> point(law);
      point.step(random(0.01, k % 2 == 0));
      const double size = std::pow(10.0, -2.0 + 0.5 * (k % 4));
      Voigt strain = random(size, k % 2 == 0);
      strain.head<3>().array() -= 0.3 * (k % 3 - 1) * size;
      const double old_plastic = point.out.plastic_strain;
      if (k % 10 == 0 && size < 0.05) {
        const double error = tangent_error(point, strain);
        worst = std::max(worst, error);
        ASSERT_LT(error, 1e-5) << k;
      }
      point.step(strain);
      const double p = mean_pressure(point.out.stress), q = deviator_stress(point.out.stress);
      const double pc = point.state[ModifiedCamClay::preconsolidation];
      // 1e-8 Pa: what the digits of the stored strain leave of q where next to no pressure is left.
      ASSERT_LE(q * q / m2 + p * (p - pc), 1e-10 * (p * pc + q * q / m2) + 1e-8 * q);
      ASSERT_GE(point.out.dissipated, 0.0);
      ASSERT_GT(p, 0.0);
      ++(point.out.plastic_strain == old_plastic ? elastic : 2.0 * p > pc ? wet : dry);
    }
  EXPECT_GT(wet, 1000);
  EXPECT_GT(dry, 1000);
  EXPECT_GT(elastic, 1000);
  std::printf("worst tangent error %.1e; wet %d, dry %d, elastic %d\n", worst, wet, dry, elastic);
}

TEST(ModifiedCamClay, WorkIsStoredOrDissipated) {
  for (double ocr : {1.0, 4.0}) {
    const auto path = [](double t) { return winding_path(0.03, t); };
    const double coarse = energy_defect(clay(ocr), path, 1000), fine = energy_defect(clay(ocr), path, 2000);
    EXPECT_LT(fine, 5e-3);
    EXPECT_GT(coarse / fine, 1.8) << coarse << " -> " << fine;
  }
}

TEST(ModifiedCamClay, ParametersThatCannotBeAreRefused) {
  EXPECT_EQ(clay().check(1.0), "");
  EXPECT_NE(clay(0.9).check(1.0), "");
  ModifiedCamClay law = clay();
  law.kappa_star = law.lambda_star;
  EXPECT_NE(law.check(1.0), "");
}

TEST(ModifiedCamClay, StrainBeyondAllNumbersIsRefused) {
  const Point<ModifiedCamClay> point(clay());
  LawInput in = point.in;
  in.strain = strain_of(-100, -100, -100);
  LawOutput out;
  std::vector<double> next(ModifiedCamClay::n_state);
  EXPECT_EQ(point.law.update(in, point.state.data(), next.data(), out), Status::not_admissible);
}

}  // namespace
}  // namespace berm::test
