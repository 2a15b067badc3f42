/// Closed forms of the laws with exponential softening along proportional stress paths (docs/theory/damage.md, sections
/// "Proportional paths" and the table of each law).

#include "law/plane_stress.hpp"
#include "law_fixture.hpp"

namespace berm::test {
namespace {

struct Path {
  const char* name;
  Voigt stress;        ///< unit pattern S
  double theta;        ///< share of tension
  double strength;     ///< p*/ft of the table, printed to about 1e-5
  double dissipation;  ///< in units of Gf, of the table
};

Voigt pattern(double xx, double yy, double zz, double xy = 0.0) {
  Voigt s;
  s << xx, yy, zz, xy, 0.0, 0.0;
  return s;
}

const double a0 = nu / (1.0 - nu);

std::vector<Path> simo_ju_paths() {
  const double n2 = strength_ratio * strength_ratio;
  return {{"tension", pattern(1, 0, 0), 1, 1.0, 1},
          {"tension, plane strain", pattern(1, 0, nu), 1, 1.02062, 1},
          {"compression", pattern(-1, 0, 0), 0, 12.3, n2},
          {"compression, plane strain", pattern(-1, 0, -nu), 0, 12.5536, n2},
          {"uniaxial strain, tension", pattern(1, a0, a0), 1, 1.05409, 1},
          {"uniaxial strain, compression", pattern(-1, -a0, -a0), 0, 12.965, n2},
          {"shear", pattern(0, 0, 0, 1), 0.5, 1.19393, 3.421},
          {"shear in principal axes", pattern(1, -1, 0), 0.5, 1.19393, 3.421},
          {"equibiaxial tension", pattern(1, 1, 0), 1, 0.79057, 1},
          {"equibiaxial compression", pattern(-1, -1, 0), 0, 9.7240, n2},
          {"Brazilian, plane stress", pattern(1, -3, 0), 0.25, 0.96087, 10.341},
          {"Brazilian, plane strain", pattern(1, -3, -0.4), 1.0 / 4.4, 1.03747, 11.883},
          {"hydrostatic compression", pattern(-1, -1, -1), 0, 27.962e6 / ft, n2},
          {"confined compression", pattern(-1, -0.1, -0.1), 0, 38.776e6 / ft, n2}};
}

/// Checks sigma = (elastic up to p*, then p* exp[A (1 - x)]) S and the energy along e = x e*, eqs. (15)-(17).
template <class L>
void expect_exponential_path(const L& law, const Voigt& s, double peak, double length) {
  Point<L> point(law, length);
  const Voigt strain_at_peak = peak * compliance(s);
  const double a = 1.0 / (young * gf / (length * ft * ft) - 0.5);
  point.step(0.999999 * strain_at_peak);
  EXPECT_EQ(point.out.damage, 0.0);
  for (double x : {1.000001, 1.5, 2.0, 5.0, 10.0, 20.0}) {
    point.step(x * strain_at_peak);
    const double p = peak * std::exp(a * (1.0 - x));
    if (1.0 - p / (peak * x) > max_damage) continue;
    EXPECT_LT((point.out.stress - p * s).norm(), 1e-8 * p * s.norm()) << x;
    EXPECT_NEAR(point.out.damage, 1.0 - p / (peak * x), 1e-8);
    EXPECT_NEAR(point.out.stored_energy, 0.5 * x * p * s.dot(strain_at_peak), 1e-8 * point.out.stored_energy);
  }
}

/// Dissipation per area up to the cut-off damage by many steps, plus what the cut-off leaves undissipated: eq. (17).
template <class L>
void expect_dissipation(const L& law, const Voigt& s, double peak, double length, double expected) {
  Point<L> point(law, length);
  const Voigt strain_at_peak = peak * compliance(s);
  double x = 1.0;
  for (; point.out.damage < max_damage; x *= 1.0005) point.step(x * strain_at_peak);
  const double share = 1.0 - undissipated_share(x, length);
  EXPECT_NEAR(point.dissipated * length, share * expected, 2e-4 * expected) << length;
}

TEST(SimoJu, FollowsTheClosedFormsOfEveryPath) {
  const SimoJu law = concrete<SimoJu>();
  for (const Path& path : simo_ju_paths()) {
    SCOPED_TRACE(path.name);
    const double k = path.theta + (1.0 - path.theta) / strength_ratio;
    const double peak = ft / (k * std::sqrt(energy_of_pattern(path.stress)));
    EXPECT_NEAR(peak / ft, path.strength, 4e-5 * path.strength);
    for (double length : {0.005, 0.1}) expect_exponential_path(law, path.stress, peak, length);
  }
}

TEST(SimoJu, DissipatesTheTabulatedMultipleOfTheFractureEnergy) {
  const SimoJu law = concrete<SimoJu>();
  for (const Path& path : simo_ju_paths()) {
    SCOPED_TRACE(path.name);
    for (double length : {0.005, 0.02, 0.1}) {
      expect_dissipation(law, path.stress, path.strength * ft, length, path.dissipation * gf);
    }
  }
}

TEST(SimoJu, ReproducesThePrintedSofteningCurves) {
  const std::vector<double> x = {1, 2, 5, 10, 20, 50, 100, 200, 300};
  const std::vector<double> mpa = {3.05000, 3.01004, 2.89327, 2.70864, 2.37396, 1.59824, 0.82653, 0.22105, 0.05912};
  Point<SimoJu> point(concrete<SimoJu>(), 0.005);
  for (std::size_t i = 0; i < x.size(); ++i) {
    point.step(x[i] * onset * compliance(pattern(young, 0, 0)));
    EXPECT_NEAR(point.out.stress[XX], mpa[i] * 1e6, 6.0);
  }
  const std::vector<double> compression = {37.5150, 27.7487, 11.2294, 2.4862};
  Point<SimoJu> crushed(concrete<SimoJu>(), 0.1);
  for (std::size_t i = 0; i < compression.size(); ++i) {
    crushed.step(-x[i] * strength_ratio * onset * compliance(pattern(young, 0, 0)));
    EXPECT_NEAR(crushed.out.stress[XX], -compression[i] * 1e6, 60.0);
  }
}

TEST(SimoJu, SofteningModulusOfTheReferenceSizes) {
  const SimoJu law = concrete<SimoJu>();
  const std::vector<std::pair<double, double>> table = {
      {0.0025, 0.0065726}, {0.005, 0.0131885}, {0.00648148, 0.0171297}, {0.0065, 0.0171790}, {0.0075, 0.0198482},
      {0.01, 0.0265521},   {0.017, 0.0455620}, {0.018, 0.0483069},      {0.1, 0.3015519}};
  for (const auto& [length, a] : table) EXPECT_NEAR(law.softening_modulus(length), a, 1e-7) << length;
}

TEST(SimoJu, ReachesDamage099WhereTheTableSays) {
  const std::vector<std::pair<double, double>> table = {{0.0025, 65.46}, {0.005, 51.43}, {0.01, 37.72}, {0.1, 8.99}};
  for (const auto& [length, x] : table) {
    const Point<SimoJu> point(concrete<SimoJu>(), length);
    const Voigt strain = onset * compliance(pattern(young, 0, 0));
    EXPECT_LT(point.trial((x - 0.006) * strain).damage, 0.99);
    EXPECT_GT(point.trial((x + 0.006) * strain).damage, 0.99);
  }
}

TEST(SimoJu, PlaneStressWrapperGivesThePlaneStressRows) {
  const SimoJu law = concrete<SimoJu>();
  Point<SimoJu> point(law);
  LawInput in = point.in;
  std::vector<double> next(SimoJu::n_state);
  LawOutput out;
  double strain_zz = 0.0;
  for (const auto& [s, strength] : {std::pair{pattern(1, 0, 0), 1.0}, std::pair{pattern(1, 1, 0), 0.79057},
                                    std::pair{pattern(-1, -1, 0), 9.7240}, std::pair{pattern(1, -3, 0), 0.96087}}) {
    const Voigt strain = strength * ft * compliance(s);
    in.strain = strain;
    in.strain[ZZ] = 0.0;
    ASSERT_EQ(update_plane_stress(law, in, point.state.data(), next.data(), out, strain_zz), Status::ok);
    EXPECT_NEAR(out.stress[XX] / ft, strength * s[XX], 2e-5 * strength);
    EXPECT_NEAR(strain_zz, strain[ZZ], 1e-12 * strain.norm());
    EXPECT_LE(std::abs(out.stress[ZZ]), 1e-12 * out.stress.norm());
  }
}

TEST(Rankine, FailsAtTheTensileStrengthOfTheLargestPrincipalStress) {
  const Rankine law = concrete<Rankine>();
  for (const Path& path : simo_ju_paths()) {
    SCOPED_TRACE(path.name);
    const double largest = tensor(path.stress).selfadjointView<Eigen::Lower>().eigenvalues().maxCoeff();
    if (largest < 1e-12) {
      EXPECT_EQ(Point<Rankine>(law).trial(1000.0 * ft * compliance(path.stress)).damage, 0.0);
      continue;
    }
    expect_exponential_path(law, path.stress, ft / largest, 0.05);
    const double expected = energy_of_pattern(path.stress) / (largest * largest);  // eq. (17)
    expect_dissipation(law, path.stress, ft / largest, 0.05, expected * gf);
  }
}

TEST(Lemaitre, StrainNormFollowsItsClosedForms) {
  const LemaitreStrain law = concrete<LemaitreStrain>();
  for (const Path& path : simo_ju_paths()) {
    SCOPED_TRACE(path.name);
    const double norm = young * tensor(tensor_components(compliance(path.stress))).norm();
    const double peak = ft * std::sqrt(1.0 + 2.0 * nu * nu) / norm;
    expect_exponential_path(law, path.stress, peak, 0.05);
    const double expected = energy_of_pattern(path.stress) * peak * peak / (ft * ft);
    expect_dissipation(law, path.stress, peak, 0.05, expected * gf);
  }
}

TEST(Lemaitre, EnergyNormDissipatesTheFractureEnergyOnEveryPath) {
  const LemaitreEnergy law = concrete<LemaitreEnergy>();
  for (const Path& path : simo_ju_paths()) {
    SCOPED_TRACE(path.name);
    const double peak = ft / std::sqrt(energy_of_pattern(path.stress));
    expect_exponential_path(law, path.stress, peak, 0.05);
    expect_dissipation(law, path.stress, peak, 0.05, 1.0 * gf);
  }
}

/// Strengths over ft of the table in docs/theory/damage.md (nu = 0.2), worked out there by hand.
TEST(Lemaitre, ShearAndHydrostaticStrengths) {
  const auto peak = [](const auto& law, const Voigt& s, double expected) {
    Point point(law);
    EXPECT_EQ(point.trial((expected - 1e-5) * ft * compliance(s)).damage, 0.0);
    EXPECT_GT(point.trial((expected + 1e-5) * ft * compliance(s)).damage, 0.0);
  };
  peak(concrete<LemaitreStrain>(), pattern(-1, 0, 0), 1.0);
  peak(concrete<LemaitreStrain>(), pattern(0, 0, 0, 1), 0.612372);
  peak(concrete<LemaitreStrain>(), pattern(-1, -1, -1), 1.0);
  peak(concrete<LemaitreEnergy>(), pattern(-1, 0, 0), 1.0);
  peak(concrete<LemaitreEnergy>(), pattern(0, 0, 0, 1), 0.645497);
  peak(concrete<LemaitreEnergy>(), pattern(-1, -1, -1), 0.745356);
}

}  // namespace
}  // namespace berm::test
