/// From deformation gradients to stress: kinematics, plane stress, and the tangent of the internal force.

#include "law/point_response.hpp"
#include "law_fixture.hpp"

namespace berm::test {
namespace {

constexpr Space all_spaces[] = {Space::plane_strain, Space::plane_stress, Space::axisymmetric, Space::solid};

struct Response : PointResponse {
  double strain_zz = 0.0;
  Eigen::MatrixXd tangent;
};

template <class L, int components>
Response respond_with(const L& law, Space space, Kinematics kinematics, const Mat3& f, double length) {
  std::vector<double> old_state(L::n_state), next(L::n_state);
  law.initial_state(old_state.data());
  LawInput settings;
  settings.length = length;
  Response out;
  Modulus<components> tangent;
  EXPECT_EQ(point_response<components>(law, space, kinematics, Mat3::Identity(), f, settings, old_state.data(),
                                       next.data(), out.strain_zz, out, &tangent),
            Status::ok);
  out.tangent = tangent;
  return out;
}

/// Response of a fresh point.
template <class L>
Response respond(const L& law, Space space, Kinematics kinematics, const Mat3& f, double length = 0.02) {
  switch (space) {
    case Space::solid:
      return respond_with<L, 9>(law, space, kinematics, f, length);
    case Space::axisymmetric:
      return respond_with<L, 5>(law, space, kinematics, f, length);
    default:
      return respond_with<L, 4>(law, space, kinematics, f, length);
  }
}

/// Stress that is work-conjugate to the displacement gradient on the reference configuration.
template <class L>
Mat3 nominal(const L& law, Space space, Kinematics kinematics, const Mat3& f) {
  const Mat3 stress = tensor(respond(law, space, kinematics, f).stress);
  return kinematics == Kinematics::small ? stress : Mat3(stress * f.inverse().transpose());
}

/// Norms of the tangent and of its distance from central differences of the force; h: step of l = dF F^-1.
template <class L>
std::pair<double, double> tangent_error_of_force(const L& law, Space space, Kinematics kinematics, const Mat3& f,
                                                 double h) {
  const Eigen::MatrixXd tangent = respond(law, space, kinematics, f).tangent;
  const auto at = places(space);
  Eigen::MatrixXd numerical(at.size(), at.size());
  for (std::size_t column = 0; column < at.size(); ++column) {
    Mat3 l = Mat3::Zero();
    l(at[column].first, at[column].second) = h;
    const Mat3 df = kinematics == Kinematics::small ? l : Mat3(l * f);
    Mat3 d = (nominal(law, space, kinematics, f + df) - nominal(law, space, kinematics, f - df)) / (2.0 * h);
    if (kinematics == Kinematics::finite) d = d * f.transpose();  // to gradients on the current configuration
    for (std::size_t row = 0; row < at.size(); ++row) numerical(row, column) = d(at[row].first, at[row].second);
  }
  return {tangent.norm(), (tangent - numerical).norm()};
}

Mat3 random_gradient(RandomStrain& random, double size, Space space) {
  const Voigt a = random(size, false), b = random(size, false);
  Mat3 h = Mat3::Zero();
  h.topLeftCorner<2, 2>() << a[0], a[1], a[2], a[3];
  if (space == Space::axisymmetric) h(2, 2) = a[4];
  if (space == Space::solid) h << a[0], a[1], a[2], a[3], a[4], a[5], b[0], b[1], b[2];
  return h;
}

/// Any in space, about z otherwise.
Mat3 random_rotation(RandomStrain& random, Space space) {
  const Mat3 q = random.rotation();
  if (space == Space::solid) return q;
  return Eigen::AngleAxisd(std::atan2(q(1, 0), q(0, 0)), Vec3::UnitZ()).toRotationMatrix();
}

template <class L>
struct EveryPoint : ::testing::Test {
  L law = concrete<L>();
  RandomStrain random;
};
// Laws that keep their elastic strain: test_elastic_strain.cpp.
TYPED_TEST_SUITE(EveryPoint, DamageLaws);

TYPED_TEST(EveryPoint, TangentMatchesFiniteDifferencesOfTheForce) {
  for (int k = 0; k < 800; ++k) {
    const Space space = all_spaces[k % 4];
    const Kinematics kinematics = k / 4 % 2 ? Kinematics::finite : Kinematics::small;
    const double size = k % 3 ? 3.0 * onset : 0.02, h = 2e-6 * size;
    const Mat3 f = Mat3::Identity() + random_gradient(this->random, size, space);
    const double rounding = 5e-10 * young;  // of 1 - d, over the relative step 2e-6
    const auto [norm, error] = tangent_error_of_force(this->law, space, kinematics, f, h);
    ASSERT_LT(error, 1e-6 * norm + rounding) << "state " << k;
  }
}

/// Elastic, just past the threshold and far down the softening branch, in tension, compression and shear, the axes
/// anywhere; finite kinematics also turned by any angle.
TYPED_TEST(EveryPoint, TangentHoldsOnEveryBranchAndAnyTurn) {
  const Vec3 patterns[] = {{1.0, -0.15, -0.2}, {1.0, 0.3, 0.2},    {-1.0, 0.1, 0.16},
                           {-1.0, -0.3, -0.2}, {1.0, -1.1, -0.05}, {0.9, -2.8, -0.4}};
  int damaged = 0;
  for (const Space space : all_spaces)
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite})
      for (const Vec3& pattern : patterns) {
        const Mat3 q = random_rotation(this->random, space), turn = random_rotation(this->random, space);
        const auto gradient = [&](double size) -> Mat3 {
          Vec3 e = size * pattern;
          if (space == Space::plane_strain || space == Space::plane_stress) e[2] = 0.0;
          if (kinematics == Kinematics::small) return Mat3::Identity() + q * e.asDiagonal() * q.transpose();
          return turn * q * Vec3(e.array().exp()).asDiagonal() * q.transpose();
        };
        const auto damage = [&](double size) { return respond(this->law, space, kinematics, gradient(size)).damage; };
        double below = 0.0, threshold = 40.0 * onset;  // size at which damage starts, by bisection
        if (damage(threshold) > 0.0)
          for (int i = 0; i < 40; ++i) {
            const double middle = 0.5 * (below + threshold);
            (damage(middle) > 0.0 ? threshold : below) = middle;
          }
        for (double factor : {0.6, 1.01, 3.0, 15.0}) {
          const double size = factor * threshold;
          const auto [norm, error] = tangent_error_of_force(this->law, space, kinematics, gradient(size), 2e-5 * size);
          EXPECT_LT(error, 1e-6 * norm + 5e-10 * young)
              << "space " << int(space) << (kinematics == Kinematics::finite ? " finite " : " small ")
              << pattern.transpose() << ", " << factor << " of the threshold";
          damaged += damage(size) > 0.0;
        }
      }
  if (TypeParam::n_state > 0) {
    EXPECT_GT(damaged, 60);
  }
}

