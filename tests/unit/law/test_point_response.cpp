/// The plane wrapper: kinematics, plane stress, and the tangent of the internal force.

#include "law/point_response.hpp"
#include "law_fixture.hpp"

namespace berm::test {
namespace {

template <class L>
struct PlanePoint : ::testing::Test {
  PlaneResponse respond(const Mat2& f, Plane plane, Kinematics kinematics) {
    const L law = concrete<L>();
    std::vector<double> old_state(L::n_state), next(L::n_state);
    law.initial_state(old_state.data());
    LawInput settings;
    settings.length = 0.02;
    double strain_zz = 0.0;
    PlaneResponse out;
    EXPECT_EQ(plane_response(law, plane, kinematics, f, settings, old_state.data(), next.data(), strain_zz, out),
              Status::ok);
    return out;
  }

  /// Stress that is work-conjugate to the displacement gradient on the reference configuration.
  Mat2 nominal(const Mat2& f, Plane plane, Kinematics kinematics) {
    const Mat2 stress = respond(f, plane, kinematics).stress;
    return kinematics == Kinematics::small ? stress : Mat2(stress * f.inverse().transpose());
  }
};
TYPED_TEST_SUITE(PlanePoint, AllLaws);

Mat2 random_gradient(RandomStrain& random, double size) {
  const Voigt r = random(size, false);
  Mat2 h;
  h << r[0], r[1], r[2], r[3];
  return h;
}

TYPED_TEST(PlanePoint, TangentMatchesFiniteDifferencesOfTheForce) {
  RandomStrain random;
  for (int k = 0; k < 400; ++k) {
    const Plane plane = k % 2 ? Plane::strain : Plane::stress;
    const Kinematics kinematics = k / 2 % 2 ? Kinematics::finite : Kinematics::small;
    const double size = k % 3 ? 3.0 * onset : 0.02, h = 2e-6 * size;
    const Mat2 f = Mat2::Identity() + random_gradient(random, size);
    const Eigen::Matrix4d tangent = this->respond(f, plane, kinematics).tangent;
    Eigen::Matrix4d numerical;
    for (int column = 0; column < 4; ++column) {
      Mat2 l = Mat2::Zero();
      l(column / 2, column % 2) = h;
      const Mat2 df = kinematics == Kinematics::small ? l : Mat2(l * f);
      Mat2 d = (this->nominal(f + df, plane, kinematics) - this->nominal(f - df, plane, kinematics)) / (2.0 * h);
      if (kinematics == Kinematics::finite) d = d * f.transpose();  // to gradients on the current configuration
      numerical.col(column) << d(0, 0), d(0, 1), d(1, 0), d(1, 1);
    }
    const double rounding = 5e-10 * young;  // of 1 - d, over the relative step 2e-6
    ASSERT_LT((tangent - numerical).norm(), 1e-6 * tangent.norm() + rounding) << "state " << k;
  }
}

TYPED_TEST(PlanePoint, SmallAndFiniteAgreeForTinyGradients) {
  RandomStrain random;
  for (const Plane plane : {Plane::strain, Plane::stress}) {
    const Mat2 f = Mat2::Identity() + random_gradient(random, 1e-8);
    const PlaneResponse small = this->respond(f, plane, Kinematics::small);
    const PlaneResponse finite = this->respond(f, plane, Kinematics::finite);
    EXPECT_LT((small.stress - finite.stress).norm(), 1e-7 * small.stress.norm());
    EXPECT_LT((small.tangent - finite.tangent).norm(), 1e-7 * small.tangent.norm());
  }
}

TYPED_TEST(PlanePoint, RigidRotationMakesNoStressAndTurnsIt) {
  const double angle = 0.7;
  Mat2 q, f;
  q << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  EXPECT_LT(this->respond(q, Plane::strain, Kinematics::finite).stress.norm(), 1e-14 * young);
  f << 1.0 + 4.0 * onset, 2.0 * onset, -onset, 1.0 + onset;
  for (const Plane plane : {Plane::strain, Plane::stress}) {
    const PlaneResponse straight = this->respond(f, plane, Kinematics::finite);
    const PlaneResponse turned = this->respond(q * f, plane, Kinematics::finite);
    EXPECT_LT((turned.stress - q * straight.stress * q.transpose()).norm(), 1e-9 * straight.stress.norm());
  }
}

TYPED_TEST(PlanePoint, PlaneStressLeavesNoStressAcross) {
  RandomStrain random;
  for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite}) {
    for (int k = 0; k < 100; ++k) {
      const PlaneResponse out =
          this->respond(Mat2::Identity() + random_gradient(random, 4.0 * onset), Plane::stress, kinematics);
      EXPECT_LE(std::abs(out.stress_zz), 1e-12 * out.stress.norm());
      EXPECT_EQ(out.strain[ZZ], out.strain_zz);
      EXPECT_NE(out.strain_zz, 0.0);
    }
  }
}

