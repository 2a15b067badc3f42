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