TYPED_TEST(EveryPoint, SmallAndFiniteAgreeForTinyGradients) {
  for (const Space space : all_spaces) {
    const Mat3 f = Mat3::Identity() + random_gradient(this->random, 1e-8, space);
    const Response small = respond(this->law, space, Kinematics::small, f);
    const Response finite = respond(this->law, space, Kinematics::finite, f);
    EXPECT_LT((small.stress - finite.stress).norm(), 1e-7 * small.stress.norm());
    EXPECT_LT((small.tangent - finite.tangent).norm(), 1e-7 * small.tangent.norm());
  }
}

TYPED_TEST(EveryPoint, RigidRotationMakesNoStressAndTurnsIt) {
  const Mat3 quarter = Eigen::AngleAxisd(0.7, Vec3::UnitZ()).toRotationMatrix();
  for (const Space space : all_spaces)
    for (int k = 0; k < 20; ++k) {
      const Mat3 q = k == 0 ? quarter : random_rotation(this->random, space);
      EXPECT_LT(respond(this->law, space, Kinematics::finite, q).stress.norm(), 1e-14 * young);
      Mat3 f = Mat3::Identity();
      f.topLeftCorner<2, 2>() << 1.0 + 4.0 * onset, 2.0 * onset, -onset, 1.0 + onset;
      if (k > 0) f = Mat3::Identity() + random_gradient(this->random, k % 2 ? 3.0 * onset : 0.02, space);
      const Response straight = respond(this->law, space, Kinematics::finite, f);
      const Response turned = respond(this->law, space, Kinematics::finite, q * f);
      const Mat3 expected = q * tensor(straight.stress) * q.transpose();
      EXPECT_LT((tensor(turned.stress) - expected).norm(), 1e-9 * expected.norm());
      EXPECT_NEAR(turned.damage, straight.damage, 1e-10);
    }
}

