/// Properties that every law of the list must have.

#include "law_fixture.hpp"

namespace berm::test {
namespace {

template <class L>
struct EveryLaw : ::testing::Test {
  RandomStrain random;

  /// A point that has already seen a random strain (and, for extrapolation, has a rate).
  Point<L> loaded_point(Integration integration, bool plane) {
    Point<L> point(concrete<L>(), 0.05, integration);
    const Voigt direction = random(onset, plane);
    for (double f : {0.5, 2.0, 3.0}) point.step(f * direction);
    return point;
  }
};
TYPED_TEST_SUITE(EveryLaw, AllLaws);

/// Properties of laws whose stress is a share 1 - d of the elastic one.
template <class L>
struct EveryDamageLaw : EveryLaw<L> {};
TYPED_TEST_SUITE(EveryDamageLaw, DamageLaws);

template <class L>
constexpr bool is_damage_law = !keeps_elastic_strain<L> && !std::is_same_v<L, NeoHookean>;

/// Laws whose stress depends on the rate of strain, or is not zero at the start.
template <class L>
constexpr bool is_viscous = L::name == "newtonian";

TYPED_TEST(EveryLaw, NameAndParametersAreUsable) {
  static_assert(Law<TypeParam>);
  EXPECT_FALSE(TypeParam::name.empty());
  EXPECT_FALSE(TypeParam::doc.empty());
  std::map<std::string, int> seen;
  for (const auto& p : TypeParam::parameters()) {
    EXPECT_EQ(seen[p.key]++, 0) << p.key;
    EXPECT_FALSE(p.doc.empty()) << p.key;
  }
  EXPECT_EQ(concrete<TypeParam>().check(0.05), "");
}

TYPED_TEST(EveryLaw, TangentMatchesFiniteDifferences) {
  for (const Integration integration : {Integration::implicit, Integration::impl_ex, Integration::lagged}) {
    for (int k = 0; k < 300; ++k) {
      const bool plane = k % 2 == 0;
      const Point<TypeParam> point = this->loaded_point(integration, plane);
      const Voigt strain = this->random(onset * (k % 3 == 0 ? 0.5 : 6.0), plane);
      const Voigt66 tangent = point.trial(strain).tangent;
      ASSERT_LT(tangent_error(point, strain, plane), 1e-6) << "state " << k;
      if (integration != Integration::implicit && is_damage_law<TypeParam>) {
        ASSERT_EQ((tangent - tangent.transpose()).norm(), 0.0) << "state " << k;
      }
    }
  }
}

TYPED_TEST(EveryLaw, TangentHoldsAtRepeatedPrincipalValues) {
  const Point<TypeParam> point(concrete<TypeParam>());
  std::vector<Vec3> principal = {{3, 1, 1}, {3, -1, -1}, {1, 1, 3}, {-9, -9, 2}, {-9, 2, -9}};
  if (TypeParam::name != "rankine") {  // whose measure has a corner where the largest stresses tie
    principal.insert(principal.end(), {{2, 2, 1}, {2, 2, 2}, {-9, 2, 2}, {2, 2, -9}});
  }
  for (const Vec3& e : principal) {
    for (const Mat3& q : {Mat3(Mat3::Identity()), this->random.rotation()}) {
      const Voigt strain = 2.0 * onset * engineering(voigt(q * e.asDiagonal() * q.transpose()));
      EXPECT_LT(tangent_error(point, strain), 1e-6) << e.transpose();
    }
  }
}

TYPED_TEST(EveryLaw, ZeroIncrementIsIdentity) {
  for (int k = 0; k < 50; ++k) {
    Point<TypeParam> point = this->loaded_point(Integration::implicit, k % 2 == 0);
    if (is_viscous<TypeParam>) point.step(point.last_strain);  // its stress is that of the rate: it comes to rest
    const LawOutput before = point.out;
    const std::vector<double> old_state = point.state;
    point.step(point.last_strain);
    EXPECT_EQ((point.out.stress - before.stress).norm(), 0.0);
    EXPECT_EQ(point.out.damage, before.damage);
    EXPECT_EQ(point.out.plastic_strain, before.plastic_strain);
    EXPECT_EQ(point.out.stored_energy, before.stored_energy);
    EXPECT_EQ(point.out.dissipated, 0.0);
    point.step(point.last_strain);
    for (std::size_t i = 0; i < old_state.size(); ++i) {
      if (is_damage_law<TypeParam> && i == damage_state::rate) continue;
      EXPECT_EQ(point.state[i], old_state[i]) << "state " << i;
    }
  }
}

TYPED_TEST(EveryLaw, UnstrainedPointHasTheStressOfTheStart) {
  const TypeParam law = concrete<TypeParam>();
  const LawOutput out = Point<TypeParam>(law).trial(Voigt::Zero());
  Voigt expected = Voigt::Zero();
  if constexpr (requires { law.reference_pressure; }) expected.head<3>().setConstant(-law.reference_pressure);
  EXPECT_EQ((out.stress - expected).norm(), 0.0);
  EXPECT_EQ(out.damage, 0.0);
  EXPECT_TRUE(out.tangent.allFinite());
}

TYPED_TEST(EveryLaw, IsFrameIndifferent) {
  for (int k = 0; k < 100; ++k) {
    const Mat3 q = this->random.rotation();
    Point<TypeParam> point(concrete<TypeParam>()), rotated(concrete<TypeParam>());
    for (int i = 0; i < 3; ++i) {  // plane states go through the closed form, their rotations through the 3D solver
      const Voigt strain = this->random(4.0 * onset, k % 2 == 0);
      point.step(strain);
      rotated.step(rotate_strain(q, strain));
    }
    const Mat3 expected = q * tensor(point.out.stress) * q.transpose();
    EXPECT_LT((tensor(rotated.out.stress) - expected).norm(), 1e-9 * expected.norm());
    EXPECT_NEAR(rotated.out.damage, point.out.damage, 1e-12);
  }
}

TYPED_TEST(EveryDamageLaw, DamageNeverHealsNorReachesOne) {
  Point<TypeParam> point(concrete<TypeParam>());
  double damage = 0.0;
  for (int k = 0; k < 2000; ++k) {
    const LawOutput& out = point.step(this->random(k * onset, k % 2 == 0));
    EXPECT_GE(out.damage, damage);
    EXPECT_GE(out.dissipated, 0.0);
    damage = out.damage;
  }
  EXPECT_LE(damage, max_damage);
}

TYPED_TEST(EveryDamageLaw, UnloadsAlongTheSecant) {
  Point<TypeParam> point = this->loaded_point(Integration::implicit, false);
  const Voigt top = point.last_strain, stress = point.last_stress;
  for (double f : {0.7, 0.2, 0.0, 0.5, 1.0}) {
    point.step(f * top);
    EXPECT_LT((point.out.stress - f * stress).norm(), 1e-12 * stress.norm());
    EXPECT_LT((point.out.tangent * top - stress).norm(), 1e-12 * stress.norm());
  }
}

/// Smooth, not proportional, with a stretch of unloading.
Voigt curved_path(double t) {
  Voigt a, b;
  a << 12, -2, 1, 3, 0, 0;
  b << 1, 5, -3, 4, 2, -1;
  return onset * (t * t * a + 2.0 * std::sin(5.0 * t) * b);
}

/// Work that went into the point but is neither stored nor dissipated, relative to the work.
template <class L>
double energy_defect(Integration integration, int steps) {
  Point<L> point(concrete<L>(), 0.05, integration);
  point.in.dt = 1.0 / steps;
  for (int i = 1; i <= steps; ++i) point.step(curved_path(double(i) / steps));
  return std::abs(point.work - point.out.stored_energy - point.dissipated) / point.work;
}

TYPED_TEST(EveryDamageLaw, WorkIsStoredOrDissipated) {
  for (const Integration integration : {Integration::implicit, Integration::impl_ex, Integration::lagged}) {
    const double coarse = energy_defect<TypeParam>(integration, 500),
                 fine = energy_defect<TypeParam>(integration, 1000);
    EXPECT_LT(fine, 2e-4);
    EXPECT_TRUE(fine < 1e-12 || coarse / fine > 3.5) << "order 2 expected: " << coarse << " -> " << fine;
  }
}

/// Largest distance of the stress histories from the implicit one, relative to ft.
template <class L>
double integration_error(Integration integration, int steps) {
  Point<L> reference(concrete<L>(), 0.05), point(concrete<L>(), 0.05, integration);
  point.in.dt = reference.in.dt = 1.0 / steps;
  double worst = 0.0;
  for (int i = 1; i <= steps; ++i) {
    const Voigt strain = curved_path(double(i) / steps);
    reference.step(strain);
    point.step(strain);
    worst = std::max(worst, (point.out.stress - reference.out.stress).norm() / ft);
    EXPECT_EQ(point.out.damage, reference.out.damage);  // the damage of the step does not know of the extrapolation
  }
  return worst;
}

TYPED_TEST(EveryDamageLaw, ExplicitIntegrationsConvergeToTheImplicitOne) {
  for (const Integration integration : {Integration::impl_ex, Integration::lagged}) {
    const double coarse = integration_error<TypeParam>(integration, 1000);
    const double fine = integration_error<TypeParam>(integration, 4000);
    EXPECT_TRUE(fine == 0.0 || coarse / fine > 3.0) << "order 1 expected: " << coarse << " -> " << fine;
    EXPECT_LT(fine, 0.05);
  }
}

TYPED_TEST(EveryDamageLaw, ExtrapolationErrorIsThatOfTheStressOverTheStrength) {
  Point<TypeParam> point(concrete<TypeParam>(), 0.05, Integration::impl_ex);
  const Voigt s = concrete<TypeParam>().lame().stress(curved_path(0.9));
  for (double t : {0.3, 0.6, 0.9}) point.step(curved_path(t));
  const double used = 1.0 - point.out.stress.dot(s) / s.squaredNorm();
  double beyond = 1.0;  // elasticity has no damage to be wrong about
  if constexpr (requires { point.law.threshold(); }) beyond = point.state[damage_state::r] / point.law.threshold();
  EXPECT_NEAR(point.out.extrapolation_error, std::abs(used - point.out.damage) * beyond, 1e-12);
}

TYPED_TEST(EveryLaw, TangentIsOnlyTouchedOnRequest) {
  Point<TypeParam> point(concrete<TypeParam>());
  LawInput in = point.in;
  in.strain = curved_path(1.0);
  in.want_tangent = false;
  LawOutput out;
  out.tangent.setConstant(7.0);
  std::vector<double> next(TypeParam::n_state);
  ASSERT_EQ(point.law.update(in, point.state.data(), next.data(), out), Status::ok);
  EXPECT_EQ((out.tangent.array() - 7.0).abs().maxCoeff(), 0.0);
  EXPECT_EQ((out.stress - point.trial(in.strain).stress).norm(), 0.0);
}

TYPED_TEST(EveryLaw, RefusesStrainThatIsNotFinite) {
  const Point<TypeParam> point(concrete<TypeParam>());
  LawInput in = point.in;
  in.strain[XY] = std::nan("");
  LawOutput out;
  std::vector<double> next(TypeParam::n_state);
  EXPECT_EQ(point.law.update(in, point.state.data(), next.data(), out), Status::not_admissible);
}

TYPED_TEST(EveryDamageLaw, LargeCellIsReportedAndNeverSoftened) {
  if constexpr (requires(TypeParam law) { law.fracture_energy; }) {
    const TypeParam law = concrete<TypeParam>();
    const double limit = 2.0 * young * gf / (ft * ft);
    EXPECT_EQ(law.check(0.99 * limit), "");
    const std::string why = law.check(1.5 * limit);
    EXPECT_NE(why.find("1.14485"), std::string::npos) << why;   // the length ...
    EXPECT_NE(why.find("0.763236"), std::string::npos) << why;  // ... and its limit
    EXPECT_NE(why.find("smaller cell"), std::string::npos) << why;
    EXPECT_NE(law.check(0.0), "");

    const Point<TypeParam> point(law, 1.5 * limit);
    LawInput in = point.in;
    in.strain[XX] = 3.0 * onset;
    LawOutput out;
    std::vector<double> next(TypeParam::n_state);
    EXPECT_EQ(law.update(in, point.state.data(), next.data(), out), Status::not_admissible);
  }
}

TEST(LawList, VisitsEveryLawOnceWithItsOwnName) {
  std::vector<std::string> names;
  for_each_law([&names](const auto& law) { names.emplace_back(law.name); });
  const std::vector<std::string> expected = {
      "linear_elastic",  "simo_ju",           "rankine",     "mazars",    "mazars_classic",
      "lemaitre_strain", "lemaitre_energy",   "neo_hookean", "von_mises", "drucker_prager",
      "mohr_coulomb",    "modified_cam_clay", "newtonian"};
  EXPECT_EQ(names, expected);
}

}  // namespace
}  // namespace berm::test
