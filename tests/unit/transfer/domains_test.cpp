/// Points that stand for domains (docs/theory/formulation.md, section 16).

#include <set>

#include "blocks.hpp"

namespace berm {
namespace {

using Domain = ShapeChoice::Domain;

struct Choice {
  const char* name;
  int degree;
  Domain domain;
};
constexpr Choice choices[] = {
    {"GIMP", 1, Domain::box}, {"B2-GIMP", 2, Domain::box}, {"CPDI", 1, Domain::parallelepiped}};

std::unique_ptr<MpmDiscretisation> make(const Choice& c, Space space, Formulation formulation, bool follows,
                                        GridKind kind, double a = 0.37, double b = cells - 0.57) {
  auto mpm = std::make_unique<MpmDiscretisation>(grid_of(space, kind), space, 0.0, formulation, Comm{},
                                                 Volumetric::standard, ShapeChoice{c.degree, c.domain, follows});
  Material material = elastic();
  material.density = 2000.0;
  PointSeeding seeding;
  seeding.placement = PointSeeding::Placement::uniform;
  add_block(*mpm, space, 0, material, a, b, seeding);
  mpm->move_points(1.2);
  mpm->begin_step({});
  return mpm;
}

/// Calls work(choice, mpm, settings) with all that makes a difference to the domains.
template <class Work>
void for_all_domains(Work work) {
  for (const Choice& c : choices)
    for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
      SCOPED_TRACE(c.name);
      const bool solid = space == Space::solid;
      std::vector<GridKind> kinds = {solid ? GridKind::hexahedra : GridKind::quads};
      if (c.domain == Domain::parallelepiped) kinds.push_back(solid ? GridKind::tetrahedra : GridKind::union_jack);
      const bool follows = kinematics == Kinematics::finite && formulation == Formulation::updated_lagrangian;
      for (const GridKind kind : kinds) {
        const auto mpm = make(c, space, formulation, follows, kind);
        work(c, *mpm, settings_of(space, kinematics));
      }
    });
}

NodalVector field(const MpmDiscretisation& mpm, const Mat3& A) {
  NodalVector u;
  for (const Vec3& x : mpm.nodes) u.push_back(A * x);
  return u;
}

Mat3 stretch(Space space, double x, double y, double z) {
  Mat3 A = Mat3::Zero();
  A.diagonal() = Vec3(x, y, space == Space::solid ? z : 0.0);
  return A;
}

TEST(Domains, TangentIsTheDerivativeOfTheForceAndTheForceThatOfTheEnergy) {
  Random random;
  for_all_domains([&](const Choice&, MpmDiscretisation& mpm, const LawSettings& settings) {
    accept(mpm, random(mpm, size_of(settings.kinematics)), settings);
    const NodalVector du = random(mpm, size_of(settings.kinematics));
    const double eps = 1e-6 * h;
    const int d = mpm.dimension(), n = d * mpm.n_nodes();
    const Eigen::VectorXd f = force(mpm, du, settings);
    const Eigen::MatrixXd K = tangent(mpm, settings);
    std::mt19937 generator(3);
    for (int k = 0; k < 12; ++k) {
      const int c = static_cast<int>(generator() % n);
      const Eigen::VectorXd column =
          difference(du, c, d, eps, [&](const NodalVector& u) { return force(mpm, u, settings); });
      EXPECT_LT((K.col(c) - column).cwiseAbs().maxCoeff(), 1e-6 * K.cwiseAbs().maxCoeff());
      const double slope = difference(du, c, d, eps, [&](const NodalVector& u) {
        return Eigen::Matrix<double, 1, 1>(energy(mpm, u, settings));
      })[0];
      EXPECT_NEAR(slope, f[c], 1e-6 * f.cwiseAbs().maxCoeff());
    }
  });
}

