/// The kernels of the material point method, without a solver.

#include "transfer/mpm.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <numbers>
#include <random>

#include "../../support/dense.hpp"
#include "base/error.hpp"
#include "mesh/region.hpp"

namespace berm {
namespace {

constexpr double young = 30e9, ft = 3e6, density = 2400.0, thickness = 0.2, h = 0.1;
constexpr double onset = ft / young;
constexpr int cells = 3;

Material material(bool damage) {
  Material m;
  m.name = "concrete";
  m.density = density;
  if (damage) {
    SimoJu law;
    law.youngs_modulus = young;
    law.poisson_ratio = 0.2;
    law.tensile_strength = ft;
    law.fracture_energy = 100.0;
    law.strength_ratio = 10.0;
    m.law = law;
  } else {
    LinearElastic law;
    law.youngs_modulus = young;
    law.poisson_ratio = 0.2;
    m.law = law;
  }
  return m;
}

/// A block of the given kind of model on a grid of 3 cells a direction of size h, from (0.1, 0, 0): around an axis it
/// is a ring. Filled: the whole grid; else a box that cuts cells.
struct Model {
  const char* name;
  Space space;
  GridKind grid;
};
const Model models[] = {{"plane strain, quads", Space::plane_strain, GridKind::quads},
                        {"plane stress, triangles", Space::plane_stress, GridKind::union_jack},
                        {"axisymmetric, quads", Space::axisymmetric, GridKind::quads},
                        {"axisymmetric, triangles", Space::axisymmetric, GridKind::triangles_left},
                        {"solid, hexahedra", Space::solid, GridKind::hexahedra},
                        {"solid, tetrahedra", Space::solid, GridKind::tetrahedra}};

const Vec3 corner(0.1, 0.0, 0.0);

Grid grid_of(GridKind kind, int n = cells, const Vec3& origin = corner) {
  StructuredGrid s;
  s.kind = kind;
  s.cell_size = Vec3(h, h, h);
  s.nx = s.ny = n;
  s.origin = origin;
  if (dimension_of(kind) == 3) s.nz = n;
  return make_structured_grid(s);
}

Shape box(Space space, const Vec3& low, const Vec3& high) {
  if (space == Space::solid) return SolidShape{SolidBox{low, high}};
  return PlaneShape{Box{in_plane(low), in_plane(high)}};
}

Shape block(const Model& s, bool filled) {
  const double a = filled ? 0.0 : 0.37 * h, b = cells * h - (filled ? 0.0 : 0.57 * h);
  return box(s.space, corner + Vec3::Constant(a), corner + Vec3::Constant(b));
}

struct Options {
  bool filled = true, damage = false;
  Formulation formulation = Formulation::updated_lagrangian;
  double ghost_penalty = 0.0;
  bool fitted = false;  ///< points of a body mesh, fitted to the cells
};

std::unique_ptr<MpmDiscretisation> make(const Model& s, const Options& options) {
  auto mpm = std::make_unique<MpmDiscretisation>(grid_of(s.grid), s.space, options.ghost_penalty, options.formulation);
  const Shape shape = block(s, options.filled);
  const Region region(shape, h);
  SeededPoints points;
  if (options.fitted) {
    BodyMeshOptions mesh;
    mesh.kind = s.space == Space::solid ? BodyMeshKind::hexahedra : BodyMeshKind::quads;
    mesh.size = 0.8 * h;
    mesh.structured = true;
    points = seed_from_mesh(mesh_shape(shape, mesh), s.space == Space::solid ? 8 : 4);
    fit_to_cells(points, region, grid_of(s.grid));
  } else {
    points = seed_from_grid(region, mpm->grid(), {}, "block");
  }
  mpm->add_body(0, "block", material(options.damage), points,
                s.space == Space::solid || s.space == Space::axisymmetric ? 1.0 : thickness);
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

NodalVector zeros(const MpmDiscretisation& mpm) { return NodalVector(mpm.n_nodes(), Vec3::Zero()); }

NodalVector field(const MpmDiscretisation& mpm, const Mat3& A) {
  NodalVector u;
  for (const Vec3& x : mpm.nodes) u.push_back(A * x);
  return u;
}

class Random {
public:
  NodalVector operator()(const MpmDiscretisation& mpm, double size) {
    NodalVector u = zeros(mpm);
    for (Vec3& v : u)
      for (int d = 0; d < mpm.dimension(); ++d) v[d] = size * normal_(generator_);
    return u;
  }
  /// A displacement gradient that the model can have everywhere.
  Mat3 gradient(Space space, double size) {
    Mat3 A = Mat3::Zero();
    const int n = dimension_of(space);
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) A(i, j) = size * normal_(generator_);
    if (space == Space::axisymmetric) A(0, 1) = A(1, 0) = 0.0, A(2, 2) = A(0, 0);
    return A;
  }

private:
  std::mt19937 generator_{11};
  std::normal_distribution<double> normal_;
};

Eigen::VectorXd flat(const NodalVector& v, int dimension) {
  Eigen::VectorXd out(v.size() * dimension);
  for (std::size_t i = 0; i < v.size(); ++i) out.segment(i * dimension, dimension) = v[i].head(dimension);
  return out;
}

Eigen::VectorXd internal_force(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings) {
  EXPECT_EQ(mpm.evaluate(du, settings), Status::ok);
  NodalVector f = zeros(mpm);
  mpm.add_internal_force(f);
  return flat(f, mpm.dimension());
}

/// What `add` adds to an empty matrix.
template <class Add>
Eigen::MatrixXd assembled(const MpmDiscretisation& mpm, Add add) {
  BlockAssembler assembler;
  assembler.build(mpm.blocks, mpm.n_nodes(), mpm.dimension());
  const std::vector<char> fixed(std::size_t(mpm.n_nodes()) * mpm.dimension(), 0);
  assembler.zero(fixed, mpm.halo.n_owned, 1.0);
  add(assembler);
  return dense_of(assembler.matrix());
}

double total_volume(const MpmDiscretisation& mpm) {
  double sum = 0.0;
  for (double v : mpm.material.volume) sum += v;
  return sum;
}

double exact_volume(const Model& s, bool filled) {
  const double edge = cells * h - (filled ? 0.0 : 0.94 * h);
  const double centre = corner.x() + (filled ? 0.0 : 0.37 * h) + 0.5 * edge;
  if (s.space == Space::solid) return edge * edge * edge;
  return edge * edge * (s.space == Space::axisymmetric ? 2.0 * std::numbers::pi * centre : thickness);
}

bool on_edge(const Vec3& x, int dimension) {
  for (int d = 0; d < dimension; ++d)
    if (x[d] < corner[d] + 1e-9 || x[d] > corner[d] + cells * h - 1e-9) return true;
  return false;
}

template <class Work>
void for_all_models(Work work) {
  for (const Model& s : models)
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite})
      for (const Formulation formulation : {Formulation::updated_lagrangian, Formulation::total_lagrangian}) {
        SCOPED_TRACE(std::string(s.name) + (kinematics == Kinematics::small ? ", small" : ", finite") +
                     (formulation == Formulation::total_lagrangian ? ", total" : ", updated"));
        work(s, kinematics, formulation);
      }
}

