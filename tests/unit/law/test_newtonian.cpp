/// Newtonian fluid: shear stress of a rate, pressure of a volume, what is kept and what is dissipated.

#include "plasticity_fixture.hpp"

namespace berm::test {
namespace {

Newtonian water() {
  Newtonian law;
  law.bulk_modulus = 2e6;
  law.viscosity = 1e-3;
  return law;
}

TEST(Newtonian, ShearStressIsViscosityTimesRate) {
  Point<Newtonian> point(water());
  for (double dt : {1e-3, 0.1}) {
    point.in.dt = dt;
    const double rate = 7.0;
    point.step(point.last_strain + strain_of(0, 0, 0, rate * dt));
    EXPECT_NEAR(point.out.stress[XY], 1e-3 * rate, 1e-15);
    EXPECT_EQ(point.elastic().norm(), 0.0);
    EXPECT_NEAR(point.out.dissipated, 1e-3 * rate * rate * dt, 1e-15);
    EXPECT_EQ(point.out.stored_energy, 0.0);
  }
}

/// tau = K ln J I, whatever the way; uniaxial flow adds 4/3 mu J rate along it.
TEST(Newtonian, PressureBelongsToTheVolume) {
  Point<Newtonian> point(water());
  point.in.dt = 0.01;
  point.step(strain_of(-0.02, 0.0, 0.0, 0.3));
  point.step(strain_of(-0.02, -0.01, 0.005));
  const double volume = -0.025;
  EXPECT_NEAR(point.out.stress.head<3>().sum() / 3.0, 2e6 * volume, 1e-9 * 2e6);
  EXPECT_NEAR(point.out.stored_energy, 0.5 * 2e6 * volume * volume, 1e-9);
  EXPECT_NEAR(point.elastic()[XX], volume / 3.0, 1e-16);
  EXPECT_NEAR(point.elastic()[ZZ], volume / 3.0, 1e-16);
  point.step(strain_of(0.08, -0.01, 0.005));
  const double rate = 0.1 / 0.01, expected = 2e6 * 0.075 + 4.0 / 3.0 * 1e-3 * std::exp(0.075) * rate;
  EXPECT_NEAR(point.out.stress[XX], expected, 1e-12 * expected);
  point.step(point.last_strain);  // at rest
  EXPECT_LT((point.out.stress - 2e6 * 0.075 * strain_of(1, 1, 1)).norm(), 1e-9 * 2e6);
  EXPECT_LT(point.out.dissipated, 1e-20);
}

TEST(Newtonian, TangentOfViscousFlow) {
  Newtonian honey = water();
  honey.viscosity = 1e6;
  RandomStrain random;
  for (int k = 0; k < 100; ++k) {
    Point<Newtonian> point(honey);
    point.in.dt = 0.5;
    point.step(random(0.1, k % 2 == 0));
    EXPECT_LT(tangent_error(point, random(0.3, k % 2 == 0)), 1e-8);
  }
}

TEST(Newtonian, WithoutTimeThereIsNoRate) {
  Point<Newtonian> point(water());
  LawInput in = point.in;
  in.dt = 0.0;
  LawOutput out;
  std::vector<double> next(Newtonian::n_state);
  EXPECT_EQ(point.law.update(in, point.state.data(), next.data(), out), Status::not_admissible);
}

}  // namespace
}  // namespace berm::test