/// Nodes that only stand in the list of a patch, for another of its points or beyond the grid, are no unknowns.
TEST(Domains, EveryUnknownHasStiffness) {
  for_all_domains([&](const Choice&, MpmDiscretisation& mpm, const LawSettings& settings) {
    force(mpm, NodalVector(mpm.n_nodes(), Vec3::Zero()), settings);
    const Eigen::VectorXd diagonal = tangent(mpm, settings).diagonal();
    EXPECT_GT(diagonal.minCoeff(), 0.0);
  });
}

/// Linear fields are kept, and where fields of nodes are linear, points move with them.
TEST(Domains, PointsMoveWithLinearFields) {
  for_all_domains([&](const Choice&, MpmDiscretisation& mpm, const LawSettings& settings) {
    Mat3 A = stretch(settings.space, 0.03, -0.02, 0.01);
    A(0, 1) = 0.02;
    const std::vector<Vec3> X = mpm.point_origins();
    force(mpm, field(mpm, A), settings);
    mpm.commit(field(mpm, A), {});
    for (std::size_t p = 0; p < X.size(); ++p)
      EXPECT_LT((mpm.point_displacements()[p] - A * X[p]).norm(), 1e-13) << X[p].transpose();
  });
}

/// The measure of the body is all in its cells, each of which has as much of it as the body covers: the fills of a block
/// from 0.5 to 2.5 cells are 1/4, 1/2 and 1 (1/8 too in space).
TEST(Domains, CoverTheirCellsAsTheBodyDoes) {
  for (const Choice& c : choices)
    for (const Space space : {Space::plane_strain, Space::solid}) {
      SCOPED_TRACE(c.name);
      const int d = space == Space::solid ? 3 : 2;
      const auto mpm = make(c, space, Formulation::updated_lagrangian, true,
                            d == 3 ? GridKind::hexahedra : GridKind::quads, 0.5, 2.5);
      ASSERT_EQ(mpm->active_cells().size(), std::pow(3, d));
      for (std::size_t k = 0; k < mpm->active_cells().size(); ++k) {
        const Vec3 centre = cell_centre(mpm->grid().mesh, mpm->active_cells()[k]) - corner;
        double expected = 1.0;
        for (int i = 0; i < d; ++i)
          if (std::abs(centre[i] / h - 1.5) > 0.9) expected *= 0.5;
        EXPECT_NEAR(mpm->fill(static_cast<int>(k)), expected, 1e-8);
      }
    }
}

/// A bar is pulled to three times its length: domains that follow are split, and mass, volume and momentum, the numbers
/// of the points and the linear field stay what they were.
TEST(Domains, LongDomainsAreSplit) {
  for (const Choice& c : choices)
    for (const Space space : {Space::plane_strain, Space::solid}) {
      SCOPED_TRACE(c.name);
      const int d = space == Space::solid ? 3 : 2;
      const LawSettings settings = settings_of(space, Kinematics::finite);
      const auto mpm = make(c, space, Formulation::updated_lagrangian, true,
                            d == 3 ? GridKind::hexahedra : GridKind::quads, 0.0, 0.9);
      mpm->start_motion([](int, const Vec3& X) { return Vec3(1.0 + X.y(), X.x(), 0.0); });
      const auto sums = [&] {
        Eigen::Matrix<double, 8, 1> s = Eigen::Matrix<double, 8, 1>::Zero();
        for (int p = 0; p < mpm->material.size(); ++p) {
          const double mass = mpm->point_masses()[p];
          s[0] += mass;
          s[1] += mpm->material.volume[p];
          s.segment<3>(2) += mass * mpm->point_velocities()[p];
          s.tail<3>() += mass * mpm->point_positions()[p];
        }
        return s;
      };
      const long before = mpm->points_made();
      const auto start = sums();
      Mat3 F = Mat3::Identity();
      for (int step = 0; step < 4; ++step) {
        // About the corner of the block, which stays in the grid.
        const double factor = std::pow(3.0, 0.25) - 1.0;
        NodalVector du;
        for (const Vec3& x : mpm->nodes)
          du.push_back(stretch(space, factor, 0.0, 0.0) * (x - corner));
        accept(*mpm, du, settings);
        F(0, 0) *= 1.0 + factor;
      }
      EXPECT_GT(mpm->points_made(), before);
      const auto end = sums();
      EXPECT_LT((end.head<5>() - start.head<5>()).norm(), 1e-12 * start.norm());
      EXPECT_NEAR(end[5] / end[0] - corner.x(), F(0, 0) * (start[5] / start[0] - corner.x()), 1e-12);
      EXPECT_LT((end.tail<2>() - start.tail<2>()).norm(), 1e-12 * start.norm());
      const std::set<std::int64_t> ids(mpm->point_ids().begin(), mpm->point_ids().end());
      EXPECT_EQ(ids.size(), mpm->point_ids().size());
      EXPECT_EQ(static_cast<long>(ids.size()), mpm->points_made());
      EXPECT_EQ(*ids.rbegin() + 1, mpm->points_made());
      for (std::size_t p = 0; p < ids.size(); ++p)
        EXPECT_LT((mpm->point_positions()[p] - corner - F * (mpm->point_origins()[p] - corner)).norm(), 1e-13);
    }
}