TEST(Mpm, PointsHoldTheVolumeOfTheBody) {
  for (const Model& s : models)
    for (bool filled : {true, false})
      for (bool fitted : {true, false}) {
        SCOPED_TRACE(s.name);
        Options options;
        options.filled = filled;
        options.fitted = fitted;
        const auto mpm = make(s, options);
        const double expected = exact_volume(s, filled);
        EXPECT_NEAR(total_volume(*mpm), expected, 1e-10 * expected) << filled << fitted;
        for (std::size_t a = 0; a < mpm->active_cells().size(); ++a) {
          EXPECT_GT(mpm->fill(static_cast<int>(a)), 0.0);
          EXPECT_LT(mpm->fill(static_cast<int>(a)), 1.0 + 1e-12);
          EXPECT_FALSE(mpm->points_in(static_cast<int>(a)).empty());
        }
      }
}

/// A uniform stress: no force on nodes inside, none in sum, and on the edge those that do the right work.
TEST(Mpm, UniformStressIsInEquilibrium) {
  Random random;
  for_all_models([&](const Model& s, Kinematics kinematics, Formulation formulation) {
    Options options;
    options.formulation = formulation;
    const auto mpm = make(s, options);
    const int d = mpm->dimension();
    const Mat3 A = random.gradient(s.space, kinematics == Kinematics::small ? 1e-4 : 0.1);
    const Eigen::VectorXd f = internal_force(*mpm, field(*mpm, A), settings_of(s.space, kinematics));
    const double scale = f.cwiseAbs().maxCoeff();
    EXPECT_GT(scale, 1.0);
    Vec3 sum = Vec3::Zero();
    int inside = 0;
    for (int i = 0; i < mpm->n_nodes(); ++i) {
      sum.head(d) += f.segment(d * i, d);
      if (on_edge(mpm->nodes[i], d)) continue;
      ++inside;
      EXPECT_LT(f.segment(d * i, d).norm(), 1e-12 * scale);
    }
    EXPECT_EQ(inside, d == 3 ? 8 : 4);
    EXPECT_LT(std::abs(sum.y()), 1e-11 * scale);
    if (s.space != Space::axisymmetric) {  // radial forces do not balance around an axis
      EXPECT_LT(sum.norm(), 1e-11 * scale);
    }
    for (int k = 0; k < 3; ++k) {
      const Mat3 B = random.gradient(s.space, 1.0);
      const Mat3 F = kinematics == Kinematics::finite ? Mat3(Mat3::Identity() + A) : Mat3(Mat3::Identity());
      const Mat3 tau = response_detail::tensor(mpm->material.trial[0].stress);
      const double expected = (tau.cwiseProduct(B * F.inverse())).sum() * exact_volume(s, true);
      EXPECT_NEAR(f.dot(flat(field(*mpm, B), d)), expected, 1e-11 * tau.norm() * B.norm() * exact_volume(s, true));
    }
  });
}

