/// Pressures of their own at the nodes, without a solver.   [docs/theory/formulation.md, section 15]

#include "blocks.hpp"

namespace berm {
namespace {

std::unique_ptr<MpmDiscretisation> make(Space space, Formulation formulation, const Material& material) {
  return make(space, formulation, material, Volumetric::mixed);
}

/// Random displacements, and pressures of about the size that belongs to them.
NodalVector random_state(Random& random, const MpmDiscretisation& mpm, double size) {
  NodalVector du = random(mpm, size);
  for (int node : mpm.scalar_nodes()) du[node].tail<2>().setZero();
  return du;
}

/// Every node has a pressure node at its place; both come in a block for every cell.
TEST(Mixed, PressuresAreNodesOfTheirOwn) {
  const auto mpm = make(Space::plane_strain, Formulation::updated_lagrangian, elastic());
  const std::vector<int>& pressures = mpm->scalar_nodes();
  EXPECT_EQ(2 * static_cast<int>(pressures.size()), mpm->n_nodes());
  for (int node : pressures) EXPECT_GE(mpm->halo.ids[node], mpm->mesh().n_nodes());
  const int cells = static_cast<int>(mpm->active_cells().size());
  ASSERT_EQ(mpm->blocks.size(), 2 * cells);
  for (int c = 0; c < cells; ++c) {
    const auto own = mpm->blocks[c], both = mpm->blocks[cells + c];
    ASSERT_EQ(both.size(), 2 * own.size());
    for (std::size_t k = 0; k < own.size(); ++k) {
      EXPECT_EQ(both[k], own[k]);
      EXPECT_EQ(mpm->nodes[both[own.size() + k]], mpm->nodes[own[k]]);
    }
  }
}

/// Elastic, Tresca and Mohr-Coulomb (its vertex: see FBar), in the first step and in one from a deformed state.
TEST(Mixed, TangentIsTheDerivativeOfTheForce) {
  Random random;
  const struct {
    Material material;
    bool plastic;
    double tolerance;
  } laws[] = {{elastic(), false, 1e-6}, {soil(0.0), true, 1e-6}, {soil(), true, 5.0 * MohrCoulomb::residual_stiffness}};
  for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
    for (const auto& law : laws) {
      const auto mpm = make(space, formulation, law.material);
      const LawSettings settings = settings_of(space, kinematics);
      const double size = size_of(kinematics);
      for (int step = 0; step < 2; ++step) {
        const NodalVector du = random_state(random, *mpm, size);
        force(*mpm, du, settings);
        const Eigen::MatrixXd K = tangent(*mpm, settings);
        const Eigen::MatrixXd numerical = numerical_tangent(*mpm, du, settings, 1e-6 * size);
        EXPECT_LT((K - numerical).norm(), law.tolerance * K.norm()) << law.material.name << ", step " << step;
        if (!law.plastic) {
          EXPECT_LT((K - K.transpose()).norm(), 1e-12 * K.norm());
        }
        accept(*mpm, du, settings);
        EXPECT_EQ(mpm->material.max_plastic_strain() > 1e-4, law.plastic);
      }
    }
  });
}

/// A linear elastic solid has the mean stress of the pressure, in the directions that can change a volume, whatever the
/// displacements are.
TEST(Mixed, MeanStressIsThePressure) {
  Random random;
  for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
    const auto mpm = make(space, formulation, elastic());
    const double size = size_of(kinematics), pressure = 1e-3 * young;
    NodalVector du = random(*mpm, size);
    for (int node : mpm->scalar_nodes()) du[node] = Vec3(pressure / (young / mpm->cell_size()), 0.0, 0.0);
    force(*mpm, du, settings_of(space, kinematics));
    const int m = space == Space::plane_strain ? 2 : 3;
    for (const PointResponse& r : mpm->material.trial)
      EXPECT_NEAR((r.stress[XX] + r.stress[YY] + (m == 3 ? r.stress[ZZ] : 0.0)) / m, pressure, 1e-8 * young);
  });
}

/// Total Lagrangian: two steps lead where one does, pressures included.
TEST(Mixed, TotalLagrangianForgetsThePath) {
  Random random;
  for (const Space space : {Space::plane_strain, Space::axisymmetric, Space::solid}) {
    const LawSettings settings = settings_of(space, Kinematics::finite);
    const auto once = make(space, Formulation::total_lagrangian, elastic());
    const auto twice = make(space, Formulation::total_lagrangian, elastic());
    const NodalVector first = random_state(random, *once, 0.03 * h), second = random_state(random, *once, 0.03 * h);
    NodalVector sum = first;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += second[i];
    accept(*twice, first, settings);
    force(*once, sum, settings);
    force(*twice, second, settings);
    for (int p = 0; p < once->material.size(); ++p)
      EXPECT_LT((once->material.trial[p].stress - twice->material.trial[p].stress).norm(), 1e-10 * young);
  }
}

