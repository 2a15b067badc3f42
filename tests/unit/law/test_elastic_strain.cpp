/// Kinematics of laws that keep their elastic strain: as long as nothing flows they must agree with a law of the total
/// strain, whatever the path.

#include "law/point_response.hpp"
#include "law_fixture.hpp"

namespace berm::test {
namespace {

/// Hooke's law with the interface of a law of plasticity that never yields.
struct NeverYields : IsotropicElastic {
  static constexpr std::string_view name = "never_yields", doc = "Hooke's law by its elastic strain.";
  static constexpr int n_state = 7, elastic_strain = 1;
  static std::vector<Parameter<NeverYields>> parameters() { return elastic_parameters<NeverYields>(); }
  std::string check(double) const { return {}; }
  void initial_state(double* state) const { std::fill_n(state, n_state, 0.0); }
  Status update(const LawInput& in, const double*, double* new_state, LawOutput& out) const {
    lame().stiffness(1.0, out.tangent);
    out.stress = lame().stress(in.strain);
    out.stored_energy = 0.5 * in.strain.dot(out.stress);
    new_state[0] = 0.0;
    Eigen::Map<Voigt>(new_state + elastic_strain) = in.strain;
    return Status::ok;
  }
};

Mat3 random_increment(RandomStrain& random, double size, Space space) {
  const Mat3 g = tensor(random(size, false)) + random.rotation() * size;  // with a spin
  Mat3 h = Mat3::Zero();
  if (space == Space::solid) return g;
  h.topLeftCorner<2, 2>() = g.topLeftCorner<2, 2>();
  if (space == Space::axisymmetric) h(2, 2) = g(2, 2);
  return h;
}

template <int components>
void expect_agreement(Space space, Kinematics kinematics) {
  RandomStrain random;
  const LinearElastic total = concrete<LinearElastic>();
  NeverYields elastic;
  elastic.youngs_modulus = young;
  elastic.poisson_ratio = nu;
  for (int path = 0; path < 20; ++path) {
    double state[NeverYields::n_state] = {}, next[NeverYields::n_state];
    double zz = 0.0, expected_zz = 0.0;
    Mat3 old_f = Mat3::Identity();
    for (int step = 0; step < 10; ++step) {
      const Mat3 h = random_increment(random, 0.1, space);
      const Mat3 f = kinematics == Kinematics::finite ? Mat3((Mat3::Identity() + h) * old_f) : Mat3(old_f + h);
      PointResponse out, expected;
      Modulus<components> tangent, expected_tangent;
      ASSERT_EQ(point_response<components>(total, space, kinematics, old_f, f, LawInput{}, nullptr, nullptr,
                                           expected_zz, expected, &expected_tangent),
                Status::ok);
      ASSERT_EQ(
          point_response<components>(elastic, space, kinematics, old_f, f, LawInput{}, state, next, zz, out, &tangent),
          Status::ok);
      EXPECT_LT((out.stress - expected.stress).norm(), 1e-11 * expected.stress.norm());
      EXPECT_LT((tangent - expected_tangent).norm(), 1e-10 * expected_tangent.norm());
      EXPECT_NEAR(zz, expected_zz, 1e-12);
      std::copy(next, next + NeverYields::n_state, state);
      old_f = f;
    }
  }
}

TEST(ElasticStrain, AgreesWithTheTotalStrainInEveryModel) {
  for (const Kinematics kinematics : {Kinematics::finite, Kinematics::small}) {
    expect_agreement<9>(Space::solid, kinematics);
    expect_agreement<5>(Space::axisymmetric, kinematics);
    expect_agreement<4>(Space::plane_strain, kinematics);
    expect_agreement<4>(Space::plane_stress, kinematics);
  }
}

/// A point that has been compressed evenly by `pressure` and sheared, and a second step from there.
template <class L, int components>
struct SecondStep {
  L law = concrete<L>();
  Space space;
  Kinematics kinematics;
  std::vector<double> state = std::vector<double>(L::n_state), next = state;
  Mat3 old_f = Mat3::Identity();
  double old_zz = 0.0;

  SecondStep(Space s, Kinematics k, const Mat3& first) : space(s), kinematics(k) {
    law.initial_state(state.data());
    PointResponse unused;
    double zz = 0.0;
    EXPECT_EQ(point_response<components>(law, space, kinematics, old_f, first, LawInput{}, state.data(), next.data(),
                                         zz, unused),
              Status::ok);
    state = next;
    old_f = first;
    old_zz = zz;
  }