/// Points that ignore the grid, fitted to it, are in equilibrium as well: formulation (23). Around an axis they are
/// not: there the integrand is quadratic.
TEST(Mpm, FittedPointsAreInEquilibrium) {
  Random random;
  for (const Model& s : models) {
    if (s.space == Space::axisymmetric) continue;
    SCOPED_TRACE(s.name);
    Options options;
    options.fitted = true;
    const auto mpm = make(s, options);
    const int d = mpm->dimension();
    const Eigen::VectorXd f =
        internal_force(*mpm, field(*mpm, random.gradient(s.space, 0.05)), settings_of(s.space, Kinematics::finite));
    for (int i = 0; i < mpm->n_nodes(); ++i)
      if (!on_edge(mpm->nodes[i], d)) {
        EXPECT_LT(f.segment(d * i, d).norm(), 1e-11 * f.cwiseAbs().maxCoeff());
      }
  }
}

TEST(Mpm, RigidMotionMakesNoForce) {
  for (const Model& s : models) {
    if (s.space == Space::axisymmetric) continue;
    SCOPED_TRACE(s.name);
    const auto mpm = make(s, {});
    const Vec3 axis = s.space == Space::solid ? Vec3(1.0, 2.0, -1.0).normalized() : Vec3(Vec3::UnitZ());
    const Mat3 A = Eigen::AngleAxisd(0.8, axis).toRotationMatrix() - Mat3::Identity();
    NodalVector u = field(*mpm, A);
    for (Vec3& v : u) v += s.space == Space::solid ? Vec3(0.3, -0.2, 0.1) : Vec3(0.3, -0.2, 0.0);
    const Eigen::VectorXd f = internal_force(*mpm, u, settings_of(s.space, Kinematics::finite));
    EXPECT_LT(f.cwiseAbs().maxCoeff(), 1e-13 * young * h * h);
  }
}

