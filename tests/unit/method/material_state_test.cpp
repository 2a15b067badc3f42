#include "method/material_state.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <numeric>
#include <random>

namespace berm {
namespace {

constexpr double young = 30e9, ft = 3e6;

SimoJu simo_ju() {
  SimoJu law;
  law.youngs_modulus = young;
  law.poisson_ratio = 0.2;
  law.tensile_strength = ft;
  law.fracture_energy = 100.0;
  law.strength_ratio = 10.0;
  return law;
}

LinearElastic elastic() {
  LinearElastic law;
  law.youngs_modulus = 10e9;
  law.poisson_ratio = 0.3;
  return law;
}

Mazars mazars() {
  Mazars law;
  law.youngs_modulus = young;
  law.poisson_ratio = 0.2;
  law.tensile_strength = ft;
  law.fracture_energy = 100.0;
  law.compression_a = 1.2;
  law.compression_b = 1600.0;
  return law;
}

class Gradients {
public:
  Mat3 operator()(double size, Space space) {
    Mat3 h = Mat3::Zero();
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if ((i < 2 && j < 2) || space == Space::solid) h(i, j) = size * normal_(generator_);
    if (space == Space::axisymmetric) h(2, 2) = size * normal_(generator_);
    return h;
  }

private:
  std::mt19937 generator_{3};
  std::normal_distribution<double> normal_;
};

constexpr double size = 3.0 * ft / young;
constexpr Space all_spaces[] = {Space::plane_strain, Space::plane_stress, Space::axisymmetric, Space::solid};

/// Four slices, with 0, 5 and 7 numbers of state a point and one without points, after two committed steps with damage.
MaterialState loaded(const LawSettings& settings, Gradients& random) {
  MaterialState m;
  m.add(2, simo_ju(), {1.0, 2.0, 3.0}, {0.01, 0.02, 0.03});
  m.add(0, elastic(), {4.0, 5.0}, {0.04, 0.05});
  m.add(3, simo_ju(), {}, {});
  m.add(1, mazars(), {6.0, 7.0, 8.0, 9.0}, {0.01, 0.02, 0.03, 0.04});
  for (int step = 0; step < 2; ++step) {
    for (Mat3& f : m.trial_F) f += random(size, settings.space);
    EXPECT_EQ(m.respond(settings), Status::ok);
    m.commit();
  }
  EXPECT_GT(m.max_damage(), 0.1);
  return m;
}

std::vector<std::vector<double>> rows_of(const MaterialState& m) {
  std::vector<std::vector<double>> rows;
  for (std::size_t s = 0; s < m.slices.size(); ++s) {
    const int width = m.row_width(static_cast<int>(s));
    std::vector<double> out(std::size_t(m.slices[s].end - m.slices[s].begin) * width);
    for (int p = m.slices[s].begin; p < m.slices[s].end; ++p)
      m.write_row(p, out.data() + std::size_t(p - m.slices[s].begin) * width);
    rows.push_back(std::move(out));
  }
  return rows;
}

LawSettings settings_of(Space space, Kinematics kinematics, Integration integration = Integration::implicit) {
  LawSettings s;
  s.space = space;
  s.kinematics = kinematics;
  s.integration = integration;
  s.dt = 0.5;
  return s;
}

void expect_same_point(const MaterialState& a, int p, const MaterialState& b, int q) {
  EXPECT_EQ(a.volume[p], b.volume[q]);
  EXPECT_EQ(a.length[p], b.length[q]);
  EXPECT_EQ(a.F[p], b.F[q]);
  EXPECT_EQ(a.strain_zz[p], b.strain_zz[q]);
  EXPECT_EQ(a.stress[p], b.stress[q]);
  EXPECT_EQ(a.strain[p], b.strain[q]);
  EXPECT_EQ(a.damage[p], b.damage[q]);
  EXPECT_EQ(a.stored[p], b.stored[q]);
  EXPECT_EQ(a.dissipated[p], b.dissipated[q]);
}

void expect_same_response(const PointResponse& a, const PointResponse& b) {
  EXPECT_EQ(a.stress, b.stress);
  EXPECT_EQ(a.strain, b.strain);
  EXPECT_EQ(a.damage, b.damage);
  EXPECT_EQ(a.stored_energy, b.stored_energy);
  EXPECT_EQ(a.dissipated, b.dissipated);
  EXPECT_EQ(a.extrapolation_error, b.extrapolation_error);
}

TEST(MaterialState, RowsBringEverythingBack) {
  Gradients random;
  for (const Space space : all_spaces)
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite})
      for (const Integration integration : {Integration::implicit, Integration::impl_ex}) {
        const LawSettings settings = settings_of(space, kinematics, integration);
        MaterialState before = loaded(settings, random);
        const auto rows = rows_of(before);
        EXPECT_EQ(before.row_width(1) + SimoJu::n_state, before.row_width(0));
        MaterialState after;
        for (const Slice& s : before.slices) after.add(s.body, s.law, {}, {});
        EXPECT_EQ(after.size(), 0);
        after.replace(rows);
        ASSERT_EQ(after.size(), 9);
        EXPECT_EQ(rows_of(after), rows);
        for (int p = 0; p < 9; ++p) {
          expect_same_point(before, p, after, p);
          EXPECT_EQ(after.trial_F[p], after.F[p]);
        }
        EXPECT_EQ(after.stored_energy(), before.stored_energy());
        EXPECT_EQ(after.dissipated_energy(), before.dissipated_energy());
        EXPECT_EQ(after.crack_opening(), before.crack_opening());
        EXPECT_EQ(after.released_energy_fraction(), before.released_energy_fraction());

        for (int p = 0; p < 9; ++p) before.trial_F[p] = after.trial_F[p] = before.F[p] + random(size, space);
        ASSERT_EQ(before.respond(settings), Status::ok);
        ASSERT_EQ(after.respond(settings), Status::ok);
        for (int p = 0; p < 9; ++p) expect_same_response(before.trial[p], after.trial[p]);
        before.commit();
        after.commit();
        EXPECT_EQ(rows_of(after), rows_of(before));
      }
}