  /// Force on the reference area, and the tangent.
  Mat3 force(const Mat3& f, Modulus<components>* tangent = nullptr) {
    PointResponse out;
    double zz = old_zz;
    EXPECT_EQ(point_response<components>(law, space, kinematics, old_f, f, LawInput{}, state.data(), next.data(), zz,
                                         out, tangent),
              Status::ok);
    plastic_strain = out.plastic_strain;
    const Mat3 stress = tensor(out.stress);
    return kinematics == Kinematics::small ? stress : Mat3(stress * f.inverse().transpose());
  }
  double plastic_strain = 0.0;
};

/// Compression by `squeeze` in all directions and a random rest of size `shear`.
Mat3 first_step(RandomStrain& random, double squeeze, double shear, Space space) {
  Mat3 h = shear * tensor(random(1.0, false)) - squeeze * Mat3::Identity();
  h(0, 1) += shear;  // with a spin
  if (space == Space::solid) return Mat3::Identity() + h;
  h.row(2).setZero(), h.col(2).setZero();
  if (space == Space::axisymmetric) h(2, 2) = -squeeze;
  return Mat3::Identity() + h;
}

/// States at which the tangent is not that of central differences, of `states`; and how many of all flow.
template <class L, int components>
std::pair<int, int> wrong_tangents(Space space, Kinematics kinematics, double squeeze, double shear, int states) {
  RandomStrain random;
  const auto at = places(space);
  int wrong = 0, flows = 0;
  for (int k = 0; k < states; ++k) {
    SecondStep<L, components> point(space, kinematics, first_step(random, squeeze, shear, space));
    const Mat3 f = (first_step(random, 0.3 * squeeze, 0.7 * shear, space)) * point.old_f;
    Modulus<components> tangent, numerical;
    point.force(f, &tangent);
    flows += point.plastic_strain > 0.0;
    const double h = 1e-6 * (squeeze + shear);
    for (int column = 0; column < components; ++column) {
      Mat3 l = Mat3::Zero();
      l(at[column].first, at[column].second) = h;
      const Mat3 df = kinematics == Kinematics::small ? l : Mat3(l * f);
      Mat3 d = (point.force(f + df) - point.force(f - df)) / (2.0 * h);
      if (kinematics == Kinematics::finite) d = d * f.transpose();
      for (int row = 0; row < components; ++row) numerical(row, column) = d(at[row].first, at[row].second);
    }
    // Differences that cross a border between regions are not the tangent; an apex has a small one of its own.
    const double limit = 2e-6 * tangent.norm() + 3e-5 * point.law.stiffness();
    wrong += (tangent - numerical).norm() > limit;
  }
  return {wrong, flows};
}

template <class L>
struct PlasticPoint : ::testing::Test {};
using PlasticLaws = ::testing::Types<VonMises, DruckerPrager, MohrCoulomb, ModifiedCamClay>;
TYPED_TEST_SUITE(PlasticPoint, PlasticLaws);

/// Both for strains at which the point begins to flow and for large ones.
TYPED_TEST(PlasticPoint, TangentIsThatOfDifferencesAfterAFirstStep) {
  for (const double size : {2e-4, 0.02})
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite}) {
      constexpr int states = 200, few = 4;
      const auto expect = [&](const char* model, const std::pair<int, int>& counted) {
        SCOPED_TRACE(testing::Message() << model << (kinematics == Kinematics::small ? " small " : " finite ") << size);
        EXPECT_LE(counted.first, few);
        EXPECT_GT(counted.second, states / 4);
      };
      const double squeeze = TypeParam::name == "modified_cam_clay" ? 2e-3 : size;
      expect("plane strain", wrong_tangents<TypeParam, 4>(Space::plane_strain, kinematics, squeeze, size, states));
      if constexpr (!requires { TypeParam::no_plane_stress; })
        expect("plane stress", wrong_tangents<TypeParam, 4>(Space::plane_stress, kinematics, squeeze, size, states));
      expect("axisymmetric", wrong_tangents<TypeParam, 5>(Space::axisymmetric, kinematics, squeeze, size, states));
      expect("solid", wrong_tangents<TypeParam, 9>(Space::solid, kinematics, squeeze, size, states));
    }
}

/// A rigid turn of a stressed, flowing point turns its stress and nothing else.
TYPED_TEST(PlasticPoint, RigidTurnTurnsTheStress) {
  RandomStrain random;
  for (int k = 0; k < 50; ++k) {
    SecondStep<TypeParam, 9> point(Space::solid, Kinematics::finite, first_step(random, 1e-3, 1e-3, Space::solid));
    const Mat3 before = point.force(point.old_f) * point.old_f.transpose(), q = random.rotation();
    const double flown = point.plastic_strain;
    const Mat3 f = q * point.old_f, after = point.force(f) * f.transpose();
    EXPECT_LT((after - q * before * q.transpose()).norm(), 1e-9 * before.norm());
    EXPECT_NEAR(point.plastic_strain, flown, 1e-12);
  }
}

/// Strains of 1e-12 keep eight digits through a step.
TEST(ElasticStrain, KeepsTheDigitsOfSmallStrains) {
  Voigt elastic, strain;
  elastic << 1e-12, -2e-12, 3e-12, 1e-12, 0.5e-12, -1e-12;
  const Mat3 g = 1e-12 * Mat3::Identity();
  ASSERT_TRUE(trial_elastic_strain<9>(g, elastic, strain, nullptr));
  Voigt expected = elastic;
  expected.head<3>().array() += 1e-12;
  EXPECT_LT((strain - expected).norm(), 1e-20);
}

TEST(ElasticStrain, RefusesStepsThatTurnInsideOut) {
  Voigt strain;
  for (const Vec3& stretch : {Vec3(-1.0, 1.0, 1.0), Vec3(1.0, 0.0, 1.0)}) {
    const Mat3 g = Mat3(stretch.asDiagonal()) - Mat3::Identity();
    EXPECT_FALSE(trial_elastic_strain<9>(g, Voigt::Zero(), strain, nullptr));
    EXPECT_FALSE(trial_elastic_strain<5>(g, Voigt::Zero(), strain, nullptr));
    EXPECT_FALSE(trial_elastic_strain<4>(g, Voigt::Zero(), strain, nullptr));
  }
  const Mat3 hoop = Mat3(Vec3(1.0, 1.0, -0.5).asDiagonal()) - Mat3::Identity();
  EXPECT_FALSE(trial_elastic_strain<5>(hoop, Voigt::Zero(), strain, nullptr));
}

}  // namespace
}  // namespace berm::test