/// The tangent against differences of the force, in the first step and in one from a deformed, damaged state.
TEST(Mpm, TangentIsTheDerivativeOfTheForce) {
  Random random;
  for_all_models([&](const Model& s, Kinematics kinematics, Formulation formulation) {
    for (const bool damage : {false, true}) {
      Options options;
      options.filled = false;
      options.formulation = formulation;
      options.damage = damage;
      const auto mpm = make(s, options);
      const LawSettings settings = settings_of(s.space, kinematics);
      const double size = (damage || kinematics == Kinematics::small ? 2.0 * onset : 0.02) * h;
      double dissipated = 0.0;
      for (int step = 0; step < 2; ++step) {
        const int d = mpm->dimension(), n = d * mpm->n_nodes();
        const NodalVector du = random(*mpm, size);
        internal_force(*mpm, du, settings);
        const Eigen::MatrixXd K = assembled(*mpm, [&](BlockAssembler& m) { mpm->add_tangent(settings, m); });
        ASSERT_EQ(K.rows(), n);
        const double eps = 2e-6 * size;
        Eigen::MatrixXd numerical(n, n);
        for (int c = 0; c < n; ++c) {
          NodalVector plus = du, minus = du;
          plus[c / d][c % d] += eps;
          minus[c / d][c % d] -= eps;
          numerical.col(c) =
              (internal_force(*mpm, plus, settings) - internal_force(*mpm, minus, settings)) / (2.0 * eps);
        }
        EXPECT_LT((K - numerical).norm(), 1e-6 * K.norm()) << "damage " << damage << ", step " << step;
        if (!damage) {
          EXPECT_LT((K - K.transpose()).norm(), 1e-12 * K.norm());
        }
        internal_force(*mpm, du, settings);
        mpm->commit(du, {});
        if (damage) {
          EXPECT_GT(mpm->material.max_damage(), 0.1);
          EXPECT_GT(mpm->material.dissipated_energy(), dissipated);
        }
        dissipated = mpm->material.dissipated_energy();
        mpm->move_points(1.2);
        mpm->begin_step({});
      }
    }
  });
}

/// Small increments: the first-order change of a linear force is the stiffness, and linear fields are exact.
TEST(Mpm, StabilisationSparesLinearIncrementsAndIsSymmetric) {
  Random random;
  for (const Model& s : models) {
    SCOPED_TRACE(s.name);
    Options options;
    options.filled = false;
    options.ghost_penalty = 1e-3;
    const auto mpm = make(s, options);
    const int d = mpm->dimension(), n = d * mpm->n_nodes();
    EXPECT_GT(mpm->blocks.size(), static_cast<int>(mpm->active_cells().size()));
    const Eigen::MatrixXd K = assembled(*mpm, [&](BlockAssembler& m) {
      NodalVector unused = zeros(*mpm);
      mpm->add_stabilisation(unused, unused, &m);
    });
    EXPECT_EQ((K - K.transpose()).norm(), 0.0);
    EXPECT_GT(K.norm(), 0.0);
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> spectrum(K, Eigen::EigenvaluesOnly);
    EXPECT_GT(spectrum.eigenvalues()[0], -1e-12 * spectrum.eigenvalues()[n - 1]);
    const auto force = [&](const NodalVector& du) {
      NodalVector f = zeros(*mpm);
      mpm->add_stabilisation(du, f, nullptr);
      return flat(f, d);
    };
    for (int k = 0; k < 5; ++k) {
      const NodalVector du = random(*mpm, 1e-3);
      EXPECT_LT((force(du) - K * flat(du, d)).norm(), 1e-13 * K.norm() * flat(du, d).norm());
      NodalVector linear = field(*mpm, random.gradient(s.space, 0.1));
      for (Vec3& u : linear) u.head(d) += Vec3(0.3, -0.2, 0.1).head(d);
      EXPECT_LT(force(linear).norm(), 1e-12 * K.norm() * flat(linear, d).norm());
    }
  }
}

