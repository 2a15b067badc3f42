/// Mean dilatation over the points of a cell, without a solver.   [docs/theory/formulation.md, section 14]

#include "blocks.hpp"

namespace berm {
namespace {

std::unique_ptr<MpmDiscretisation> make(Space space, Formulation formulation, const Material& material) {
  return make(space, formulation, material, Volumetric::f_bar);
}

/// In the first step, and in one from a deformed state.
TEST(FBar, ForceIsTheDerivativeOfTheEnergy) {
  Random random;
  for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
    const auto mpm = make(space, formulation, elastic());
    const LawSettings settings = settings_of(space, kinematics);
    const double size = size_of(kinematics);
    for (int step = 0; step < 2; ++step) {
      const int d = mpm->dimension(), n = d * mpm->n_nodes();
      const NodalVector du = random(*mpm, size);
      const Eigen::VectorXd f = force(*mpm, du, settings);
      Eigen::VectorXd numerical(n);
      for (int c = 0; c < n; ++c)
        numerical[c] = difference(du, c, d, 1e-5 * size, [&](const NodalVector& u) {
          return Eigen::Matrix<double, 1, 1>(energy(*mpm, u, settings));
        })[0];
      EXPECT_LT((f - numerical).norm(), 1e-7 * f.norm()) << "step " << step;
      accept(*mpm, du, settings);
    }
  });
}

/// Elastic, Tresca and Mohr-Coulomb, whose tangent at a vertex keeps a share of the elastic one that the force has not.
TEST(FBar, TangentIsTheDerivativeOfTheForce) {
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
        const NodalVector du = random(*mpm, size);
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

/// All points of a cell change their volume alike, and the body as a whole by what its points do without F-bar.
TEST(FBar, DilatationIsUniformInACellAndKeepsTheVolume) {
  Random random;
  for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
    const auto mpm = make(space, formulation, elastic());
    const auto plain = make(space, formulation, elastic(), Volumetric::standard);
    const bool small = kinematics == Kinematics::small;
    const auto dilatation = [&](const MpmDiscretisation& m, int p) {
      const Mat3& F = m.material.trial_F[p];
      return small ? F.trace() - 3.0 : F.determinant();
    };
    const NodalVector du = random(*mpm, size_of(kinematics));
    force(*mpm, du, settings_of(space, kinematics));
    force(*plain, du, settings_of(space, kinematics));
    double volume = 0.0, expected = 0.0, apart = 0.0;
    for (std::size_t a = 0; a < mpm->active_cells().size(); ++a) {
      const auto points = mpm->points_in(static_cast<int>(a));
      for (int p : points) {
        const double own = dilatation(*mpm, p);
        EXPECT_NEAR(own, dilatation(*mpm, points[0]), 1e-13);
        apart = std::max(apart, std::abs(own - dilatation(*plain, p)));
        volume += mpm->material.volume[p] * own;
        expected += mpm->material.volume[p] * dilatation(*plain, p);
        if (space == Space::plane_strain) {
          EXPECT_EQ(mpm->material.trial_F[p](2, 2), 1.0);
        }
      }
    }
    EXPECT_GT(apart, small ? 3e-4 : 1e-2);
    EXPECT_NEAR(volume, expected, 1e-13);
  });
}

/// A second step of the total Lagrangian form starts from the displacements, not from the averaged gradients: two steps
/// lead where one does.
TEST(FBar, TotalLagrangianForgetsThePath) {
  Random random;
  for (const Space space : {Space::plane_strain, Space::axisymmetric, Space::solid}) {
    const LawSettings settings = settings_of(space, Kinematics::finite);
    const auto once = make(space, Formulation::total_lagrangian, elastic());
    const auto twice = make(space, Formulation::total_lagrangian, elastic());
    const NodalVector first = random(*once, 0.03 * h), second = random(*once, 0.03 * h);
    NodalVector sum = first;
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += second[i];
    accept(*twice, first, settings);
    const Eigen::VectorXd f = force(*once, sum, settings), g = force(*twice, second, settings);
    EXPECT_LT((f - g).norm(), 1e-12 * f.norm());
  }
}