/// The plane and the axisymmetric model are cuts through the solid.
TYPED_TEST(EveryPoint, SolidOfAPlaneGradientIsPlaneStrain) {
  for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite})
    for (const Space space : {Space::plane_strain, Space::axisymmetric})
      for (int k = 0; k < 20; ++k) {
        const Mat3 f = Mat3::Identity() + random_gradient(this->random, k % 2 ? 3.0 * onset : 0.02, space);
        const Response flat = respond(this->law, space, kinematics, f);
        const Response solid = respond(this->law, Space::solid, kinematics, f);
        EXPECT_LT((flat.stress - solid.stress).norm(), 1e-9 * solid.stress.norm());
        EXPECT_LT((flat.strain - solid.strain).norm(), 1e-12 * solid.strain.norm());
        EXPECT_NEAR(flat.damage, solid.damage, 1e-10);
        const auto at = places(space);
        Eigen::MatrixXd part(at.size(), at.size());
        for (std::size_t i = 0; i < at.size(); ++i)
          for (std::size_t j = 0; j < at.size(); ++j)
            part(i, j) = solid.tangent(3 * at[i].first + at[i].second, 3 * at[j].first + at[j].second);
        EXPECT_LT((flat.tangent - part).norm(), 1e-8 * part.norm());
      }
}

TYPED_TEST(EveryPoint, PlaneStressLeavesNoStressAcross) {
  for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite}) {
    for (int k = 0; k < 100; ++k) {
      const Response out = respond(this->law, Space::plane_stress, kinematics,
                                   Mat3::Identity() + random_gradient(this->random, 4.0 * onset, Space::plane_stress));
      EXPECT_LE(std::abs(out.stress[ZZ]), 1e-12 * out.stress.norm());
      EXPECT_EQ(out.strain[ZZ], out.strain_zz);
      EXPECT_NE(out.strain_zz, 0.0);
    }
  }
}

TYPED_TEST(EveryPoint, TangentIsLeftAloneUnlessAskedFor) {
  std::vector<double> old_state(TypeParam::n_state), next(TypeParam::n_state);
  this->law.initial_state(old_state.data());
  LawInput settings;
  settings.length = 0.02;
  const Mat3 f = Mat3::Identity() + random_gradient(this->random, 3.0 * onset, Space::solid);
  double strain_zz = 0.25;
  PointResponse out;
  ASSERT_EQ(point_response<9>(this->law, Space::solid, Kinematics::finite, Mat3::Identity(), f, settings,
                              old_state.data(), next.data(), strain_zz, out),
            Status::ok);
  EXPECT_EQ((out.stress - respond(this->law, Space::solid, Kinematics::finite, f).stress).norm(), 0.0);
  EXPECT_EQ(strain_zz, 0.25);
}

/// Strains that the solid takes as they are: small, or the logarithm of the stretch, turned.
Mat3 gradient_of(const Voigt& strain, Kinematics kinematics, const Mat3& turn) {
  const Mat3 e = tensor(tensor_components(strain));
  if (kinematics == Kinematics::small) return Mat3::Identity() + e;
  const Eigen::SelfAdjointEigenSolver<Mat3> spectrum(e);
  const Mat3 n = spectrum.eigenvectors();
  return turn * n * Vec3(spectrum.eigenvalues().array().exp()).asDiagonal() * n.transpose();
}