/// A kink of slope 1 across one face between two half-filled cells: gamma E h times the area of the face; around an
/// axis the area of the ring.
TEST(Mpm, StabilisationOfAKink) {
  for (const Model& s : models) {
    if (s.grid != GridKind::quads && s.grid != GridKind::hexahedra) continue;
    SCOPED_TRACE(s.name);
    StructuredGrid spec;
    spec.kind = s.grid;
    spec.origin = corner;
    spec.cell_size = Vec3(h, h, h);
    spec.nx = 2;
    spec.ny = 1;
    spec.nz = s.space == Space::solid ? 1 : 0;
    const double gamma = 1e-3, depth = s.space == Space::plane_strain ? thickness : 1.0;
    MpmDiscretisation mpm(make_structured_grid(spec), s.space, gamma);
    const Region region(box(s.space, corner, corner + Vec3(2.0 * h, 0.5 * h, h)), h);
    mpm.add_body(0, "half", material(false), seed_from_grid(region, mpm.grid(), {}, "half"), depth);
    mpm.move_points(1.2);
    mpm.begin_step({});
    ASSERT_EQ(mpm.blocks.size(), 3);
    for (int component = 0; component < mpm.dimension(); ++component) {
      NodalVector du = zeros(mpm), f = zeros(mpm);
      for (int i = 0; i < mpm.n_nodes(); ++i) du[i][component] = std::max(0.0, mpm.nodes[i].x() - corner.x() - h);
      mpm.add_stabilisation(du, f, nullptr);
      const double area = s.space == Space::solid          ? h * h
                          : s.space == Space::axisymmetric ? h * 2.0 * std::numbers::pi * (corner.x() + h)
                                                           : h * thickness;
      const double expected = gamma * young * h * area;
      EXPECT_NEAR(flat(du, 3).dot(flat(f, 3)), expected, 1e-12 * expected);
    }
  }
}

TEST(Mpm, StabilisationOnlyActsWhereCellsAreCut) {
  for (const Model& s : models) {
    Options options;
    options.ghost_penalty = 1e-3;
    const auto full = make(s, options);
    EXPECT_EQ(full->blocks.size(), static_cast<int>(full->active_cells().size()));
    options.filled = false;
    options.ghost_penalty = 0.0;
    const auto without = make(s, options);
    EXPECT_EQ(without->blocks.size(), static_cast<int>(without->active_cells().size()));
  }
}

TEST(Mpm, BodyForceIsTheWeight) {
  for (const Model& s : models)
    for (bool filled : {true, false}) {
      SCOPED_TRACE(s.name);
      Options options;
      options.filled = filled;
      const auto mpm = make(s, options);
      const Vec3 g = s.space == Space::axisymmetric ? Vec3(0.0, -9.81, 0.0)
                     : s.space == Space::solid      ? Vec3(1.0, -9.81, 3.0)
                                                    : Vec3(1.0, -9.81, 0.0);
      NodalVector f = zeros(*mpm);
      mpm->add_body_force([&](int, const Vec3&) { return g; }, f);
      Vec3 sum = Vec3::Zero(), moment = Vec3::Zero();
      for (int i = 0; i < mpm->n_nodes(); ++i) {
        sum += f[i];
        moment += mpm->nodes[i] * f[i].y();
      }
      const double weight = density * exact_volume(s, filled);
      EXPECT_LT((sum - weight * g).norm(), 1e-12 * weight * g.norm());
      if (s.space == Space::axisymmetric) continue;
      const Vec3 low = corner + Vec3::Constant(filled ? 0.0 : 0.37 * h),
                 high = corner + Vec3::Constant(cells * h - (filled ? 0.0 : 0.57 * h));
      const Vec3 centre = 0.5 * (low + high);
      const int d = mpm->dimension();
      EXPECT_LT((moment / (weight * g.y()) - centre).head(d).norm(), 1e-12);
    }
}

// ---- rows

