/// Drucker-Prager: triaxial closed form, collapse of plane strain against Mohr-Coulomb, apex, tangents, energies.

#include "plasticity_fixture.hpp"

namespace berm::test {
namespace {

DruckerPrager soil(double cohesion, double friction, double dilatancy = 0.0, double hardening = 0.0) {
  DruckerPrager law;
  law.youngs_modulus = 1e6;
  law.poisson_ratio = 0.29;
  law.cohesion = cohesion;
  law.friction_angle = friction * degree;
  law.dilatancy_angle = dilatancy * degree;
  law.hardening_modulus = hardening;
  return law;
}

/// q/sqrt(3) = k - A p with q = s1 - s3, p = -(s1 + 2 s3)/3 (pressures positive), and the flow of the gradient.
TEST(DruckerPrager, TriaxialCompression) {
  for (double psi : {0.0, 10.0, 25.0})
    for (double s3 : {10e3, 50e3, 100e3}) {
      const DruckerPrager law = soil(5e3, 25, psi);
      const Cone y = law.cone();
      const double root = std::sqrt(3.0);
      const double s1 = (root * y.strength + s3 * (1.0 + 2.0 * y.friction / root)) / (1.0 - y.friction / root);
      const double at_yield = (s1 - s3) / law.youngs_modulus;
      Point<DruckerPrager> point = confined_point(law, s3);
      const Voigt start = point.elastic();
      point.step(lateral_control(point, -at_yield * (1.0 - 1e-9), s3, true));
      EXPECT_EQ(point.out.plastic_strain, 0.0);
      for (double x : {1.1, 2.0}) {
        point.step(lateral_control(point, -x * at_yield, s3, true));
        EXPECT_NEAR(point.out.stress[XX], -s1, 1e-8 * s1);
      }
      const Voigt plastic = point.last_strain - point.elastic() + start;
      const double expected = y.dilatancy / (y.dilatancy / 3.0 - 1.0 / root);
      EXPECT_NEAR(plastic.head<3>().sum() / plastic[XX], expected, 1e-8);
    }
}

/// The match of the parameters, eqs. (48) and (49): in plane strain the strength and the dilatancy of Mohr-Coulomb.
TEST(DruckerPrager, PlaneStrainFailsLikeMohrCoulomb) {
  for (double phi : {0.0, 25.0, 37.0})
    for (double psi : {0.0, 0.5 * phi, phi}) {
      const double s3 = 20e3, c = 5e3, root_kp = std::tan((45.0 + 0.5 * phi) * degree);
      const double strength = s3 * root_kp * root_kp + 2.0 * c * root_kp;
      Point<DruckerPrager> point = confined_point(soil(c, phi, psi), s3);
      Voigt before = point.last_strain;
      for (int i = 1; i <= 200; ++i) {
        before = point.last_strain;
        point.step(lateral_control(point, -0.02 * i, s3, false));
      }
      EXPECT_NEAR(point.out.stress[XX], -strength, 1e-8 * strength) << phi << " " << psi;
      const Voigt last = point.last_strain - before;
      EXPECT_NEAR(last.head<3>().sum() / last[XX], 1.0 - std::pow(std::tan((45.0 + 0.5 * psi) * degree), 2), 1e-8);
    }
}

/// phi = 0: von Mises with the yield stress sqrt(3) c.
TEST(DruckerPrager, WithoutFrictionItIsVonMises) {
  VonMises twin;
  twin.youngs_modulus = 1e6;
  twin.poisson_ratio = 0.29;
  twin.yield_stress = std::sqrt(3.0) * 5e3;
  twin.hardening_modulus = std::sqrt(3.0) * 2e3;
  RandomStrain random;
  Point<DruckerPrager> point(soil(5e3, 0, 0, 2e3));
  Point<VonMises> other(twin);
  for (int k = 0; k < 100; ++k) {
    const Voigt strain = random(0.05, k % 2 == 0);
    point.step(strain);
    other.step(strain);
    EXPECT_LT((point.out.stress - other.out.stress).norm(), 1e-9 * other.out.stress.norm());
    EXPECT_NEAR(point.out.plastic_strain, other.out.plastic_strain, 1e-10);
  }
}

TEST(DruckerPrager, RandomStepsNeverLeaveTheCone) {
  RandomStrain random;
  int apex = 0, side = 0, elastic = 0;
  for (const DruckerPrager& law : {soil(5e3, 25, 7), soil(5e3, 37, 37), soil(0, 30, 0), soil(5e3, 25, 0, 1e5),
                                   soil(5e3, 25, 25, 1e6), soil(0, 30, 10, 1e4)}) {
    const Cone y = law.cone();
    Point<DruckerPrager> point(law);
    double worst_tangent = 0.0;
    Voigt strain = Voigt::Zero();
    for (int k = 0; k < 4000; ++k) {
      const double size = std::pow(10.0, -3.0 + k % 3);
      Voigt step = random(size, k % 2 == 0);
      step.head<3>().array() += (k % 5 - 2) * size;
      if (k % 50 == 0) point = Point<DruckerPrager>(law), strain.setZero();
      const ConeReturn r =
          return_to_cone(y, law.lame(), StrainInvariants(point.law_strain(strain + step)), point.state[6]);
      ++(r.apex ? apex : r.plastic ? side : elastic);
      if (r.plastic && k % 5 == 0) {
        const double error = tangent_error(point, strain + step);
        worst_tangent = std::max(worst_tangent, r.apex ? 1e-2 * error : error);  // at the apex, of next to nothing
      }
      strain += step;
      point.step(strain);
      const Voigt& s = point.out.stress;
      const double p = s.head<3>().sum() / 3.0;
      Voigt d = s;
      d.head<3>().array() -= p;
      const double side_stress = std::sqrt(0.5 * d.head<3>().squaredNorm() + d.tail<3>().squaredNorm());
      const double limit = y.strength + y.hardening * point.out.plastic_strain;
      const double scale = side_stress + std::abs(p) + limit;
      ASSERT_LE(side_stress + y.friction * p - limit, 1e-10 * scale);
      if (r.plastic) {
        ASSERT_NEAR(side_stress + y.friction * p, limit, 1e-10 * scale);
      }
      ASSERT_GE(point.out.dissipated, -1e-14 * scale * step.norm());
    }
    EXPECT_LT(worst_tangent, 1e-6);
    std::printf("worst tangent error %.1e\n", worst_tangent);
  }
  EXPECT_GT(apex, 500);
  EXPECT_GT(side, 500);
  EXPECT_GT(elastic, 500);
}

TEST(DruckerPrager, ApexCarriesTheTipAndItsTangentIsRegular) {
  const DruckerPrager law = soil(5e3, 25, 7);
  const double tip = law.cone().strength / law.cone().friction;
  EXPECT_NEAR(tip, 5e3 / std::tan(25 * degree), 1e-9 * tip);
  Point<DruckerPrager> point(law);
  point.step(strain_of(0.1, 0.11, 0.09, 0.01));
  EXPECT_LT((point.out.stress - tip * strain_of(1, 1, 1)).norm(), 1e-12 * tip);
  EXPECT_GT(Eigen::SelfAdjointEigenSolver<Voigt66>(point.out.tangent).eigenvalues()[0], 0.0);
}

TEST(DruckerPrager, WorkIsStoredOrDissipated) {
  for (const DruckerPrager& law : {soil(5e3, 25, 0), soil(5e3, 25, 25), soil(5e3, 25, 7, 1e4)}) {
    const auto path = [](double t) { return winding_path(0.05, t); };
    const double coarse = energy_defect(law, path, 500), fine = energy_defect(law, path, 1000);
    EXPECT_LT(fine, 2e-3);
    EXPECT_GT(coarse / fine, 1.8);
  }
}

TEST(DruckerPrager, ParametersThatCannotBeAreRefused) {
  EXPECT_EQ(soil(5e3, 25, 25).check(1.0), "");
  EXPECT_NE(soil(5e3, 25, 26).check(1.0), "");
  EXPECT_NE(soil(0, 0).check(1.0), "");
}

}  // namespace
}  // namespace berm::test