/// Two bodies in one cell do not share their dilatation: a stiff one would keep a soft one from changing its volume.
TEST(FBar, BodiesInOneCellHaveTheirOwnDilatation) {
  MpmDiscretisation mpm(grid_of(Space::plane_strain, GridKind::quads), Space::plane_strain, 0.0,
                        Formulation::updated_lagrangian, Comm{}, Volumetric::f_bar);
  add_block(mpm, Space::plane_strain, 0, elastic(), 0.0, 1.4);
  add_block(mpm, Space::plane_strain, 1, soil(), 1.4, 2.0);
  mpm.move_points(1.2);
  mpm.begin_step({});
  Random random;
  force(mpm, random(mpm, 0.01 * h), settings_of(Space::plane_strain, Kinematics::finite));
  const int second = mpm.material.slices[1].begin;
  bool shared = false;
  for (std::size_t a = 0; a < mpm.active_cells().size(); ++a) {
    const auto points = mpm.points_in(static_cast<int>(a));
    if (points.front() >= second || points.back() < second) continue;
    shared = true;
    const auto J = [&](int p) { return mpm.material.trial_F[p].determinant(); };
    EXPECT_NE(J(points.front()), J(points.back()));
    for (int p : points) EXPECT_NEAR(J(p), J(p < second ? points.front() : points.back()), 1e-14);
  }
  EXPECT_TRUE(shared);
}

/// A point turned inside out is seen although the mean of its cell is positive.
TEST(FBar, InvertedPointIsNotAdmissible) {
  for (const Formulation formulation : {Formulation::updated_lagrangian, Formulation::total_lagrangian}) {
    const auto mpm = make(Space::plane_strain, formulation, elastic());
    NodalVector du(mpm->n_nodes(), Vec3::Zero());
    for (std::size_t i = 0; i < du.size(); ++i)
      if ((mpm->nodes[i] - corner - Vec3(h, h, 0.0)).norm() < 1e-9) du[i] = Vec3(0.9 * h, 0.9 * h, 0.0);
    EXPECT_EQ(mpm->evaluate(du, settings_of(Space::plane_strain, Kinematics::finite)), Status::not_admissible);
  }
}

/// Rows bring the state of the total Lagrangian form back, which needs more than the averaged gradient.
TEST(FBar, RowsBringThePointsBack) {
  Random random;
  for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
    const auto first = make(space, formulation, soil()), second = make(space, formulation, soil());
    const LawSettings settings = settings_of(space, kinematics);
    accept(*first, random(*first, size_of(kinematics)), settings);
    second->restore_points({first->point_rows(0)});
    second->move_points(1.2);
    second->begin_step({});
    EXPECT_EQ(second->point_rows(0), first->point_rows(0));
    const NodalVector next = random(*first, size_of(kinematics));
    EXPECT_EQ(force(*second, next, settings), force(*first, next, settings));
  });
}

/// Triangles among quads stay as they are.
TEST(FBar, TrianglesAmongQuads) {
  Mesh mesh;
  for (const Vec3& x :
       {Vec3(0.0, 0.0, 0.0), Vec3(h, 0.0, 0.0), Vec3(h, h, 0.0), Vec3(0.0, h, 0.0), Vec3(2 * h, 0.5 * h, 0.0)})
    mesh.nodes.push_back(x);
  const int quad[] = {0, 1, 2, 3}, triangle[] = {1, 4, 2};
  mesh.add_cell(CellKind::quad4, quad);
  mesh.add_cell(CellKind::tri3, triangle);
  SeededPoints points;
  for (double x : {0.2, 0.7, 1.2, 1.5})
    for (double y : {0.45, 0.6}) points.add(h * Vec3(x, y, 0.0), 0.2 * h * h);
  for (const Space space : {Space::plane_strain, Space::axisymmetric}) {
    MpmDiscretisation mpm(make_unstructured_grid(mesh), space, 0.0, Formulation::updated_lagrangian, Comm{},
                          Volumetric::f_bar);
    mpm.add_body(0, "block", elastic(), points, 1.0);
    mpm.move_points(1.2);
    mpm.begin_step({});
    const LawSettings settings = settings_of(space, Kinematics::finite);
    Random random;
    const NodalVector du = random(mpm, 0.03 * h);
    force(mpm, du, settings);
    const Eigen::MatrixXd K = tangent(mpm, settings);
    const Eigen::MatrixXd numerical = numerical_tangent(mpm, du, settings, 1e-6 * h);
    EXPECT_LT((K - numerical).norm(), 1e-7 * K.norm());
  }
}