/// Everything comes back from rows, in whatever order they come, and the run goes on as if nothing had been.
TEST(Mpm, RowsBringThePointsBack) {
  Random random;
  for_all_models([&](const Model& s, Kinematics kinematics, Formulation formulation) {
    for (const bool fitted : {false, true}) {
      Options options;
      options.filled = false;
      options.damage = true;
      options.formulation = formulation;
      options.fitted = fitted;
      options.ghost_penalty = 1e-3;
      const auto first = make(s, options), second = make(s, options);
      const LawSettings settings = settings_of(s.space, kinematics);
      const NodalVector du = random(*first, 2.0 * onset * h);
      internal_force(*first, du, settings);
      first->commit(du, {});
      const std::vector<double> rows = first->point_rows(0);
      const int width = first->row_width(0);
      const std::size_t n = first->point_ids().size();
      ASSERT_EQ(rows.size(), n * width);
      std::vector<double> shuffled;
      std::vector<int> order(n);
      for (std::size_t k = 0; k < n; ++k) order[k] = static_cast<int>(k);
      std::shuffle(order.begin(), order.end(), std::mt19937(1));
      for (int k : order) shuffled.insert(shuffled.end(), rows.begin() + k * width, rows.begin() + (k + 1) * width);
      second->restore_points({shuffled});
      EXPECT_EQ(second->point_rows(0), rows);
      EXPECT_EQ(second->point_ids(), first->point_ids());
      EXPECT_EQ(second->point_positions(), first->point_positions());
      EXPECT_EQ(second->point_displacements(), first->point_displacements());
      EXPECT_EQ(second->point_origins(), first->point_origins());
      for (MpmDiscretisation* mpm : {first.get(), second.get()}) {
        mpm->move_points(1.2);
        mpm->begin_step({});
      }
      EXPECT_EQ(second->active_cells(), first->active_cells());
      EXPECT_EQ(second->blocks, first->blocks);
      const NodalVector next = random(*first, 2.0 * onset * h);
      EXPECT_EQ(internal_force(*second, next, settings), internal_force(*first, next, settings));
      NodalVector f = zeros(*first), g = zeros(*first);
      first->add_stabilisation(next, f, nullptr);
      second->add_stabilisation(next, g, nullptr);
      EXPECT_EQ(f, g);
      first->commit(next, {});
      second->commit(next, {});
      EXPECT_EQ(second->point_rows(0), first->point_rows(0));
    }
  });
}

// ---- motion

/// Points move with their own shape functions: exactly so in a linear field, fitted or not.
TEST(Mpm, PointsMoveWithTheField) {
  Random random;
  for_all_models([&](const Model& s, Kinematics kinematics, Formulation formulation) {
    for (const bool fitted : {false, true}) {
      Options options;
      options.filled = false;
      options.formulation = formulation;
      options.fitted = fitted;
      const auto mpm = make(s, options);
      const std::vector<Vec3> X = mpm->point_origins();
      const Mat3 A = random.gradient(s.space, 0.02);
      const NodalVector du = field(*mpm, A);
      internal_force(*mpm, du, settings_of(s.space, kinematics));
      mpm->commit(du, {});
      const auto x = mpm->point_positions(), u = mpm->point_displacements();
      for (std::size_t p = 0; p < X.size(); ++p) {
        Vec3 expected = A * X[p];
        EXPECT_LT((u[p] - expected).norm(), 1e-14);
        EXPECT_EQ(x[p], kinematics == Kinematics::finite ? Vec3(X[p] + u[p]) : X[p]);
        EXPECT_LT((mpm->material.F[p] - Mat3::Identity() - A).norm(), 1e-13);
      }
    }
  });
}

TEST(Mpm, PointThatLeavesTheGridIsNamedWithItsPlace) {
  for (const Model& s : models) {
    SCOPED_TRACE(s.name);
    const auto mpm = make(s, {});
    NodalVector du = zeros(*mpm);
    for (Vec3& u : du) u.y() = 2.0 * cells * h;
    internal_force(*mpm, du, settings_of(s.space, Kinematics::finite));
    mpm->commit(du, {});
    try {
      mpm->move_points(1.2);
      FAIL() << "no error";
    } catch (const RunError& error) {
      const std::string text = error.what();
      const Vec3 x = mpm->point_positions()[0];
      EXPECT_NE(text.find("material point 0 has left the background grid at ("), std::string::npos) << text;
      char place[64];
      std::snprintf(place, sizeof place, "(%.6g, %.6g", x.x(), x.y());
      EXPECT_NE(text.find(place), std::string::npos) << text;
      EXPECT_NE(text.find("make the grid larger"), std::string::npos) << text;
      EXPECT_EQ(std::count(text.begin(), text.end(), ','), s.space == Space::solid ? 3 : 2) << text;
    }
    // Seen from the start it is still in its cell.
    Options total;
    total.formulation = Formulation::total_lagrangian;
    const auto still = make(s, total);
    internal_force(*still, du, settings_of(s.space, Kinematics::finite));
    still->commit(du, {});
    EXPECT_NO_THROW(still->move_points(1.2));
  }
}

