/// Forces from stresses at Gauss points (docs/theory/formulation.md, section 18).

#include "blocks.hpp"

namespace berm {
namespace {

/// A grid of 3 cells a direction, full of points at random places, `per_cell` in each.
std::unique_ptr<MpmDiscretisation> full(Space space, GridKind kind, bool at_gauss_points, int per_cell = 10,
                                        Formulation formulation = Formulation::updated_lagrangian) {
  ShapeChoice shapes;
  shapes.at_gauss_points = at_gauss_points;
  auto mpm = std::make_unique<MpmDiscretisation>(grid_of(space, kind), space, 0.0, formulation, Comm{},
                                                 Volumetric::standard, shapes);
  const Mesh& mesh = mpm->grid().mesh;
  std::mt19937 generator(2);
  std::uniform_real_distribution<double> in(0.0, 1.0);
  SeededPoints points;
  for (int c = 0; c < mesh.n_cells(); ++c)
    for (int k = 0; k < per_cell; ++k) {
      Vec3 place = Vec3::Zero();
      double sum = 0.0;
      for (const int node : mesh.nodes_of_cell(c)) {
        const double share = std::pow(in(generator), 3);
        place += share * mesh.nodes[node];
        sum += share;
      }
      points.add(place / sum, cell_measure(mesh, c) / per_cell);
    }
  mpm->add_body(0, "block", elastic(), points, 1.0);
  mpm->move_points(1.2);
  mpm->begin_step({});
  return mpm;
}

struct Kind {
  Space space;
  GridKind kind;
};
const Kind kinds[] = {{Space::plane_strain, GridKind::quads},
                      {Space::plane_strain, GridKind::union_jack},
                      {Space::plane_stress, GridKind::quads},
                      {Space::solid, GridKind::hexahedra},
                      {Space::solid, GridKind::tetrahedra}};

/// Nodes off the edge of the grid.
bool is_inner(const Vec3& x, int dimension) {
  bool inner = true;
  for (int i = 0; i < dimension; ++i) inner &= x[i] > corner[i] + 1e-9 && x[i] < corner[i] + cells * h - 1e-9;
  return inner;
}

/// Force at node I for stresses that are linear in the place: -div stress times the integral of N_I.
double largest_error(MpmDiscretisation& mpm, const LawSettings& settings) {
  NodalVector f(mpm.n_nodes(), Vec3::Zero()), volume(mpm.n_nodes(), Vec3::Zero());
  EXPECT_EQ(mpm.evaluate(f, settings), Status::ok);
  const std::vector<Vec3> x = mpm.point_positions();
  for (std::size_t p = 0; p < x.size(); ++p) {
    Voigt& s = mpm.material.trial[p].stress;
    s << 1.0 + 20.0 * x[p].x(), 3.0 - 10.0 * x[p].y(), 5.0 * x[p].z(), 2.0 + 30.0 * x[p].y(), 0.0, 0.0;
  }
  mpm.add_internal_force(f);
  // Integrals of the functions: they are linear in simplices, and means in boxes are those of the corners.
  const Mesh& mesh = mpm.grid().mesh;
  std::map<int, double> integral;
  for (int c = 0; c < mesh.n_cells(); ++c)
    for (const int node : mesh.nodes_of_cell(c))
      integral[node] += cell_measure(mesh, c) / static_cast<double>(mesh.nodes_of_cell(c).size());
  const Vec3 divergence(50.0, -10.0, mpm.dimension() == 3 ? 5.0 : 0.0);  // of the stress, row by row
  double largest = 0.0;
  for (int i = 0; i < mpm.n_nodes(); ++i)
    if (is_inner(mpm.nodes[i], mpm.dimension()))
      largest = std::max(largest, (f[i] + divergence * integral[static_cast<int>(mpm.halo.ids[i])]).norm() /
                                      (50.0 * std::pow(h, mpm.dimension())));
  return largest;
}

/// Wherever the points are. With their own gradients the forces are off by a good part.
TEST(GaussQuadrature, LinearStressesPushExactly) {
  for (const Kind& k : kinds) {
    const LawSettings settings = settings_of(k.space, Kinematics::small);
    EXPECT_LT(largest_error(*full(k.space, k.kind, true), settings), 1e-9);
    EXPECT_GT(largest_error(*full(k.space, k.kind, false), settings), 0.05);
  }
}

TEST(GaussQuadrature, TangentIsTheDerivativeOfTheForce) {
  Random random;
  for (const Kind& k : kinds)
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite})
      for (const Formulation formulation : {Formulation::updated_lagrangian, Formulation::total_lagrangian}) {
        const LawSettings settings = settings_of(k.space, kinematics);
        const auto mpm = full(k.space, k.kind, true, 10, formulation);
        NodalVector start = random(*mpm, size_of(kinematics));  // no point leaves the grid
        for (int i = 0; i < mpm->n_nodes(); ++i)
          if (!is_inner(mpm->nodes[i], mpm->dimension())) start[i].setZero();
        accept(*mpm, start, settings);
        const NodalVector du = random(*mpm, size_of(kinematics));
        force(*mpm, du, settings);
        const Eigen::MatrixXd K = tangent(*mpm, settings);
        std::mt19937 generator(3);
        for (int n = 0; n < 8; ++n) {
          const int c = static_cast<int>(generator() % K.cols());
          const Eigen::VectorXd column = difference(du, c, mpm->dimension(), 1e-6 * h,
                                                    [&](const NodalVector& u) { return force(*mpm, u, settings); });
          EXPECT_LT((K.col(c) - column).cwiseAbs().maxCoeff(), 1e-6 * K.cwiseAbs().maxCoeff());
        }
      }
}