/// Any law without its own answer for the free strain: the Newton iteration must find it.
struct WithoutHint {
  SimoJu law = concrete<SimoJu>();
  static constexpr std::string_view name = "without_hint", doc = "Simo-Ju behind a wall.";
  static constexpr int n_state = SimoJu::n_state;
  static std::vector<Parameter<WithoutHint>> parameters() { return {}; }
  std::string check(double) const { return {}; }
  void initial_state(double* state) const { law.initial_state(state); }
  Status update(const LawInput& in, const double* old_state, double* new_state, LawOutput& out) const {
    return law.update(in, old_state, new_state, out);
  }
};

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

TEST(Hencky, KeepsFullAccuracyForTinyStrains) {
  Mat2 h;
  h << 3e-12, 5e-12, -1e-12, 2e-12;
  Voigt strain;
  ASSERT_TRUE(hencky_strain(h, strain, nullptr));
  EXPECT_NEAR(strain[XX], 3e-12, 1e-22);  // the quadratic terms are 1e-24 ...
  EXPECT_NEAR(strain[YY], 2e-12, 1e-22);
  EXPECT_NEAR(strain[XY], 4e-12, 1e-22);
}

TEST(Hencky, IsTheLogarithmOfTheStretch) {
  const double angle = 0.3;
  Mat2 q;
  q << std::cos(angle), -std::sin(angle), std::sin(angle), std::cos(angle);
  const Mat2 expected = q * Vec2(std::log(2.5), std::log(0.4)).asDiagonal() * q.transpose();
  const Mat2 f = q * Vec2(2.5, 0.4).asDiagonal() * q.transpose();
  Voigt strain;
  ASSERT_TRUE(hencky_strain(f - Mat2::Identity(), strain, nullptr));
  EXPECT_NEAR(strain[XX], expected(0, 0), 1e-14);
  EXPECT_NEAR(strain[YY], expected(1, 1), 1e-14);
  EXPECT_NEAR(strain[XY], 2.0 * expected(0, 1), 1e-14);
}

TEST(Hencky, RateIsExactForEqualAndNearlyEqualStretches) {
  for (double gap : {0.0, 1e-15, 1e-9, 1e-5, 0.1}) {
    Mat2 h = Mat2::Zero();
    h(0, 0) = 0.2 + gap;
    h(1, 1) = 0.2;
    const Mat2 f = Mat2::Identity() + h;
    Voigt strain, plus, minus;
    StrainOperator rate;
    ASSERT_TRUE(hencky_strain(h, strain, &rate));
    for (int c = 0; c < 4; ++c) {
      Mat2 l = Mat2::Zero();
      l(c / 2, c % 2) = 1e-5;
      ASSERT_TRUE(hencky_strain(h + l * f, plus, nullptr) && hencky_strain(h - l * f, minus, nullptr));
      const Voigt numerical = (plus - minus) / 2e-5;
      EXPECT_LT((Vec3(numerical[XX], numerical[YY], numerical[XY]) - rate.col(c)).norm(), 1e-9) << gap << " " << c;
    }
  }
}

TEST(Hencky, TurnedInsideOutIsNotAdmissible) {
  const LinearElastic law = concrete<LinearElastic>();
  Mat2 f;
  f << -1.0, 0.0, 0.0, 1.0;
  double strain_zz = 0.0;
  PlaneResponse out;
  EXPECT_EQ(plane_response(law, Plane::strain, Kinematics::finite, f, LawInput{}, nullptr, nullptr, strain_zz, out),
            Status::not_admissible);
}

/// Uniaxial finite stretch of Hencky's solid in plane stress: tau = E ln(lambda).
TEST(Hencky, UniaxialStretchInPlaneStress) {
  const LinearElastic law = concrete<LinearElastic>();
  const double stretch = 1.3;
  Mat2 f = Mat2::Zero();
  f(0, 0) = stretch;
  f(1, 1) = std::pow(stretch, -nu);
  double strain_zz = 0.0;
  PlaneResponse out;
  ASSERT_EQ(plane_response(law, Plane::stress, Kinematics::finite, f, LawInput{}, nullptr, nullptr, strain_zz, out),
            Status::ok);
  EXPECT_NEAR(out.stress(0, 0), young * std::log(stretch), 1e-10 * young);
  EXPECT_NEAR(out.stress(1, 1), 0.0, 1e-10 * young);
  EXPECT_NEAR(strain_zz, -nu * std::log(stretch), 1e-14);
}

}  // namespace
}  // namespace berm::test