TEST(Solid, UniaxialStressOfHookesAndHenckysSolid) {
  const LinearElastic law = concrete<LinearElastic>();
  RandomStrain random;
  for (double stretch : {0.7, 0.999, 1.3, 2.0}) {
    const double across = std::pow(stretch, -nu);
    const Mat3 turn = random.rotation(), axes = random.rotation();
    const Mat3 f = turn * axes * Vec3(stretch, across, across).asDiagonal() * axes.transpose();
    const Vec3 n = turn * axes.col(0);
    const Mat3 expected = young * std::log(stretch) * n * n.transpose();
    const Response out = respond(law, Space::solid, Kinematics::finite, f);
    EXPECT_LT((tensor(out.stress) - expected).norm(), 1e-12 * young);
    EXPECT_NEAR(out.stored_energy, 0.5 * young * std::pow(std::log(stretch), 2), 1e-11 * young);
  }
  const Mat3 f = Vec3(1.0 + 1e-3, 1.0 - nu * 1e-3, 1.0 - nu * 1e-3).asDiagonal();
  const Mat3 expected = Vec3(young * 1e-3, 0.0, 0.0).asDiagonal();
  EXPECT_LT((tensor(respond(law, Space::solid, Kinematics::small, f).stress) - expected).norm(), 1e-14 * young);
}

/// Peaks of the table in docs/theory/damage.md, section "Simo-Ju", and eq. (16) beyond.
TEST(Solid, SimoJuPeaksWhereTheTableSays) {
  const SimoJu law = concrete<SimoJu>();
  const auto pattern = [](double xx, double yy, double zz, double xy, double yz, double zx) {
    Voigt s;
    s << xx, yy, zz, xy, yz, zx;
    return s;
  };
  const double confined = 12.713 / strength_ratio;
  const std::vector<std::pair<Voigt, double>> table = {{pattern(1, 0, 0, 0, 0, 0), 1.0},
                                                       {pattern(0, 0, 1, 0, 0, 0), 1.0},
                                                       {pattern(0, -1, 0, 0, 0, 0), 12.3},
                                                       {pattern(0, 0, 0, 1, 0, 0), 1.19393},
                                                       {pattern(0, 0, 0, 0, 1, 0), 1.19393},
                                                       {pattern(0, 0, 0, 0, 0, 1), 1.19393},
                                                       {pattern(0, 1, 1, 0, 0, 0), 0.79057},
                                                       {pattern(-1, -1, -1, 0, 0, 0), 9.1679},
                                                       {pattern(-1, -0.1, -0.1, 0, 0, 0), confined * strength_ratio}};
  RandomStrain random;
  const double length = 0.02, a = 1.0 / (young * gf / (length * ft * ft) - 0.5);
  for (const auto& [s, strength] : table)
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite}) {
      const Mat3 turn = kinematics == Kinematics::finite ? random.rotation() : Mat3(Mat3::Identity());
      const Voigt at_peak = strength * ft * compliance(s);
      const auto at = [&](double x) {
        return respond(law, Space::solid, kinematics, gradient_of(x * at_peak, kinematics, turn), length);
      };
      EXPECT_EQ(at(1.0 - 6e-5).damage, 0.0) << s.transpose();
      EXPECT_GT(at(1.0 + 6e-5).damage, 0.0) << s.transpose();
      for (double x : {0.5, 2.0, 5.0}) {
        const double p = strength * ft * (x <= 1.0 ? x : std::exp(a * (1.0 - x)));
        const Mat3 expected = p * turn * tensor(s) * turn.transpose();
        EXPECT_LT((tensor(at(x).stress) - expected).norm(), 6e-5 * expected.norm()) << s.transpose() << " at " << x;
      }
    }
}

/// Any law without its own answer for the free strain: the Newton iteration must find it.
struct WithoutHint {
  SimoJu law = concrete<SimoJu>();
  static constexpr std::string_view name = "without_hint", doc = "Simo-Ju behind a wall.";
  static constexpr int n_state = SimoJu::n_state;
  static std::vector<Parameter<WithoutHint>> parameters() { return {}; }
  double stiffness() const { return law.stiffness(); }
  std::string check(double) const { return {}; }
  void initial_state(double* state) const { law.initial_state(state); }
  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return law.update(in, old_state, new_state, out);
  }
};