/// Points in another order, some gone, some twice: what happens when they travel between processes.
TEST(MaterialState, RowsMayComeInAnyOrderAndNumber) {
  Gradients random;
  const LawSettings settings = settings_of(Space::solid, Kinematics::finite);
  MaterialState before = loaded(settings, random), after = loaded(settings, random);
  const auto rows = rows_of(before);
  const std::vector<std::vector<int>> order = {{2, 0}, {1, 0, 1, 0, 1}, {}, {3}};
  std::vector<std::vector<double>> chosen(4);
  std::vector<int> origin;
  for (int s = 0; s < 4; ++s)
    for (int k : order[s]) {
      const int width = before.row_width(s);
      chosen[s].insert(chosen[s].end(), rows[s].begin() + k * width, rows[s].begin() + (k + 1) * width);
      origin.push_back(before.slices[s].begin + k);
    }
  after.replace(chosen);
  ASSERT_EQ(after.size(), 8);
  for (int s = 0, begin = 0; s < 4; ++s) {
    EXPECT_EQ(after.slices[s].begin, begin);
    EXPECT_EQ(after.slices[s].end, begin += static_cast<int>(order[s].size()));
    EXPECT_EQ(after.slices[s].body, before.slices[s].body);
  }
  for (int q = 0; q < 8; ++q) expect_same_point(before, origin[q], after, q);
  std::vector<Mat3> gradient;
  for (int p = 0; p < 9; ++p) before.trial_F[p] = before.F[p] + random(size, Space::solid);
  for (int q = 0; q < 8; ++q) after.trial_F[q] = before.trial_F[origin[q]];
  ASSERT_EQ(before.respond(settings), Status::ok);
  ASSERT_EQ(after.respond(settings), Status::ok);
  for (int q = 0; q < 8; ++q) expect_same_response(before.trial[origin[q]], after.trial[q]);
  after.replace({{}, {}, {}, {}});
  EXPECT_EQ(after.size(), 0);
  EXPECT_EQ(after.respond(settings), Status::ok);
  EXPECT_EQ(after.max_damage(), 0.0);
}