/// Around an axis the outer half of a point has more mass: mass times radius, summed, comes nearer to its integral.
TEST(Domains, HalvesOfRingsHaveTheMassOfTheirRadius) {
  for (const Choice& c : choices) {
    const auto mpm = make(c, Space::axisymmetric, Formulation::updated_lagrangian, true, GridKind::quads, 0.0, 0.9);
    const double a = corner.x(), b = corner.x() + 0.9 * h;
    const auto off = [&] {
      double mass = 0.0, moment = 0.0;
      for (int p = 0; p < mpm->material.size(); ++p) {
        mass += mpm->point_masses()[p];
        moment += mpm->point_masses()[p] * mpm->point_origins()[p].x();
      }
      return std::abs(moment / mass - 2.0 / 3.0 * (b * b * b - a * a * a) / (b * b - a * a));
    };
    const double before = off();
    const long points = mpm->points_made();
    for (int step = 0; step < 4; ++step) {
      NodalVector du;
      for (const Vec3& x : mpm->nodes) du.push_back(Vec3((std::pow(2.0, 0.25) - 1.0) * x.x(), 0.0, 0.0));
      accept(*mpm, du, settings_of(Space::axisymmetric, Kinematics::finite));
    }
    EXPECT_EQ(mpm->points_made(), 2 * points);
    EXPECT_NEAR(off(), 0.25 * before, 0.01 * before) << c.name;  // the error of midpoints halves twice
  }
}

/// Rows bring back points that were split, with their domains and the number of the next one.
TEST(Domains, RowsBringThePointsBack) {
  Random random;
  for (const Choice& c : choices) {
    SCOPED_TRACE(c.name);
    const LawSettings settings = settings_of(Space::plane_strain, Kinematics::finite);
    const auto make_one = [&] {
      return make(c, Space::plane_strain, Formulation::updated_lagrangian, true, GridKind::quads, 0.0, 0.9);
    };
    const auto first = make_one(), second = make_one();
    for (int step = 0; step < 3; ++step) {
      NodalVector du;
      for (const Vec3& x : first->nodes)
        du.push_back(stretch(Space::plane_strain, 0.4, 0.1, 0.0) * (x - corner));
      accept(*first, du, settings);
    }
    second->restore_points({first->point_rows(0)});
    second->move_points(1.2);
    second->begin_step({});
    EXPECT_EQ(second->points_made(), first->points_made());
    EXPECT_EQ(second->point_rows(0), first->point_rows(0));
    EXPECT_EQ(second->blocks, first->blocks);
    const NodalVector du = random(*first, 0.01 * h);
    EXPECT_EQ(force(*second, du, settings), force(*first, du, settings));
  }
}

}  // namespace
}  // namespace berm