/// Rounding of the strain alone makes stresses zz beyond 1e-12 of the others.
TEST(PlaneStress, NearlyWithoutChangeOfVolume) {
  RandomStrain random;
  for (const double nu : {0.4999999, 0.49999999999}) {
    LinearElastic law;
    law.youngs_modulus = 1e9, law.poisson_ratio = nu;
    for (int k = 0; k < 100; ++k) {
      LawInput in;
      in.strain = random(1e-3, true);
      in.want_tangent = true;
      LawOutput out;
      double strain_zz = 0.0;
      ASSERT_EQ(update_plane_stress(law, in, nullptr, nullptr, out, strain_zz), Status::ok) << nu << " " << k;
      const double flat = law.youngs_modulus / (1.0 - nu * nu);
      EXPECT_NEAR(out.stress[XX], flat * (in.strain[XX] + nu * in.strain[YY]), 1e-5 * flat * in.strain.norm());
    }
  }
}

TEST(PlaneStress, NewtonFindsWhatTheLawWouldSay) {
  const WithoutHint hidden;
  std::vector<double> state(SimoJu::n_state), next(SimoJu::n_state), expected_next(SimoJu::n_state);
  hidden.initial_state(state.data());
  RandomStrain random;
  for (int k = 0; k < 200; ++k) {
    LawInput in;
    in.length = 0.005;
    in.strain = random(2.0 * onset, true);
    in.want_tangent = k % 2 == 0;
    LawOutput out, expected;
    double strain_zz = 0.0, expected_zz = 0.0;
    ASSERT_EQ(update_plane_stress(hidden, in, state.data(), next.data(), out, strain_zz), Status::ok) << k;
    ASSERT_EQ(update_plane_stress(hidden.law, in, state.data(), expected_next.data(), expected, expected_zz),
              Status::ok);
    EXPECT_NEAR(strain_zz, expected_zz, 1e-11 * in.strain.norm());
    EXPECT_LT((out.stress - expected.stress).norm(), 1e-10 * expected.stress.norm());
    if (!in.want_tangent) continue;
    EXPECT_LT((out.tangent - expected.tangent).norm(), 1e-8 * expected.tangent.norm());
  }
}

TEST(PlaneStress, CondensedElasticTangentIsTheTextbookOne) {
  const LinearElastic law = concrete<LinearElastic>();
  LawInput in;
  in.strain << 1e-5, 2e-5, 0.0, 3e-5, 0.0, 0.0;
  LawOutput out;
  double strain_zz = 0.0;
  ASSERT_EQ(update_plane_stress(law, in, nullptr, nullptr, out, strain_zz), Status::ok);
  const double m = young / (1.0 - nu * nu);
  EXPECT_NEAR(out.tangent(XX, XX), m, 1e-9 * m);
  EXPECT_NEAR(out.tangent(XX, YY), nu * m, 1e-9 * m);
  EXPECT_NEAR(out.tangent(XY, XY), young / (2.0 * (1.0 + nu)), 1e-9 * m);
  EXPECT_EQ(out.tangent.row(ZZ).norm() + out.tangent.col(ZZ).norm(), 0.0);
}

constexpr int orders = 2;

/// ln(F F^T)/2 of any F with 4, 5 or 9 components.
template <int components>
Voigt hencky(const Mat3& f) {
  Voigt strain;
  EXPECT_TRUE(hencky_strain<components>(f - Mat3::Identity(), strain, nullptr));
  return strain;
}

/// Distance of the rate from differences of fourth order along l.
template <int components>
double rate_error(const Mat3& f, Space space, double h = 3e-5) {
  Voigt strain;
  StrainRate<components> rate;
  EXPECT_TRUE(hencky_strain<components>(f - Mat3::Identity(), strain, &rate));
  const auto at = places(space);
  double worst = 0.0;
  for (int c = 0; c < components; ++c) {
    Mat3 l = Mat3::Zero();
    l(at[c].first, at[c].second) = h;
    Voigt numerical = Voigt::Zero();
    for (int k = 1; k <= orders; ++k) {
      const Voigt d = (hencky<components>(f + k * l * f) - hencky<components>(f - k * l * f)) / (2.0 * k * h);
      numerical += (k == 1 ? 4.0 / 3.0 : -1.0 / 3.0) * d;
    }
    for (int i = 0; i < strains_of(components); ++i) {
      worst = std::max(worst, std::abs(numerical[voigt_of(components, i)] - rate(i, c)));
    }
  }
  return worst / std::max(1.0, rate.norm());
}

