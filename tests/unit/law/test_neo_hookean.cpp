/// Neo-Hookean solid: tau = lambda ln J I + mu (b - I) for any deformation, and what follows from it.

#include "law/hencky.hpp"
#include "plasticity_fixture.hpp"

namespace berm::test {
namespace {

LawOutput respond(const Mat3& f) {
  Voigt strain;
  EXPECT_TRUE(hencky_strain<9>(f - Mat3::Identity(), strain, nullptr));
  return Point<NeoHookean>(concrete<NeoHookean>()).trial(strain);
}

TEST(NeoHookean, AnyDeformation) {
  const Lame c = concrete<NeoHookean>().lame();
  RandomStrain random;
  for (int k = 0; k < 200; ++k) {
    const Mat3 f =
        Mat3::Identity() + 0.3 * tensor(random(1.0, k % 2 == 0)) + (k % 3 ? Mat3(random.rotation()) : Mat3::Identity());
    const double j = f.determinant();
    if (j < 0.05) continue;
    const Mat3 b = f * f.transpose();
    const Mat3 expected = c.lambda * std::log(j) * Mat3::Identity() + c.mu * (b - Mat3::Identity());
    const LawOutput out = respond(f);
    EXPECT_LT((tensor(out.stress) - expected).norm(), 1e-12 * c.mu * (b.norm() + std::abs(std::log(j))));
    const double energy =
        0.5 * c.mu * (b.trace() - 3.0) - c.mu * std::log(j) + 0.5 * c.lambda * std::pow(std::log(j), 2);
    EXPECT_NEAR(out.stored_energy, energy, 1e-12 * c.mu * b.norm());
  }
}

TEST(NeoHookean, SimpleShear) {
  const double mu = concrete<NeoHookean>().lame().mu;
  for (double g : {1e-6, 0.1, 1.0, 5.0}) {
    Mat3 f = Mat3::Identity();
    f(0, 1) = g;
    const Voigt s = respond(f).stress;
    EXPECT_NEAR(s[XY], mu * g, 1e-12 * mu * (1.0 + g));
    EXPECT_NEAR(s[XX], mu * g * g, 1e-12 * mu * (1.0 + g * g));
    EXPECT_NEAR(s[YY], 0.0, 1e-12 * mu * (1.0 + g * g));
  }
}

/// Sides free: mu (b_2 - 1) = -lambda ln J, so tau_1 = mu (b_1 - b_2).
TEST(NeoHookean, UniaxialStretch) {
  const Lame c = concrete<NeoHookean>().lame();
  for (double stretch : {0.3, 0.9, 1.1, 3.0}) {
    Point<NeoHookean> point(concrete<NeoHookean>());
    const Voigt strain = lateral_control(point, std::log(stretch), 0.0, true);
    const double b2 = std::exp(2.0 * strain[YY]);
    EXPECT_NEAR(c.mu * (b2 - 1.0), -c.lambda * strain.head<3>().sum(), 1e-12 * c.mu);
    EXPECT_NEAR(point.trial(strain).stress[XX], c.mu * (stretch * stretch - b2), 1e-11 * c.mu);
  }
}

TEST(NeoHookean, SmallStrainIsHooke) {
  const NeoHookean law = concrete<NeoHookean>();
  RandomStrain random;
  for (int k = 0; k < 50; ++k) {
    const Voigt strain = random(1e-9, k % 2 == 0);
    const Voigt expected = law.lame().stress(strain);
    EXPECT_LT((Point<NeoHookean>(law).trial(strain).stress - expected).norm(), 1e-8 * expected.norm());
  }
}

TEST(NeoHookean, StressIsTheDerivativeOfTheEnergyAndTheTangentSymmetric) {
  const Point<NeoHookean> point(concrete<NeoHookean>());
  RandomStrain random;
  for (int k = 0; k < 50; ++k) {
    const Voigt strain = random(0.3, k % 2 == 0);
    const LawOutput out = point.trial(strain);
    EXPECT_LT((out.tangent - out.tangent.transpose()).norm(), 1e-12 * out.tangent.norm());
    EXPECT_LT(tangent_error(point, strain), 1e-7);
    const double h = 1e-5;
    for (int i = 0; i < 6; ++i) {
      const Voigt step = h * Voigt::Unit(i);
      const double slope =
          (point.trial(strain + step).stored_energy - point.trial(strain - step).stored_energy) / (2.0 * h);
      EXPECT_NEAR(slope, out.stress[i], 1e-7 * young);
    }
  }
}

}  // namespace
}  // namespace berm::test