/// No force in sum, whatever the stress: the nodes share out what they get.
TEST(GaussQuadrature, ForcesBalance) {
  Random random;
  for (const Kind& k : kinds) {
    const auto mpm = full(k.space, k.kind, true);
    const LawSettings settings = settings_of(k.space, Kinematics::finite);
    const Eigen::VectorXd f = force(*mpm, random(*mpm, 0.02 * h), settings);
    for (int i = 0; i < mpm->dimension(); ++i) {
      double sum = 0.0;
      for (int node = 0; node < mpm->n_nodes(); ++node) sum += f[node * mpm->dimension() + i];
      EXPECT_LT(std::abs(sum), 1e-10 * f.cwiseAbs().maxCoeff());
    }
  }
}

/// Where the points of a cell do not determine a linear stress they push with their own gradients.
TEST(GaussQuadrature, TooFewPointsPushThemselves) {
  for (const Kind& k : kinds) {
    Random random, again;
    const LawSettings settings = settings_of(k.space, Kinematics::small);
    const auto one = full(k.space, k.kind, true, 1), points = full(k.space, k.kind, false, 1);
    const Eigen::VectorXd f = force(*one, random(*one, 1e-3 * h), settings);
    EXPECT_LT((f - force(*points, again(*points, 1e-3 * h), settings)).norm(), 1e-14 * f.norm());
  }
}

/// A block that leaves the outer cells of the grid empty or cut: nothing is inside, everything as without.
TEST(GaussQuadrature, CutCellsKeepTheirPoints) {
  for (const Space space : {Space::plane_strain, Space::solid}) {
    const GridKind kind = space == Space::solid ? GridKind::hexahedra : GridKind::quads;
    Eigen::VectorXd f[2];
    for (const bool gauss : {false, true}) {
      ShapeChoice shapes;
      shapes.at_gauss_points = gauss;
      MpmDiscretisation mpm(grid_of(space, kind), space, 0.0, Formulation::updated_lagrangian, Comm{},
                            Volumetric::standard, shapes);
      add_block(mpm, space, 0, elastic(), 0.37, 1.8);
      mpm.move_points(1.2);
      mpm.begin_step({});
      Random random;
      f[gauss] = force(mpm, random(mpm, 1e-3 * h), settings_of(space, Kinematics::small));
    }
    EXPECT_EQ(f[0], f[1]);
  }
}

}  // namespace
}  // namespace berm