TEST(Hencky, KeepsFullAccuracyForTinyStrains) {
  Mat3 h = Mat3::Zero();
  h.topLeftCorner<2, 2>() << 3e-12, 5e-12, -1e-12, 2e-12;
  Voigt strain;
  ASSERT_TRUE(hencky_strain<4>(h, strain, nullptr));
  EXPECT_NEAR(strain[XX], 3e-12, 1e-22);  // the quadratic terms are 1e-24 ...
  EXPECT_NEAR(strain[YY], 2e-12, 1e-22);
  EXPECT_NEAR(strain[XY], 4e-12, 1e-22);
  EXPECT_EQ(strain[ZZ], 0.0);
  h(2, 2) = -7e-12;
  ASSERT_TRUE(hencky_strain<5>(h, strain, nullptr));
  EXPECT_NEAR(strain[ZZ], -7e-12, 1e-22);
  RandomStrain random;
  for (int k = 0; k < 100; ++k) {
    h = random_gradient(random, 1e-12, Space::solid);
    ASSERT_TRUE(hencky_strain<9>(h, strain, nullptr));
    const Voigt expected = engineering(voigt(0.5 * (h + h.transpose())));
    EXPECT_LT((strain - expected).cwiseAbs().maxCoeff(), 1e-22);
  }
}

TEST(Hencky, IsTheLogarithmOfTheStretch) {
  const double angle = 0.3;
  const Mat3 q = Eigen::AngleAxisd(angle, Vec3::UnitZ()).toRotationMatrix();
  const Mat3 expected = q * Vec3(std::log(2.5), std::log(0.4), 0.0).asDiagonal() * q.transpose();
  const Mat3 f = q * Vec3(2.5, 0.4, 1.0).asDiagonal() * q.transpose();
  const Voigt strain = hencky<4>(f);
  EXPECT_NEAR(strain[XX], expected(0, 0), 1e-14);
  EXPECT_NEAR(strain[YY], expected(1, 1), 1e-14);
  EXPECT_NEAR(strain[XY], 2.0 * expected(0, 1), 1e-14);
}

/// F = R U: e = R ln(U) R^T, whatever the axes of U and the turn R.
TEST(Hencky, SolidIsTheLogarithmOfTheStretchTurned) {
  RandomStrain random;
  for (const Vec3& stretch : {Vec3(2.5, 0.4, 1.1), Vec3(1.0, 1.0, 1.0), Vec3(1.7, 1.7, 0.3), Vec3(0.6, 0.6, 0.6),
                              Vec3(1.0, 1.0 + 1e-9, 1.0 - 1e-9), Vec3(1.001, 0.999, 1.0)})
    for (int k = 0; k < 20; ++k) {
      const Mat3 q = random.rotation(), r = random.rotation();
      const Mat3 f = r * q * stretch.asDiagonal() * q.transpose();
      const Mat3 axes = r * q;
      const Mat3 expected = axes * Vec3(stretch.array().log()).asDiagonal() * axes.transpose();
      EXPECT_LT((hencky<9>(f) - engineering(voigt(expected))).norm(), 2e-14) << stretch.transpose();
    }
}

TEST(Hencky, SolidIsTheSeriesForModerateStrain) {
  RandomStrain random;
  for (int k = 0; k < 50; ++k) {
    const Mat3 h = random_gradient(random, 0.01, Space::solid);
    const Mat3 b = h + h.transpose() + h * h.transpose();
    Mat3 sum = Mat3::Zero(), power = Mat3::Identity();
    for (int n = 1; n <= 20; ++n) {
      power = power * b;
      sum += (n % 2 ? 0.5 : -0.5) / n * power;
    }
    EXPECT_LT((hencky<9>(Mat3::Identity() + h) - engineering(voigt(sum))).norm(), 1e-15);
  }
}

