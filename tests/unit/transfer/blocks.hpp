#pragma once
/// Small blocks of material in a grid of three cells a direction, in all kinds of models, without a solver: forces, energies
/// and tangents for random displacements of the nodes.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <random>

#include "../../support/dense.hpp"
#include "base/error.hpp"
#include "mesh/region.hpp"
#include "transfer/mpm.hpp"

namespace berm {

constexpr double young = 30e6, h = 0.1;
constexpr int cells = 3;
inline const Vec3 corner(0.1, 0.0, 0.0);

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

inline Material elastic() {
  LinearElastic law;
  law.youngs_modulus = young;
  law.poisson_ratio = 0.4;
  Material m;
  m.name = "rubber";
  m.law = law;
  return m;
}

inline Material soil(double friction_angle = 0.4) {
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

inline Grid grid_of(Space space, GridKind kind) {
  StructuredGrid s;
  s.kind = kind;
  s.cell_size = Vec3(h, h, h);
  s.nx = s.ny = cells;
  s.nz = space == Space::solid ? cells : 0;
  s.origin = corner;
  return make_structured_grid(s);
}

/// A block from a to b times h in every direction.
inline void add_block(MpmDiscretisation& mpm, Space space, int body, const Material& material, double a, double b,
                      const PointSeeding& seeding = {}) {
  const Vec3 low = corner + Vec3::Constant(a * h), high = corner + Vec3::Constant(b * h);
  const Shape shape = space == Space::solid ? Shape(SolidShape{SolidBox{low, high}})
                                            : Shape(PlaneShape{Box{in_plane(low), in_plane(high)}});
  mpm.add_body(body, "block", material, seed_from_grid(Region(shape, h), mpm.grid(), seeding, "block"), 1.0);
}

/// A block that cuts cells.
inline std::unique_ptr<MpmDiscretisation> make(Space space, Formulation formulation, const Material& material,
                                        Volumetric volumetric) {
  const GridKind kind = space == Space::solid ? GridKind::hexahedra : GridKind::quads;
  auto mpm = std::make_unique<MpmDiscretisation>(grid_of(space, kind), space, 0.0, formulation, Comm{}, volumetric);
  add_block(*mpm, space, 0, material, 0.37, cells - 0.57);
  mpm->move_points(1.2);
  mpm->begin_step({});
  return mpm;
}

inline LawSettings settings_of(Space space, Kinematics kinematics) {
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

inline Eigen::VectorXd force(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings) {
  EXPECT_EQ(mpm.evaluate(du, settings), Status::ok);
  NodalVector f(mpm.n_nodes(), Vec3::Zero());
  mpm.add_internal_force(f);
  const int d = mpm.dimension();
  Eigen::VectorXd out(f.size() * d);
  for (std::size_t i = 0; i < f.size(); ++i) out.segment(i * d, d) = f[i].head(d);
  return out;
}

inline double energy(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings) {
  EXPECT_EQ(mpm.evaluate(du, settings), Status::ok);
  double sum = 0.0;
  for (int p = 0; p < mpm.material.size(); ++p) sum += mpm.material.trial[p].stored_energy * mpm.material.volume[p];
  return sum;
}

inline Eigen::MatrixXd tangent(MpmDiscretisation& mpm, const LawSettings& settings) {
  BlockAssembler assembler;
  assembler.build(mpm.blocks, mpm.n_nodes(), mpm.dimension());
  const std::vector<char> fixed(std::size_t(mpm.n_nodes()) * mpm.dimension(), 0);
  assembler.zero(fixed, mpm.halo.n_owned, 1.0);
  mpm.add_tangent(settings, assembler);
  return dense_of(assembler.matrix());
}

/// Central difference of a function of one component of du.
template <class F>
auto difference(const NodalVector& du, int component, int dimension, double eps, F f) {
  NodalVector plus = du, minus = du;
  plus[component / dimension][component % dimension] += eps;
  minus[component / dimension][component % dimension] -= eps;
  return ((f(plus) - f(minus)) / (2.0 * eps)).eval();
}

inline void accept(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings) {
  force(mpm, du, settings);
  mpm.commit(du, {});
  mpm.move_points(1.2);
  mpm.begin_step({});
}

inline double size_of(Kinematics kinematics) { return (kinematics == Kinematics::small ? 3e-3 : 0.03) * h; }

/// The tangent by central differences of the force.
inline Eigen::MatrixXd numerical_tangent(MpmDiscretisation& mpm, const NodalVector& du, const LawSettings& settings,
                                         double eps) {
  const int d = mpm.dimension(), n = d * mpm.n_nodes();
  Eigen::MatrixXd K(n, n);
  for (int c = 0; c < n; ++c)
    K.col(c) = difference(du, c, d, eps, [&](const NodalVector& u) { return force(mpm, u, settings); });
  return K;
}

}  // namespace berm