TEST(Mpm, BodiesThatDoNotFitAreRefused) {
  for (const Model& s : models) {
    MpmDiscretisation mpm(grid_of(s.grid), s.space, 0.0);
    SeededPoints points;
    points.add(corner + Vec3(-0.01, 0.01, s.space == Space::solid ? 0.01 : 0.0), 1e-3);
    try {
      mpm.add_body(0, "stray", material(false), points, 1.0);
      FAIL() << "no error";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("body \"stray\": a material point at (0.09, 0.01"), std::string::npos)
          << error.what();
    }
    points = {};
    points.add(corner + Vec3(0.01, 0.01, s.space == Space::solid ? 0.01 : 0.0), 1e-3);
    Material brittle = material(true);
    std::get<SimoJu>(brittle.law).fracture_energy = 0.1;
    EXPECT_THROW(mpm.add_body(0, "brittle", brittle, points, 1.0), InputError);
  }
}

// ---- around an axis

/// Points on the axis and ever nearer to it, in a state without radial motion there: finite forces, the right strains.
TEST(Mpm, PointsNearTheAxisGiveFiniteForces) {
  for (GridKind kind : {GridKind::quads, GridKind::triangles_right})
    for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite}) {
      MpmDiscretisation mpm(grid_of(kind, cells, Vec3::Zero()), Space::axisymmetric, 1e-3);
      SeededPoints points;
      for (double r : {0.0, 1e-16, 1e-12, 1e-11, 1e-9, 1e-6, 1e-3, 0.03, 0.12})
        for (double z : {0.02, 0.08, 0.22}) points.add(Vec3(r, z, 0.0), 1e-4);
      mpm.add_body(0, "rod", material(false), points, 1.0);
      mpm.move_points(1.2);
      mpm.begin_step({});
      const LawSettings settings = settings_of(Space::axisymmetric, kinematics);
      const double a = 1e-3, b = -2e-3;
      const Mat3 A = Vec3(a, b, a).asDiagonal();
      const Eigen::VectorXd f = internal_force(mpm, field(mpm, A), settings);
      EXPECT_TRUE(f.allFinite());
      EXPECT_LT(f.cwiseAbs().maxCoeff(), young * 1e-2);
      for (std::size_t p = 0; p < points.x.size(); ++p) {
        const double r = points.x[p].x(), rounding = 1e-15 * a * h / std::max(r, 1e-9 * h);  // of N over r
        EXPECT_LT((mpm.material.trial_F[p] - Mat3::Identity() - A).norm(), 1e-13 + rounding) << r;
      }
      const Eigen::MatrixXd K = assembled(mpm, [&](BlockAssembler& m) { mpm.add_tangent(settings, m); });
      EXPECT_TRUE(K.allFinite());
      mpm.commit(field(mpm, A), {});
      EXPECT_NO_THROW(mpm.move_points(1.2));
    }
}

/// A rod about its axis, whole cells: equilibrium inside and the axial force of every cross-section.
TEST(Mpm, RodAboutItsAxisCarriesItsStress) {
  for (GridKind kind : {GridKind::quads, GridKind::union_jack}) {
    MpmDiscretisation mpm(grid_of(kind, cells, Vec3::Zero()), Space::axisymmetric, 0.0);
    const Region region(box(Space::axisymmetric, Vec3::Zero(), Vec3::Constant(cells * h)), h);
    mpm.add_body(0, "rod", material(false), seed_from_grid(region, mpm.grid(), {}, "rod"), 1.0);
    mpm.move_points(1.2);
    mpm.begin_step({});
    const double radius = cells * h, pi = std::numbers::pi;
    EXPECT_NEAR(total_volume(mpm), pi * radius * radius * radius, 1e-12);
    const double strain = 1e-4;
    const Mat3 A = Vec3(-0.2 * strain, strain, -0.2 * strain).asDiagonal();  // uniaxial stress along the axis
    const Eigen::VectorXd f = internal_force(mpm, field(mpm, A), settings_of(Space::axisymmetric, Kinematics::small));
    double top = 0.0;
    for (int i = 0; i < mpm.n_nodes(); ++i) {
      EXPECT_LT(std::abs(f[2 * i]), 1e-9 * young * strain * h * h);  // no radial stress anywhere
      if (mpm.nodes[i].y() > radius - 1e-9) top += f[2 * i + 1];
    }
    EXPECT_NEAR(top, young * strain * pi * radius * radius, 1e-10 * young * strain);
  }
}