/// Plane and axisymmetric versions against the solid one, strain and rate.
TEST(Hencky, SolidContainsThePlaneAndTheAxisymmetricVersion) {
  const auto same = []<int components>(const Mat3& f, Space space) {
    Voigt flat, solid;
    StrainRate<components> flat_rate;
    StrainRate<9> solid_rate;
    ASSERT_TRUE(hencky_strain<components>(f - Mat3::Identity(), flat, &flat_rate));
    ASSERT_TRUE(hencky_strain<9>(f - Mat3::Identity(), solid, &solid_rate));
    EXPECT_LT((flat - solid).norm(), 1e-13);
    const auto at = places(space);
    for (int i = 0; i < strains_of(components); ++i)
      for (int c = 0; c < components; ++c)
        EXPECT_NEAR(flat_rate(i, c), solid_rate(voigt_of(components, i), 3 * at[c].first + at[c].second), 1e-12);
  };
  RandomStrain random;
  for (int k = 0; k < 100; ++k) {
    const double size = k % 2 ? 0.2 : 1e-4;
    const Mat3 turn = random_rotation(random, Space::plane_strain);
    const Mat3 plane = Mat3::Identity() + random_gradient(random, size, Space::plane_strain);
    same.operator()<4>(turn * plane, Space::plane_strain);
    const Mat3 ring = Mat3::Identity() + random_gradient(random, size, Space::axisymmetric);
    same.operator()<5>(turn * ring, Space::axisymmetric);
  }
}

TEST(Hencky, RateIsExactForEqualAndNearlyEqualStretches) {
  for (double gap : {0.0, 1e-15, 1e-9, 1e-5, 0.1}) {
    Mat3 h = Mat3::Zero();
    h(0, 0) = 0.2 + gap;
    h(1, 1) = 0.2;
    const Mat3 f = Mat3::Identity() + h;
    Voigt strain, plus, minus;
    StrainRate<4> rate;
    ASSERT_TRUE(hencky_strain<4>(h, strain, &rate));
    for (int c = 0; c < 4; ++c) {
      Mat3 l = Mat3::Zero();
      l(c / 2, c % 2) = 1e-5;
      ASSERT_TRUE(hencky_strain<4>(h + l * f, plus, nullptr) && hencky_strain<4>(h - l * f, minus, nullptr));
      const Voigt numerical = (plus - minus) / 2e-5;
      EXPECT_LT((Vec3(numerical[XX], numerical[YY], numerical[XY]) - rate.col(c)).norm(), 1e-9) << gap << " " << c;
    }
  }
}

TEST(Hencky, SolidRateIsExactForAnyStretches) {
  RandomStrain random;
  for (const Vec3& stretch :
       {Vec3(2.5, 0.4, 1.1), Vec3(1.2, 0.9, 1.0), Vec3(1.3, 1.3 + 1e-9, 0.8), Vec3(0.8, 1.3, 1.3 + 1e-9),
        Vec3(0.9, 0.9 + 1e-9, 0.9 - 1e-9), Vec3(1.3, 1.3, 0.8), Vec3(0.8, 0.8, 1.3), Vec3(1.0, 1.0, 1.0),
        Vec3(1.4, 1.4, 1.4), Vec3(1.0 + 1e-15, 1.0, 1.0), Vec3(1.0 + 1e-5, 1.0, 1.0 - 1e-5)})
    for (int k = 0; k < 10; ++k) {
      const Mat3 q = k < 3 ? Mat3(Mat3::Identity()) : random.rotation(),
                 r = k == 0 ? Mat3(Mat3::Identity()) : random.rotation();
      EXPECT_LT(rate_error<9>(r * q * stretch.asDiagonal() * q.transpose(), Space::solid), 1e-9) << stretch.transpose();
    }
  for (double shear : {0.5, 3.0}) {
    Mat3 f = Mat3::Identity();
    f(0, 1) = shear;
    EXPECT_LT(rate_error<9>(f, Space::solid), 1e-9) << shear;
    EXPECT_LT(rate_error<4>(f, Space::plane_strain), 1e-9) << shear;
    f(2, 2) = 1.4;
    EXPECT_LT(rate_error<5>(f, Space::axisymmetric), 1e-9) << shear;
    f(2, 0) = -shear;
    EXPECT_LT(rate_error<9>(random.rotation() * f, Space::solid), 1e-9) << shear;
  }
}

