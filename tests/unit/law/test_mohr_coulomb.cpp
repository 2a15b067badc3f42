/// Mohr-Coulomb: strengths and strains at yield of laboratory tests, every region of the return, tangents, energies.

#include "plasticity_fixture.hpp"

namespace berm::test {
namespace {

MohrCoulomb soil(double cohesion, double friction, double dilatancy = 0.0) {
  MohrCoulomb law;
  law.youngs_modulus = 1e6;
  law.poisson_ratio = 0.29;
  law.cohesion = cohesion;
  law.friction_angle = friction * degree;
  law.dilatancy_angle = dilatancy * degree;
  return law;
}

double passive(double friction) { return std::pow(std::tan((45.0 + 0.5 * friction) * degree), 2); }

/// Largest of a s_i - b s_j over all pairs less the limit, and of the excess over the cut-off, relative.
double excess(const MohrCoulomb& law, const MohrCoulomb::Strength& y, const Voigt& stress) {
  const Vec3 s = Eigen::SelfAdjointEigenSolver<Mat3>(tensor(stress)).eigenvalues();
  const double f = s[2] - s[0] + (s[2] + s[0]) * std::sin(y.phi) - 2.0 * y.c * std::cos(y.phi);
  return std::max(f, s[2] - law.tensile_strength) / (s.cwiseAbs().maxCoeff() + y.c + 1e-300);
}

struct Laboratory {
  double cohesion, friction, confinement, strength, triaxial, biaxial;
};

/// Table of the reference cases, V20: clay of 5 kPa and 25 degrees, rockfill of 37 degrees. Its figures have six
/// digits; the strength that is checked to 1e-8 is s3 Kp + 2 c sqrt(Kp).
const Laboratory table[] = {
    {5e3, 25, 0, 15.6969e3, .0156969, .0143768},    {5e3, 25, 10e3, 40.3360e3, .0303360, .0277847},
    {5e3, 25, 50e3, 138.893e3, .0888925, .0814166}, {5e3, 25, 100e3, 262.088e3, .162088, .148457},
    {0, 37, 10e3, 40.2279e3, .0302279, .0276857},   {0, 37, 50e3, 201.140e3, .151140, .138429},
    {0, 37, 100e3, 402.279e3, .302279, .276857}};

TEST(MohrCoulomb, TriaxialAndBiaxialCompression) {
  for (const Laboratory& t : table)
    for (const bool triaxial : {true, false})
      for (const double psi : {0.0, 7.0, 10.0, t.friction}) {
        const MohrCoulomb law = soil(t.cohesion, t.friction, psi);
        const double e = law.youngs_modulus, v = law.poisson_ratio, kp = passive(t.friction);
        const double strength = t.confinement * kp + 2.0 * t.cohesion * std::sqrt(kp), q = strength - t.confinement;
        EXPECT_NEAR(strength, t.strength, 5e-6 * strength);
        const double at_yield = q / e * (triaxial ? 1.0 : 1.0 - v * v);
        EXPECT_NEAR(at_yield, triaxial ? t.triaxial : t.biaxial, 5e-6 * at_yield);
        const double volume = q / e * (1.0 - 2.0 * v) * (triaxial ? 1.0 : 1.0 + v);

        Point<MohrCoulomb> point = confined_point(law, t.confinement);
        point.step(lateral_control(point, -at_yield * (1.0 - 1e-9), t.confinement, triaxial));
        EXPECT_EQ(point.out.plastic_strain, 0.0);
        EXPECT_NEAR(point.out.stress[XX], -strength, 1e-8 * strength);
        EXPECT_NEAR(point.last_strain.head<3>().sum(), -volume, 1e-8 * volume);
        EXPECT_NEAR(point.out.stress[ZZ], -t.confinement - (triaxial ? 0.0 : v * q), 1e-8 * strength);

        double last_volume = 0.0, last_axial = 0.0;
        for (double x : {1.1, 1.5, 2.0}) {
          point.step(lateral_control(point, -x * at_yield, t.confinement, triaxial));
          EXPECT_NEAR(point.out.stress[XX], -strength, 1e-8 * strength);
          EXPECT_NEAR(point.out.stress[YY], -t.confinement, 1e-8 * strength);
          if (x == 1.5) last_volume = point.last_strain.head<3>().sum(), last_axial = point.last_strain[XX];
        }
        EXPECT_GT(point.out.plastic_strain, 0.0);
        const double dilatancy =
            (point.last_strain.head<3>().sum() - last_volume) / (point.last_strain[XX] - last_axial);
        if (triaxial) {
          EXPECT_NEAR(dilatancy, 1.0 - passive(psi), 1e-8);
        }
        if (triaxial && psi == 7.0) {
          EXPECT_NEAR(dilatancy, -0.27757, 1e-5);
        }
        if (triaxial && psi == 10.0) {
          EXPECT_NEAR(dilatancy, -0.42028, 1e-5);
        }
        // In plane strain the intermediate stress still creeps towards its end; the volume of the plastic strain does
        // not.
        const Voigt plastic = point.last_strain - point.elastic() + confined_point(law, t.confinement).elastic();
        EXPECT_NEAR(plastic.head<3>().sum(), (1.0 - passive(psi)) * plastic[XX], 1e-8 * std::abs(plastic[XX]));
      }
}

TEST(MohrCoulomb, TriaxialExtensionReturnsToTheOtherEdge) {
  const MohrCoulomb law = soil(5e3, 25, 5);
  Point<MohrCoulomb> point = confined_point(law, 50e3);
  // Axial stress falls until -s_xx Kp + 2 c sqrt(Kp) = 50 kPa.
  const double kp = passive(25), expected = (50e3 - 2.0 * 5e3 * std::sqrt(kp)) / kp;
  for (double x : {0.01, 0.05, 0.1}) point.step(lateral_control(point, x, 50e3, true));
  EXPECT_NEAR(point.out.stress[XX], -expected, 1e-8 * expected);
}

/// tau / s_n = sin(phi) cos(psi) / (1 - sin(phi) sin(psi)): Davis (1968), and V20.
TEST(MohrCoulomb, SimpleShearReachesDavisStrength) {
  const struct {
    double friction, dilatancy, ratio;
  } cases[] = {{25, 0, 0.42262}, {37, 0, 0.60182}, {25, 10, -1}, {30, 30, -1}};
  for (const auto& c : cases) {
    const double normal_stress = 50e3, sp = std::sin(c.friction * degree), sd = std::sin(c.dilatancy * degree);
    const double expected = sp * std::cos(c.dilatancy * degree) / (1.0 - sp * sd);
    if (c.ratio > 0.0) {
      EXPECT_NEAR(expected, c.ratio, 1e-5);
    }
    Point<MohrCoulomb> point = confined_point(soil(0.0, c.friction, c.dilatancy), normal_stress);
    for (int i = 1; i <= 400; ++i) {
      Voigt strain = point.last_strain;
      strain[XY] = 0.01 * i;
      for (int k = 0; k < 50; ++k) {
        const LawOutput out = point.trial(strain);
        const double rest = out.stress[YY] + normal_stress;
        if (std::abs(rest) < 1e-12 * normal_stress) break;
        strain[YY] -= rest / out.tangent(YY, YY);
      }
      point.step(strain);
    }
    EXPECT_NEAR(point.out.stress[XY] / normal_stress, expected, 1e-8) << c.friction << " " << c.dilatancy;
  }
}

struct Variant {
  std::string name;
  MohrCoulomb law;
};

std::vector<Variant> variants() {
  std::vector<Variant> list = {{"plain", soil(5e3, 25, 7)},        {"associated", soil(5e3, 25, 25)},
                               {"no dilatancy", soil(5e3, 37, 0)}, {"no cohesion", soil(0, 37, 5)},
                               {"Tresca", soil(5e3, 0)},           {"nearly Tresca", soil(5e3, 1e-6)},
                               {"rock", soil(20e3, 55, 20)}};
  const std::size_t n = list.size();
  for (std::size_t i = 0; i < n; ++i)
    if (list[i].law.cohesion > 0.0)
      for (double ft : {0.0, 1e3, 4e3}) {
        list.push_back(list[i]);
        list.back().name += ", cut-off at " + std::to_string(ft);
        list.back().law.tensile_strength = ft;
      }
  list.push_back({"stiff in volume", soil(5e3, 25, 7)});
  list.back().law.poisson_ratio = 0.49;
  return list;
}

/// Stresses in every region with any multipliers, and the trial stresses that must return to them.
TEST(MohrCoulomb, EveryRegionReturnsWhereItsTrialStressWasMade) {
  RandomStrain random;
  const auto amount = [&] { return std::abs(random(1.0, true)[XX]); };
  for (const auto& [name, law] : variants()) {
    const auto y = law.strength(0.0);
    const bool cut = law.cut_off(y);
    const auto planes = law.planes(y);
    std::map<int, int> hits;
    for (int k = 0; k < 24000; ++k) {
      const int region = k % int(cut ? MohrCoulomb::sets.size() : std::size_t(MohrCoulomb::first_cut));
      const ActiveSet& set = MohrCoulomb::sets[region];
      // A stress on the planes of the set: from any stress, along the normals.
      const double size = 10e3 + 2.0 * y.c * std::cos(y.phi) / (1.0 - std::sin(y.phi));
      Vec3 s = size * random(1.0, false).head<3>() - Vec3::Constant(size * amount());
      std::sort(s.begin(), s.end(), std::greater<>());
      Eigen::MatrixXd a(3, set.n);
      Eigen::VectorXd limit(set.n);
      for (int i = 0; i < set.n; ++i) a.col(i) = planes[set.plane[i]].normal, limit[i] = planes[set.plane[i]].limit;
      s -= a * (a.transpose() * a).ldlt().solve(a.transpose() * s - limit);
      bool inside = true;
      for (int i = 0; i < (cut ? 6 : 3); ++i) inside = inside && planes[i].excess(s) < 1e-9 * (s.norm() + 1.0);
      if (!inside) continue;
      Vec3 flow = Vec3::Zero();
      for (int i = 0; i < set.n; ++i) flow += 0.01 * amount() * planes[set.plane[i]].flow;
      double kappa = 0.0;
      MohrCoulomb::Returned r;
      Vec3 strain = law.compliance(s) + flow;
      std::sort(strain.begin(), strain.end(), std::greater<>());
      ASSERT_TRUE(law.return_map(strain, kappa, r));
      std::sort(s.begin(), s.end(), std::greater<>());
      EXPECT_LT((r.stress - s).norm(), 1e-9 * (s.norm() + law.cohesion))
          << name << ": region " << region << " as " << r.region;
      ++hits[region];
    }
    for (int i = 0; i < (cut ? int(MohrCoulomb::sets.size()) : 3); ++i)
      EXPECT_GT(hits[i], 10) << name << ": region " << i;
  }
}

/// Random steps, from far inside to far outside: never outside the surface afterwards, every region is met.
TEST(MohrCoulomb, MillionRandomReturns) {
  RandomStrain random;
  const auto list = variants();
  std::map<int, long> hits, cut_hits;
  double worst = 0.0;
#ifdef __SANITIZE_ADDRESS__
  const int trials = 100000;  // every one takes its time there
#else
  const int trials = 1000000;
#endif
  const int each = trials / int(list.size()) + 1;
  for (const auto& [name, law] : list) {
    const auto y = law.strength(0.0);
    const bool cut = law.cut_off(y);
    std::array<double, 7> state{}, next{};
    LawInput in;
    in.want_tangent = false;
    LawOutput out;
    for (int k = 0; k < each; ++k) {
      const double size = std::pow(10.0, -4.0 + k % 5);
      in.strain = random(size, k % 2 == 0);
      in.strain.head<3>().array() += (k % 7 - 4) * 0.5 * size;
      if (k % 11 == 0) in.strain[YY] = in.strain[XX], in.strain[XY] = in.strain[YZ] = in.strain[ZX] = 0.0;
      if (k % 3 == 0) in.strain += Eigen::Map<Voigt>(state.data());
      ASSERT_EQ(law.update(in, state.data(), next.data(), out), Status::ok);
      worst = std::max(worst, excess(law, y, out.stress));
      ASSERT_LT(excess(law, y, out.stress), 1e-10) << name << " " << in.strain.transpose();
      ASSERT_GE(out.dissipated, -1e-14 * (out.stress.norm() + 1e-9 * law.cohesion) * in.strain.norm()) << name;
      double kappa = 0.0;
      MohrCoulomb::Returned r;
      law.return_map(SortedPrincipal(in.strain).value, kappa, r);
      ++(cut ? cut_hits : hits)[r.region];
      if (r.region != MohrCoulomb::elastic && r.region != MohrCoulomb::apex) {  // no negative multiplier, no excess
        const Vec3 strain = SortedPrincipal(in.strain).value;
        ASSERT_LT(r.violation, 1e-13 * 3.0 * law.lame().bulk() * strain.cwiseAbs().maxCoeff()) << name << r.region;
      }
      if (k % 3 == 0) state = next;
      state[6] = 0.0;
    }
  }
  for (int region : {-1, 0, 1, 2, int(MohrCoulomb::apex)}) EXPECT_GT(hits[region], trials / 2000) << region;
  long corner = 0;
  for (int region : {7, 8}) corner += cut_hits[region];
  for (int region : {-1, 0, 1, 2, 3, 4, 5, 6, 9}) EXPECT_GT(cut_hits[region], trials / 2000) << region;
  EXPECT_GT(corner, trials / 2000);
  std::printf("largest excess: %.1e\nhits without cut-off, by region:", worst);
  for (const auto& [region, n] : hits) std::printf(" %d: %ld", region, n);
  std::printf("\nwith cut-off:");
  for (const auto& [region, n] : cut_hits) std::printf(" %d: %ld", region, n);
  std::printf("\n");
}

MohrCoulomb softening_soil() {
  MohrCoulomb law = soil(5e3, 30, 12);
  law.residual_cohesion = 1e3;
  law.residual_friction_angle = 22 * degree;
  law.residual_dilatancy_angle = 0.0;
  law.softening_start = 0.02;
  law.softening_end = 0.5;
  return law;
}

/// The surface that a step ends on is that of the plastic strain it ends with, whatever softens or hardens.
TEST(MohrCoulomb, RandomReturnsWithSoftening) {
  RandomStrain random;
  MohrCoulomb cut = softening_soil(), sharp = softening_soil(), hardening = soil(2e3, 20, 0),
              to_tresca = soil(5e3, 20, 0);
  cut.tensile_strength = 1e3;
  sharp.softening_end = 0.03;
  hardening.residual_cohesion = 8e3;
  hardening.residual_friction_angle = 30 * degree;
  hardening.softening_end = 0.3;
  to_tresca.residual_friction_angle = 0.0;
  to_tresca.softening_end = 0.3;
  for (const MohrCoulomb& law : {softening_soil(), cut, sharp, hardening, to_tresca}) {
    long plastic = 0, jumps = 0;
    for (int k = 0; k < 20000; ++k) {
      Point<MohrCoulomb> point(law);
      point.state[MohrCoulomb::accumulated] = 0.1 * (k % 4);
      const double size = std::pow(10.0, -2.0 + k % 3), old = point.state[MohrCoulomb::accumulated];
      Voigt strain = random(size, k % 2 == 0);
      strain.head<3>().array() += (k % 7 - 4) * 0.5 * size;
      point.step(strain);
      const double kappa = point.out.plastic_strain;
      ASSERT_LT(excess(law, law.strength(kappa), point.out.stress), 1e-10) << k;
      ASSERT_GE(point.out.dissipated, -1e-14 * (point.out.stress.norm() + 1e-6) * strain.norm());
      if (kappa == old) continue;
      const Voigt flow = tensor_components(strain - point.elastic());
      const double amount = std::sqrt(2.0 / 3.0 * (flow.head<3>().squaredNorm() + 2.0 * flow.tail<3>().squaredNorm()));
      ++plastic;
      if (std::abs(old + amount - kappa) > 1e-10 * kappa) ++jumps;
    }
    EXPECT_GT(plastic, 5000);
    EXPECT_EQ(jumps, 0);
  }
}

TEST(MohrCoulomb, TangentInEveryRegion) {
  auto list = variants();
  for (double ft : {MohrCoulomb::no_cut_off, 1e3}) {
    list.push_back({"softening", softening_soil()});
    list.back().law.tensile_strength = ft;
    list.push_back({"hardening", soil(2e3, 20, 0)});
    list.back().law.residual_cohesion = 8e3;
    list.back().law.softening_end = 0.3;
    list.back().law.tensile_strength = ft;
  }
  RandomStrain random;
  for (const auto& [name, law] : list) {
    std::map<int, int> hits, misses;
    double worst = 0.0;
    for (int k = 0; k < 2000; ++k) {
      Point<MohrCoulomb> point(law);
      point.step(random(0.02, k % 2 == 0));
      Voigt strain = random(0.05, k % 4 < 2);
      strain.head<3>().array() += (k % 5 - 2.5) * 0.03;
      double kappa = point.state[6];
      MohrCoulomb::Returned r;
      ASSERT_TRUE(law.return_map(SortedPrincipal(point.law_strain(strain)).value, kappa, r));
      const double error = tangent_error(point, strain);
      ++hits[r.region];
      // Differences across a border between regions, of the softening branch or of the principal order say nothing.
      if (error > (r.vertex ? 1e-4 : 1e-6))  // at a vertex, of next to nothing
        ++misses[r.region];
      else
        worst = std::max(worst, error);
    }
    for (const auto& [region, n] : hits) EXPECT_LE(misses[region], n / 200 + 1) << name << ": region " << region;
    EXPECT_GE(hits.size(), law.friction_angle > 0.0 || law.tensile_strength < MohrCoulomb::no_cut_off ? 4u : 2u)
        << name;
    int all_misses = 0;
    for (const auto& [region, n] : misses) all_misses += n;
    std::printf("%-40s worst tangent error %.1e, regions %zu, across borders %d\n", name.c_str(), worst, hits.size(),
                all_misses);
  }
}

/// A trial strain that is symmetric about an axis returns to an edge, one beyond the apex to the apex.
TEST(MohrCoulomb, EdgesFromEqualStrainsAndApexFromTension) {
  const MohrCoulomb law = soil(5e3, 25, 7);
  const double tip = law.cohesion / std::tan(law.friction_angle);
  for (const Voigt& strain : {strain_of(0.1, 0.1, 0.1), strain_of(0.11, 0.1, 0.1), strain_of(0.1, 0.11, 0.09, 0.01)}) {
    Point<MohrCoulomb> point(law);
    point.step(strain);
    EXPECT_LT((point.out.stress - tip * strain_of(1, 1, 1)).norm(), 1e-12 * tip);
    EXPECT_GT(Eigen::SelfAdjointEigenSolver<Voigt66>(point.out.tangent).eigenvalues()[0], 0.0);
  }
  const Vec3 axes[] = {Vec3(0.02, -0.03, -0.03), Vec3(0.02, 0.02, -0.03)};
  for (const Vec3& e : axes) {
    double kappa = 0.0;
    MohrCoulomb::Returned r;
    ASSERT_TRUE(law.return_map(e, kappa, r));
    EXPECT_EQ(r.region, e[1] == e[2] ? MohrCoulomb::edge_23 : MohrCoulomb::edge_12);
    EXPECT_NEAR(r.stress[1], e[1] == e[2] ? r.stress[2] : r.stress[0], 1e-12 * r.stress.norm());
  }
}

TEST(MohrCoulomb, WithoutCohesionTheApexIsFreeOfStress) {
  const MohrCoulomb law = soil(0.0, 37, 0);
  Point<MohrCoulomb> point(law);
  for (double x : {1e-3, 0.1, 10.0}) {
    const LawOutput& out = point.step(strain_of(x, x, 0.5 * x, 0.1 * x));
    EXPECT_EQ(out.stress.norm(), 0.0);
    EXPECT_EQ(out.dissipated, 0.0);
    EXPECT_EQ(out.stored_energy, 0.0);
    Voigt66 elastic;
    law.lame().stiffness(MohrCoulomb::residual_stiffness, elastic);
    EXPECT_LT((out.tangent - elastic).norm(), 1e-12 * elastic.norm());
  }
  // Squeezed again it carries at once: the plastic strain is not undone first.
  const Voigt open = point.last_strain;
  point.step(open + strain_of(-0.01, -0.01, -0.01));
  EXPECT_NEAR(point.out.stress[XX], -0.03 * law.lame().bulk(), 1e-9 * law.lame().bulk());
}

/// Tresca: s1 - s3 = 2 c whatever the pressure, no change of volume.
TEST(MohrCoulomb, WithoutFrictionItIsTresca) {
  const MohrCoulomb law = soil(5e3, 0);
  for (double pressure : {-1e6, 0.0, 1e6}) {
    Point<MohrCoulomb> point = confined_point(law, pressure);
    point.step(strain_of(-0.3, 0.1, 0.2, 0.05));
    const Vec3 s = Eigen::SelfAdjointEigenSolver<Mat3>(tensor(point.out.stress)).eigenvalues();
    EXPECT_NEAR(s[2] - s[0], 2.0 * law.cohesion, 1e-8 * law.cohesion);
    EXPECT_NEAR(point.out.stress.head<3>().sum() / 3.0, -pressure, 1e-9 * (std::abs(pressure) + law.cohesion));
  }
}

TEST(MohrCoulomb, AssociatedTangentIsSymmetricOthersAreNot) {
  for (double psi : {25.0, 0.0}) {
    Point<MohrCoulomb> point(soil(5e3, 25, psi));
    const Voigt66 d = point.trial(strain_of(0.02, -0.05, 0.0, 0.01)).tangent;
    const double skew = (d - d.transpose()).norm() / d.norm();
    EXPECT_TRUE(psi > 0.0 ? skew < 1e-12 : skew > 1e-2) << skew;
  }
}

TEST(MohrCoulomb, CutOffHoldsTheTensileStrength) {
  MohrCoulomb law = soil(5e3, 25, 7);
  law.tensile_strength = 2e3;
  Point<MohrCoulomb> tension(law);
  tension.step(lateral_control(tension, 0.01, 0.0, true));
  EXPECT_NEAR(tension.out.stress[XX], 2e3, 1e-8 * 2e3);
  EXPECT_LT(tension.out.stress.tail<5>().norm(), 1e-8 * 2e3);
  Point<MohrCoulomb> all(law);
  all.step(strain_of(0.1, 0.1, 0.1));
  EXPECT_LT((all.out.stress - 2e3 * strain_of(1, 1, 1)).norm(), 1e-8 * 2e3);
}

/// Triaxial test on softening soil: the strength belongs to the accumulated plastic strain, eq. (28).
TEST(MohrCoulomb, StrengthFollowsThePlasticStrain) {
  const MohrCoulomb law = softening_soil();
  Point<MohrCoulomb> point = confined_point(law, 20e3);
  bool before = false, between = false, after = false;
  for (int i = 1; i <= 100; ++i) {
    const double old = point.state[6];
    const Voigt old_plastic = point.last_strain - point.elastic();
    point.step(lateral_control(point, -0.01 * i, 20e3, true));
    const double kappa = point.out.plastic_strain;
    const Voigt flow = point.last_strain - point.elastic() - old_plastic;
    EXPECT_NEAR(kappa - old, std::sqrt(2.0 / 3.0) * flow.norm(), 1e-12);
    if (kappa == 0.0) continue;
    const double t = std::clamp((kappa - 0.02) / 0.48, 0.0, 1.0), c = 5e3 - 4e3 * t, kp = passive(30 - 8 * t);
    const double strength = 20e3 * kp + 2.0 * c * std::sqrt(kp);
    EXPECT_NEAR(point.out.stress[XX], -strength, 1e-8 * strength);
    (t == 0.0 ? before : t < 1.0 ? between : after) = true;
  }
  EXPECT_TRUE(before && between && after);
}

/// Softening that no point can follow (it would snap back) still ends on the surface.
TEST(MohrCoulomb, SuddenSofteningEndsOnTheResidualSurface) {
  MohrCoulomb law = softening_soil();
  law.softening_start = 0.0;
  law.softening_end = 1e-6;
  Point<MohrCoulomb> point(law);
  for (int i = 1; i <= 20; ++i) {
    point.step(winding_path(0.01, 0.05 * i));
    const double kappa = point.out.plastic_strain;
    EXPECT_LT(excess(law, law.strength(kappa), point.out.stress), 1e-10);
  }
  EXPECT_GT(point.out.plastic_strain, 1e-6);
}

TEST(MohrCoulomb, WorkIsStoredOrDissipated) {
  MohrCoulomb cut = soil(5e3, 25, 7);
  cut.tensile_strength = 1e3;
  for (const MohrCoulomb& law : {soil(5e3, 25, 0), soil(5e3, 25, 25), soil(5e3, 0), cut, softening_soil()}) {
    const auto path = [](double t) { return winding_path(0.05, t); };
    const double coarse = energy_defect(law, path, 500), fine = energy_defect(law, path, 1000);
    EXPECT_LT(fine, 2e-3);
    EXPECT_GT(coarse / fine, 1.8) << coarse << " -> " << fine;
  }
}

TEST(MohrCoulomb, ElasticStepsKeepTheStrainToTheLastBit) {
  const MohrCoulomb law = soil(5e3, 25, 7);
  RandomStrain random;
  int elastic = 0;
  for (int k = 0; k < 1000; ++k) {
    Point<MohrCoulomb> point(law);
    const Voigt strain = random(1e-3, k % 2 == 0);
    point.step(strain);
    if (point.out.plastic_strain > 0.0) continue;
    ++elastic;
    EXPECT_EQ((point.elastic() - strain).norm(), 0.0);
    EXPECT_EQ((point.out.stress - law.lame().stress(strain)).norm(), 0.0);
  }
  EXPECT_GT(elastic, 500);
}

TEST(MohrCoulomb, ParametersThatCannotBeAreRefused) {
  EXPECT_EQ(soil(5e3, 25, 25).check(1.0), "");
  EXPECT_NE(soil(5e3, 25, 26).check(1.0).find("dilatancy_angle"), std::string::npos);
  EXPECT_NE(soil(0, 0).check(1.0).find("no strength"), std::string::npos);
  MohrCoulomb law = softening_soil();
  EXPECT_EQ(law.check(1.0), "");
  law.residual_dilatancy_angle = 23 * degree;
  EXPECT_NE(law.check(1.0).find("residual dilatancy"), std::string::npos);
  law = softening_soil();
  law.softening_end = 0.0;
  EXPECT_NE(law.check(1.0).find("softening_end"), std::string::npos);
}

}  // namespace
}  // namespace berm::test