/// Points whose domains cover several cells: boxes of linear functions and of quadratic B-splines, parallelograms.
template <class Work>
void for_all_domains(Work work) {
  using Domain = ShapeChoice::Domain;
  for_all_models([&](Space space, Kinematics kinematics, Formulation formulation) {
    const bool follows = kinematics == Kinematics::finite && formulation == Formulation::updated_lagrangian;
    for (const ShapeChoice& shapes : {ShapeChoice{1, Domain::box, follows}, ShapeChoice{2, Domain::box, follows},
                                      ShapeChoice{1, Domain::parallelepiped, follows}}) {
      if (space == Space::solid && shapes.degree == 2) continue;  // as in the plane
      SCOPED_TRACE(testing::Message() << "degree " << shapes.degree << ", domain " << int(shapes.domain));
      const GridKind kind = space == Space::solid ? GridKind::hexahedra : GridKind::quads;
      const auto mpm = std::make_unique<MpmDiscretisation>(grid_of(space, kind), space, 0.0, formulation, Comm{},
                                                           Volumetric::f_bar, shapes);
      PointSeeding seeding;
      seeding.placement = PointSeeding::Placement::uniform;
      add_block(*mpm, space, 0, elastic(), 0.37, cells - 0.57, seeding);
      mpm->move_points(1.2);
      mpm->begin_step({});
      work(*mpm, space, kinematics);
    }
  });
}

TEST(FBar, TangentIsTheDerivativeOfTheForceWithDomains) {
  Random random;
  for_all_domains([&](MpmDiscretisation& mpm, Space space, Kinematics kinematics) {
    const LawSettings settings = settings_of(space, kinematics);
    const double size = size_of(kinematics);
    for (int step = 0; step < 2; ++step) {
      const NodalVector du = random(mpm, size);
      force(mpm, du, settings);
      const Eigen::MatrixXd K = tangent(mpm, settings);
      const Eigen::MatrixXd numerical = numerical_tangent(mpm, du, settings, 1e-6 * size);
      EXPECT_LT((K - numerical).norm(), 1e-6 * K.norm()) << "step " << step;
      accept(mpm, du, settings);
    }
  });
}

/// The points of a patch share their dilatation, and patches hold several: with one point each nothing would be averaged.
TEST(FBar, DilatationIsUniformInAPatchOfDomains) {
  Random random;
  for_all_domains([&](MpmDiscretisation& mpm, Space space, Kinematics kinematics) {
    force(mpm, random(mpm, size_of(kinematics)), settings_of(space, kinematics));
    int most = 0, all = 0;
    for (int a = 0; a < mpm.n_patches(); ++a) {
      const auto points = mpm.points_in(a);
      const auto dilatation = [&](int p) {
        const Mat3& F = mpm.material.trial_F[p];
        return kinematics == Kinematics::small ? F.trace() - 3.0 : F.determinant();
      };
      for (const int p : points) EXPECT_NEAR(dilatation(p), dilatation(points[0]), 1e-13);
      most = std::max(most, static_cast<int>(points.size()));
      all += static_cast<int>(points.size());
    }
    EXPECT_GE(most, 1 << mpm.dimension());
    EXPECT_EQ(all, mpm.material.size());
  });
}

TEST(FBar, TrianglesAloneAreRefused) {
  try {
    MpmDiscretisation(grid_of(Space::plane_strain, GridKind::union_jack), Space::plane_strain, 0.0,
                      Formulation::updated_lagrangian, Comm{}, Volumetric::f_bar);
    FAIL() << "no error";
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("quads or hexahedra"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace berm