TEST(Mixed, RowsBringThePointsBack) {
  Random random;
  for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
    const auto first = make(space, formulation, soil()), second = make(space, formulation, soil());
    const LawSettings settings = settings_of(space, kinematics);
    accept(*first, random_state(random, *first, size_of(kinematics)), settings);
    second->restore_points({first->point_rows(0)});
    second->move_points(1.2);
    second->begin_step({});
    EXPECT_EQ(second->point_rows(0), first->point_rows(0));
    const NodalVector next = random_state(random, *first, size_of(kinematics));
    EXPECT_EQ(force(*second, next, settings), force(*first, next, settings));
  });
}

/// Differences that no point sees cost something too: pressures have one answer in a cell with a single point.
TEST(Mixed, OnePointHoldsAllPressuresOfItsCell) {
  for (const Space space : {Space::plane_strain, Space::axisymmetric, Space::solid}) {
    const GridKind kind = space == Space::solid ? GridKind::hexahedra : GridKind::quads;
    MpmDiscretisation mpm(grid_of(space, kind), space, 0.0, Formulation::updated_lagrangian, Comm{}, Volumetric::mixed);
    PointSeeding one;
    one.per_direction = 1;
    const Vec3 high = corner + Vec3(h, h, h);
    const Shape shape = space == Space::solid ? Shape(SolidShape{SolidBox{corner, high}})
                                              : Shape(PlaneShape{Box{in_plane(corner), in_plane(high)}});
    mpm.add_body(0, "block", elastic(), seed_from_grid(Region(shape, h), mpm.grid(), one, "block"), 1.0);
    mpm.move_points(1.2);
    mpm.begin_step({});
    ASSERT_EQ(mpm.material.size(), 1);
    const LawSettings settings = settings_of(space, Kinematics::small);
    force(mpm, NodalVector(mpm.n_nodes(), Vec3::Zero()), settings);
    const Eigen::MatrixXd K = tangent(mpm, settings);
    const int n = static_cast<int>(mpm.scalar_nodes().size()), d = mpm.dimension();
    Eigen::MatrixXd pressures(n, n);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) pressures(i, j) = K(d * mpm.scalar_nodes()[i], d * mpm.scalar_nodes()[j]);
    const Eigen::VectorXd size = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(-pressures).eigenvalues();
    EXPECT_GT(size.minCoeff(), 1e-5 * size.maxCoeff());
  }
}

TEST(Mixed, InvertedPointIsNotAdmissible) {
  for (const Formulation formulation : {Formulation::updated_lagrangian, Formulation::total_lagrangian}) {
    const auto mpm = make(Space::plane_strain, formulation, elastic());
    NodalVector du(mpm->n_nodes(), Vec3::Zero());
    for (std::size_t i = 0; i < du.size(); ++i)
      if ((mpm->nodes[i] - corner - Vec3(h, h, 0.0)).norm() < 1e-9) du[i] = Vec3(0.9 * h, 0.9 * h, 0.0);
    for (int node : mpm->scalar_nodes()) du[node].setZero();
    EXPECT_EQ(mpm->evaluate(du, settings_of(Space::plane_strain, Kinematics::finite)), Status::not_admissible);
  }
}

/// A cell that an anchor alone keeps active has no pressure; when points come, it gets one.
TEST(Mixed, CellsWithoutPointsHaveNoPressure) {
  MpmDiscretisation mpm(grid_of(Space::plane_strain, GridKind::quads), Space::plane_strain, 0.0,
                        Formulation::updated_lagrangian, Comm{}, Volumetric::mixed);
  add_block(mpm, Space::plane_strain, 0, elastic(), 0.0, 1.0);
  mpm.move_points(1.2);
  Anchor anchor;
  anchor.X = anchor.x = corner + Vec3(1.1 * h, 0.5 * h, 0.0);
  anchor.rigid = true;
  mpm.locate(anchor);
  mpm.begin_step({&anchor});
  EXPECT_EQ(mpm.active_cells().size(), 2u);
  EXPECT_EQ(mpm.scalar_nodes().size(), 4u);
  NodalVector du(mpm.n_nodes(), Vec3::Zero());
  for (Vec3& v : du) v.x() = 0.4 * h;
  for (int node : mpm.scalar_nodes()) du[node].setZero();
  accept(mpm, du, settings_of(Space::plane_strain, Kinematics::finite));
  mpm.locate(anchor);
  mpm.begin_step({&anchor});
  EXPECT_EQ(mpm.active_cells().size(), 2u);
  EXPECT_EQ(mpm.scalar_nodes().size(), 6u);
}

}  // namespace
}  // namespace berm