// ---- anchors

TEST(Mpm, AnchorsFindTheirCellsAndMove) {
  Random random;
  for (const Model& s : models) {
    SCOPED_TRACE(s.name);
    const bool space = s.space == Space::solid;
    MpmDiscretisation mpm(grid_of(s.grid), s.space, 1e-3);
    const Region region(box(s.space, corner, corner + Vec3(0.9 * h, 0.9 * h, 0.9 * h)), h);
    mpm.add_body(0, "block", material(false), seed_from_grid(region, mpm.grid(), {}, "block"), 1.0);
    std::vector<Anchor> anchors(3);
    const double z = space ? 0.04 : 0.0;
    anchors[0].X = corner + Vec3(0.03, 0.07, z);
    anchors[1].X = corner + Vec3(0.27, 0.26, space ? 0.23 : 0.0);  // no point far and wide
    anchors[2].X = corner + Vec3(h, 0.05, z);                      // on the edge of a cell, looking back
    anchors[2].inward = -Vec3::UnitX();
    std::vector<Anchor*> list;
    mpm.move_points(1.2);
    for (Anchor& a : anchors) {
      a.x = a.X;
      EXPECT_EQ(mpm.locate(a), 0);
      list.push_back(&a);
    }
    mpm.begin_step(list);
    EXPECT_LT(cell_centre(mpm.mesh(), anchors[2].cell).x(), corner.x() + h);
    const NodalVector du = field(mpm, random.gradient(s.space, 0.01));
    for (const Anchor& a : anchors) {
      EXPECT_EQ(mpm.active_cells()[a.block], a.cell);
      double sum = 0.0;
      Vec3 place = Vec3::Zero();
      for (int k = 0; k < a.stencil->n; ++k) {
        sum += a.stencil->N[k];
        place += a.stencil->N[k] * mpm.nodes[a.stencil->node[k]];
        const auto nodes = mpm.blocks[a.block];
        EXPECT_EQ(std::count(nodes.begin(), nodes.end(), a.stencil->node[k]), 1);
      }
      EXPECT_NEAR(sum, 1.0, 1e-13);
      EXPECT_LT((place - a.X).norm(), 1e-14);
    }
    EXPECT_EQ(mpm.fill(anchors[1].block), 0.0);
    internal_force(mpm, du, settings_of(s.space, Kinematics::finite));
    mpm.commit(du, list);
    for (const Anchor& a : anchors) {
      EXPECT_EQ(a.u, a.stencil->interpolate(du));
      EXPECT_EQ(a.x, Vec3(a.X + a.u));
      EXPECT_GT(a.u.norm(), 0.0);
    }
    Anchor lost;
    lost.X = lost.x = corner + Vec3(0.1, -0.01, z);
    EXPECT_THROW(mpm.locate(lost), RunError);
  }
}

/// The connectivity counts up only when cells or faces change.
TEST(Mpm, ConnectivityStaysWhileCellsStay) {
  const auto mpm = make(models[4], {});
  const long before = mpm->connectivity;
  mpm->move_points(1.2);
  mpm->begin_step({});
  EXPECT_EQ(mpm->connectivity, before);
  Anchor far;
  far.X = far.x = corner + Vec3::Constant(0.25);
  mpm->locate(far);
  mpm->begin_step({&far});
  EXPECT_EQ(mpm->connectivity, before);  // its cell is active already
  Options cut;
  cut.filled = false;
  cut.ghost_penalty = 1e-3;
  const auto other = make(models[0], cut);
  const long first = other->connectivity;
  NodalVector du = zeros(*other);
  for (Vec3& u : du) u.x() = -0.5 * h;
  internal_force(*other, du, settings_of(Space::plane_strain, Kinematics::finite));
  other->commit(du, {});
  EXPECT_ANY_THROW(other->move_points(1.2));
  for (Vec3& u : du) u.x() = 0.6 * h;
  other->commit(du, {});
  other->move_points(1.2);
  other->begin_step({});
  EXPECT_GE(other->connectivity, first);
}

}  // namespace
}  // namespace berm