/// The tangent of a point, and of no other, against differences of its own response.
template <int components>
void expect_modulus(const LawSettings& settings, const std::vector<std::pair<int, int>>& at) {
  Gradients random;
  MaterialState m = loaded(settings, random);
  const bool finite = settings.kinematics == Kinematics::finite;
  std::vector<Mat3> start(9);
  for (int p = 0; p < 9; ++p) start[p] = m.F[p] + random(size, settings.space);
  const auto forces = [&](const Mat3& l) {
    for (int p = 0; p < 9; ++p) m.trial_F[p] = start[p] + (finite ? Mat3(l * start[p]) : l);
    EXPECT_EQ(m.respond(settings), Status::ok);
    std::vector<Mat3> out;
    for (int p = 0; p < 9; ++p) {
      const Mat3 tau = response_detail::tensor(m.trial[p].stress);
      out.push_back(finite ? Mat3(tau * (Mat3::Identity() + l).inverse().transpose()) : tau);
    }
    return out;
  };
  const double h = 2e-6 * size;
  std::vector<Modulus<components>> numerical(9), tangent(9);
  for (int c = 0; c < components; ++c) {
    Mat3 l = Mat3::Zero();
    l(at[c].first, at[c].second) = h;
    const auto plus = forces(l), minus = forces(-l);
    for (int p = 0; p < 9; ++p)
      for (int r = 0; r < components; ++r)
        numerical[p](r, c) = (plus[p] - minus[p])(at[r].first, at[r].second) / (2.0 * h);
  }
  forces(Mat3::Zero());
  for (int p = 0; p < 9; ++p) {
    m.modulus<components>(p, settings, tangent[p]);
    EXPECT_LT((tangent[p] - numerical[p]).norm(), 1e-6 * tangent[p].norm() + 5e-10 * young)
        << "space " << int(settings.space) << ", point " << p;
  }
}

TEST(MaterialState, ModulusIsTheDerivativeOfTheResponse) {
  for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite})
    for (const Integration integration : {Integration::implicit, Integration::impl_ex, Integration::lagged}) {
      for (const Space space : {Space::plane_strain, Space::plane_stress})
        expect_modulus<4>(settings_of(space, kinematics, integration), {{0, 0}, {0, 1}, {1, 0}, {1, 1}});
      expect_modulus<5>(settings_of(Space::axisymmetric, kinematics, integration),
                        {{0, 0}, {0, 1}, {1, 0}, {1, 1}, {2, 2}});
      expect_modulus<9>(settings_of(Space::solid, kinematics, integration),
                        {{0, 0}, {0, 1}, {0, 2}, {1, 0}, {1, 1}, {1, 2}, {2, 0}, {2, 1}, {2, 2}});
    }
}

/// Kirchhoff to Cauchy: J of all three directions.
TEST(MaterialState, CommitsCauchyStress) {
  for (const Space space : all_spaces)
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite}) {
      MaterialState m;
      m.add(0, elastic(), {1.0}, {0.1});
      m.trial_F[0] = Vec3(1.2, 0.9, 1.0).asDiagonal();
      if (space == Space::axisymmetric || space == Space::solid) m.trial_F[0](2, 2) = 1.1;
      ASSERT_EQ(m.respond(settings_of(space, kinematics)), Status::ok);
      const Voigt tau = m.trial[0].stress;
      m.commit();
      double J = m.F[0].determinant();
      if (space == Space::plane_stress) J *= std::exp(-0.3 / 0.7 * (std::log(1.2) + std::log(0.9)));
      if (kinematics == Kinematics::small) J = 1.0;
      EXPECT_LT((J * m.stress[0] - tau).norm(), 1e-14 * tau.norm());
    }
}

/// The first status that is not ok, whichever slice it comes from.
TEST(MaterialState, ReportsPointsTurnedInsideOut) {
  const LawSettings settings = settings_of(Space::solid, Kinematics::finite);
  for (int bad : {0, 4, 8}) {
    Gradients random;
    MaterialState m = loaded(settings, random);
    m.trial_F[bad].col(1) *= -1.0;
    EXPECT_EQ(m.respond(settings), Status::not_admissible);
    m.trial_F[bad] = m.F[bad];
    EXPECT_EQ(m.respond(settings), Status::ok);
  }
}

}  // namespace
}  // namespace berm