TEST(Hencky, TurnedInsideOutIsNotAdmissible) {
  const LinearElastic law = concrete<LinearElastic>();
  const Mat3 f = Vec3(-1.0, 1.0, 1.0).asDiagonal();
  double strain_zz = 0.0;
  PointResponse out;
  for (const Space space : {Space::plane_strain, Space::plane_stress})
    EXPECT_EQ(point_response<4>(law, space, Kinematics::finite, Mat3::Identity(), f, LawInput{}, nullptr, nullptr,
                                strain_zz, out),
              Status::not_admissible);
  EXPECT_EQ(point_response<5>(law, Space::axisymmetric, Kinematics::finite, Mat3::Identity(), f, LawInput{}, nullptr,
                              nullptr, strain_zz, out),
            Status::not_admissible);
  EXPECT_EQ(point_response<9>(law, Space::solid, Kinematics::finite, Mat3::Identity(), f, LawInput{}, nullptr, nullptr,
                              strain_zz, out),
            Status::not_admissible);
}

TEST(Hencky, RefusesDeterminantsThatAreNotPositive) {
  Voigt strain;
  const auto refused = [&](const Mat3& f) {
    EXPECT_FALSE(hencky_strain<9>(f - Mat3::Identity(), strain, nullptr)) << f;
  };
  RandomStrain random;
  for (const Vec3& stretch :
       {Vec3(-1.0, 1.0, 1.0), Vec3(1.2, -0.3, 0.9), Vec3(-1.0, -1.0, -1.0), Vec3(1.0, 0.0, 1.0), Vec3(0.0, 0.0, 0.0)}) {
    refused(stretch.asDiagonal());
    if (stretch.prod() < 0.0) refused(random.rotation() * stretch.asDiagonal());
  }
  refused(Mat3::Constant(std::nan("")));
  refused(Mat3::Constant(1e300));
  // Half a turn about an axis is none of them.
  EXPECT_LT(hencky<9>(Vec3(-1.0, -1.0, 1.0).asDiagonal()).norm(), 1e-15);
  // Around the axis neither the plane nor the hoop may turn over, not even both.
  for (const Vec3& stretch : {Vec3(1.0, 1.0, -0.5), Vec3(1.0, 1.0, 0.0), Vec3(-1.0, 1.0, 1.0), Vec3(-1.0, 1.0, -1.0)})
    EXPECT_FALSE(hencky_strain<5>(Mat3(stretch.asDiagonal()) - Mat3::Identity(), strain, nullptr));
  EXPECT_LT(hencky<5>(Vec3(-1.0, -1.0, 1.0).asDiagonal()).norm(), 1e-15);
}

/// Uniaxial finite stretch of Hencky's solid in plane stress: tau = E ln(lambda).
TEST(Hencky, UniaxialStretchInPlaneStress) {
  const LinearElastic law = concrete<LinearElastic>();
  const double stretch = 1.3;
  const Mat3 f = Vec3(stretch, std::pow(stretch, -nu), 1.0).asDiagonal();
  const Response out = respond(law, Space::plane_stress, Kinematics::finite, f);
  EXPECT_NEAR(out.stress[XX], young * std::log(stretch), 1e-10 * young);
  EXPECT_NEAR(out.stress[YY], 0.0, 1e-10 * young);
  EXPECT_NEAR(out.strain_zz, -nu * std::log(stretch), 1e-14);
}

/// The same around an axis, with the hoop as one of the sides that give way.
TEST(Hencky, UniaxialStretchAlongTheAxis) {
  const LinearElastic law = concrete<LinearElastic>();
  const double stretch = 1.3, across = std::pow(stretch, -nu);
  const Response out =
      respond(law, Space::axisymmetric, Kinematics::finite, Vec3(across, stretch, across).asDiagonal());
  Voigt expected = Voigt::Zero();
  expected[YY] = young * std::log(stretch);
  EXPECT_LT((out.stress - expected).norm(), 1e-12 * young);
}

}  // namespace
}  // namespace berm::test
