/// Mean dilatation over the points of a cell, without a solver.   [docs/theory/formulation.md, section 14]

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "base/error.hpp"
#include "mesh/region.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

constexpr double young = 30e6, h = 0.1;
constexpr int cells = 3;
const Vec3 corner(0.1, 0.0, 0.0);

struct Model {
  const char* name;
  Space space;
  Kinematics kinematics;
  Formulation formulation;
};

template <class Work>
void for_all_models(Work work) {
  for (const Space space : {Space::plane_strain, Space::axisymmetric, Space::solid})
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite})
      for (const Formulation formulation : {Formulation::updated_lagrangian, Formulation::total_lagrangian}) {
        SCOPED_TRACE(std::string(space == Space::solid          ? "solid"
                                 : space == Space::axisymmetric ? "axisymmetric"
                                                                : "plane strain") +
                     (kinematics == Kinematics::small ? ", small" : ", finite") +
                     (formulation == Formulation::total_lagrangian ? ", total" : ", updated"));
        work(space, kinematics, formulation);
      }
}

Material elastic() {
  LinearElastic law;
  law.youngs_modulus = young;
  law.poisson_ratio = 0.4;
  Material m;
  m.name = "rubber";
  m.law = law;
  return m;
}

Material soil(double friction_angle = 0.4) {
  MohrCoulomb law;
  law.youngs_modulus = young;
  law.poisson_ratio = 0.3;
  law.cohesion = 50e3;
  law.friction_angle = friction_angle;
  law.dilatancy_angle = 0.5 * friction_angle;
  Material m;
  m.name = "soil";
  m.law = law;
  return m;
}

Grid grid_of(Space space, GridKind kind) {
  StructuredGrid s;
  s.kind = kind;
  s.cell_size = Vec3(h, h, h);
  s.nx = s.ny = cells;
  s.nz = space == Space::solid ? cells : 0;
  s.origin = corner;
  return make_structured_grid(s);
}

/// A block from a to b times h in every direction.
void add_block(MpmDiscretisation& mpm, Space space, int body, const Material& material, double a, double b) {
  const Vec3 low = corner + Vec3::Constant(a * h), high = corner + Vec3::Constant(b * h);
  const Shape shape = space == Space::solid ? Shape(SolidShape{SolidBox{low, high}})
                                            : Shape(PlaneShape{Box{in_plane(low), in_plane(high)}});
  mpm.add_body(body, "block", material, seed_from_grid(Region(shape, h), mpm.grid(), {}, "block"), 1.0);
}

/// A block that cuts cells.
std::unique_ptr<MpmDiscretisation> make(Space space, Formulation formulation, const Material& material,
                                        Volumetric volumetric = Volumetric::f_bar) {
  const GridKind kind = space == Space::solid ? GridKind::hexahedra : GridKind::quads;
  auto mpm = std::make_unique<MpmDiscretisation>(grid_of(space, kind), space, 0.0, formulation, Comm{}, volumetric);
  add_block(*mpm, space, 0, material, 0.37, cells - 0.57);
  mpm->move_points(1.2);
  mpm->begin_step({});
  return mpm;
}

LawSettings settings_of(Space space, Kinematics kinematics) {
  LawSettings s;
  s.space = space;
  s.kinematics = kinematics;
  return s;
}

class Random {
public:
  NodalVector operator()(const MpmDiscretisation& mpm, double size) {
    NodalVector u(mpm.n_nodes(), Vec3::Zero());
    for (Vec3& v : u)
      for (int d = 0; d < mpm.dimension(); ++d) v[d] = size * normal_(generator_);
    return u;
  }

private:
  std::mt19937 generator_{5};
  std::normal_distribution<double> normal_;
};

Eigen::VectorXd force(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings) {
  EXPECT_EQ(mpm.evaluate(du, settings), Status::ok);
  NodalVector f(mpm.n_nodes(), Vec3::Zero());
  mpm.add_internal_force(f);
  const int d = mpm.dimension();
  Eigen::VectorXd out(f.size() * d);
  for (std::size_t i = 0; i < f.size(); ++i) out.segment(i * d, d) = f[i].head(d);
  return out;
}

double energy(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings) {
  EXPECT_EQ(mpm.evaluate(du, settings), Status::ok);
  double sum = 0.0;
  for (int p = 0; p < mpm.material.size(); ++p) sum += mpm.material.trial[p].stored_energy * mpm.material.volume[p];
  return sum;
}

Eigen::MatrixXd tangent(MpmDiscretisation& mpm, const LawSettings& settings) {
  BlockAssembler assembler;
  assembler.build(mpm.blocks, mpm.n_nodes(), mpm.dimension());
  const std::vector<char> fixed(std::size_t(mpm.n_nodes()) * mpm.dimension(), 0);
  assembler.zero(fixed, mpm.halo.n_owned, 1.0);
  mpm.add_tangent(settings, assembler);
  const CsrMatrix& csr = assembler.matrix();
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(csr.n, csr.n);
  for (int row = 0; row < csr.n; ++row)
    for (int k = csr.row_begin[row]; k < csr.row_begin[row + 1]; ++k) K(row, csr.column[k]) = csr.value[k];
  return K;
}

/// Central difference of a function of one component of du.
template <class F>
auto difference(const NodalVector& du, int component, int dimension, double eps, F f) {
  NodalVector plus = du, minus = du;
  plus[component / dimension][component % dimension] += eps;
  minus[component / dimension][component % dimension] -= eps;
  return ((f(plus) - f(minus)) / (2.0 * eps)).eval();
}

void accept(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings) {
  force(mpm, du, settings);
  mpm.commit(du, {});
  mpm.move_points(1.2);
  mpm.begin_step({});
}

double size_of(Kinematics kinematics) { return (kinematics == Kinematics::small ? 3e-3 : 0.03) * h; }

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
        const int d = mpm->dimension(), n = d * mpm->n_nodes();
        const NodalVector du = random(*mpm, size);
        force(*mpm, du, settings);
        const Eigen::MatrixXd K = tangent(*mpm, settings);
        Eigen::MatrixXd numerical(n, n);
        for (int c = 0; c < n; ++c)
          numerical.col(c) =
              difference(du, c, d, 1e-6 * size, [&](const NodalVector& u) { return force(*mpm, u, settings); });
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
    Eigen::MatrixXd numerical(K.rows(), K.cols());
    for (int c = 0; c < K.cols(); ++c)
      numerical.col(c) = difference(du, c, 2, 1e-6 * h, [&](const NodalVector& u) { return force(mpm, u, settings); });
    EXPECT_LT((K - numerical).norm(), 1e-7 * K.norm());
  }
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
