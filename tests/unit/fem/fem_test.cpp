#include "fem/fem.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <numbers>

#include "../../support/dense.hpp"
#include "base/error.hpp"
#include "meshes.hpp"

namespace berm {
namespace {

constexpr double E = 30e9, nu = 0.2, density = 2400.0, thickness = 0.3;

Material elastic() {
  LinearElastic law;
  law.youngs_modulus = E;
  law.poisson_ratio = nu;
  return {"concrete", law, density};
}

Material damaged() {
  SimoJu law;
  law.youngs_modulus = E;
  law.poisson_ratio = nu;
  law.tensile_strength = 3e6;
  law.fracture_energy = 5e4;  // the cells are large
  law.strength_ratio = 10.0;
  return {"concrete", law, density};
}

LawSettings settings(Space space, Kinematics kinematics) { return {space, kinematics}; }

using Field = std::function<Vec3(const Vec3&)>;

NodalVector at_nodes(const FemDiscretisation& fem, const Field& field) {
  NodalVector u;
  for (const Vec3& X : fem.nodes) u.push_back(field(X));
  return u;
}

NodalVector internal_force(FemDiscretisation& fem, const NodalVector& du, const LawSettings& s) {
  EXPECT_EQ(fem.evaluate(du, s), Status::ok);
  NodalVector f(fem.n_nodes(), Vec3::Zero());
  fem.add_internal_force(f);
  return f;
}

Vec3 sum_of(const NodalVector& f) {
  Vec3 sum = Vec3::Zero();
  for (const Vec3& v : f) sum += v;
  return sum;
}

double largest(const NodalVector& f) {
  double most = 0.0;
  for (const Vec3& v : f) most = std::max(most, v.norm());
  return most;
}

/// A body of one mesh, ready for its first step.
std::unique_ptr<FemDiscretisation> ready(Space space, const Mesh& mesh, const Material& material,
                                         const std::vector<Anchor*>& anchors = {}) {
  auto fem = std::make_unique<FemDiscretisation>(space);
  fem->add_body(0, "block", material, mesh, thickness);
  fem->move_points(1.2);
  for (Anchor* a : anchors) EXPECT_EQ(fem->locate(*a), 0);
  fem->begin_step(anchors);
  return fem;
}

Space space_of(CellKind kind) { return dimension_of(kind) == 3 ? Space::solid : Space::plane_strain; }

std::string name_of_kind(CellKind kind) {
  constexpr const char* names[] = {"tri3", "quad4", "tri6", "quad8", "tet4", "hex8", "tet10", "hex20"};
  return names[static_cast<int>(kind)];
}

std::string name_of(Kinematics kinematics) { return kinematics == Kinematics::small ? "_small" : "_finite"; }

// ---- patch: a displacement that is linear in X

class Patch : public testing::TestWithParam<std::tuple<CellKind, Kinematics>> {
protected:
  CellKind kind() const { return std::get<0>(GetParam()); }
  Kinematics kinematics() const { return std::get<1>(GetParam()); }
  int dimension() const { return dimension_of(kind()); }
  Mat3 gradient() const {
    Mat3 h;
    h << 0.02, 0.03, -0.01, -0.015, 0.01, 0.02, 0.005, -0.02, -0.025;
    if (dimension() == 2) h.row(2).setZero(), h.col(2).setZero();
    return kinematics() == Kinematics::finite ? Mat3(10.0 * h) : h;
  }
};

TEST_P(Patch, HasTheSameStressEverywhereAndNoForceInside) {
  const auto fem = ready(space_of(kind()), distorted(kind(), 3, 0.05), elastic());
  const Mat3 h = gradient();
  const NodalVector f = internal_force(*fem, at_nodes(*fem, [&](const Vec3& X) { return Vec3(h * X); }),
                                       settings(space_of(kind()), kinematics()));
  const double scale = largest(f);
  ASSERT_GT(scale, 0.0);
  Vec3 moment = Vec3::Zero();
  for (int i = 0; i < fem->n_nodes(); ++i) {
    const Vec3 x = fem->nodes[i] + (kinematics() == Kinematics::finite ? Vec3(h * fem->nodes[i]) : Vec3::Zero());
    moment += x.cross(f[i]);
    if (!on_surface(fem->nodes[i], dimension())) {
      EXPECT_LT(f[i].norm(), 1e-11 * scale);
    }
  }
  EXPECT_LT(sum_of(f).norm(), 1e-11 * scale);
  EXPECT_LT(moment.norm(), 1e-11 * scale);

  // The same response as that of one point, and forces that do the work of the stress.
  PointResponse expected;
  LawInput in;
  double zz = 0.0;
  const Mat3 F = Mat3::Identity() + h;
  const auto law = std::get<LinearElastic>(elastic().law);
  ASSERT_EQ(point_response<9>(law, Space::solid, kinematics(), Mat3::Identity(), F, in, nullptr, nullptr, zz, expected),
            Status::ok);
  double volume = 0.0;
  for (int p = 0; p < fem->material.size(); ++p) {
    EXPECT_LT((fem->material.trial[p].stress - expected.stress).norm(), 1e-11 * expected.stress.norm());
    volume += fem->material.volume[p];
  }
  EXPECT_NEAR(volume, dimension() == 3 ? 1.0 : thickness, 1e-12);
  const Mat3 w = (Mat3() << 0.1, -0.2, 0.3, 0.5, 0.7, -0.4, 0.25, 0.6, -0.9).finished();  // virtual, linear in X
  const Mat3 virtual_gradient = dimension() == 3 ? w : [&] {
    Mat3 plane = Mat3::Zero();
    plane.topLeftCorner<2, 2>() = w.topLeftCorner<2, 2>();
    return plane;
  }();
  double work = 0.0;
  for (int i = 0; i < fem->n_nodes(); ++i) work += f[i].dot(virtual_gradient * fem->nodes[i]);
  const Mat3 current = kinematics() == Kinematics::finite ? Mat3(virtual_gradient * F.inverse()) : virtual_gradient;
  const double by_stress = response_detail::tensor(expected.stress).cwiseProduct(current).sum() * volume;
  EXPECT_NEAR(work, by_stress, 1e-11 * std::abs(by_stress));
}

std::string patch_name(const testing::TestParamInfo<Patch::ParamType>& info) {
  return name_of_kind(std::get<0>(info.param)) + name_of(std::get<1>(info.param));
}
INSTANTIATE_TEST_SUITE_P(Kinds, Patch,
                         testing::Combine(testing::ValuesIn(all_kinds),
                                          testing::Values(Kinematics::small, Kinematics::finite)),
                         patch_name);

// ---- tangent against differences of the force

struct TangentCase {
  Space space;
  CellKind kind;
  Kinematics kinematics;
};

class Tangent : public testing::TestWithParam<TangentCase> {};

Eigen::MatrixXd dense_tangent(const FemDiscretisation& fem, const LawSettings& s) {
  const int d = fem.dimension(), n = d * fem.n_nodes();
  BlockAssembler assembler;
  assembler.build(fem.blocks, fem.n_nodes(), d);
  const std::vector<char> fixed(n, 0);
  assembler.zero(fixed, fem.n_nodes(), 0.0);
  fem.add_tangent(s, assembler);
  return dense_of(assembler.matrix());
}

/// Strains of the order of `size`, stretched and squeezed and turned, some points more than others.
Vec3 uneven(const Vec3& X, double size, int dimension) {
  Vec3 u(X.x() + 0.3 * X.y() * X.y(), -0.5 * X.y() - 0.4 * X.x() * X.y(), 0.7 * X.z() + 0.2 * X.x() * X.x());
  u += 0.03 * Vec3(std::sin(9.0 * X.y()), std::sin(8.0 * X.x()), std::sin(7.0 * X.x() + X.z()));
  if (dimension == 2) u.z() = 0.0;
  return size * u;
}

/// A material that breaks at strains of 1e-4 (small) or 0.1, so that the geometric part counts (finite).
TEST_P(Tangent, IsTheDerivativeOfTheForceWhereDamageGrows) {
  const auto [space, kind, kinematics] = GetParam();
  const LawSettings s = settings(space, kinematics);
  const double softer = kinematics == Kinematics::finite ? 1000.0 : 1.0;
  Material material = damaged();
  std::get<SimoJu>(material.law).youngs_modulus /= softer;
  std::get<SimoJu>(material.law).fracture_energy *= 0.1 * softer;
  const Vec3 origin = space == Space::axisymmetric ? Vec3(0.4, 0.0, 0.0) : Vec3::Zero();
  const auto fem = ready(space, distorted(kind, nodes_of(kind) > corners_of(kind) ? 1 : 2, 0.05, origin), material);
  const int d = fem->dimension(), n = d * fem->n_nodes();
  const NodalVector du = at_nodes(*fem, [&](const Vec3& X) { return uneven(X, 2.5e-4 * softer, d); });
  internal_force(*fem, du, s);
  int breaking = 0;
  for (const PointResponse& r : fem->material.trial) breaking += r.damage > 0.01 && r.damage < 0.95;
  EXPECT_GE(2 * breaking, fem->material.size());
  const Eigen::MatrixXd K = dense_tangent(*fem, s);
  const double h = 1e-9 * softer;
  double error = 0.0;
  for (int column = 0; column < n; ++column) {
    NodalVector up = du, down = du;
    up[column / d][column % d] += h;
    down[column / d][column % d] -= h;
    const NodalVector f_up = internal_force(*fem, up, s), f_down = internal_force(*fem, down, s);
    for (int row = 0; row < n; ++row) {
      const double difference = (f_up[row / d][row % d] - f_down[row / d][row % d]) / (2.0 * h);
      error = std::max(error, std::abs(difference - K(row, column)));
    }
  }
  EXPECT_LT(error, 1e-6 * K.cwiseAbs().maxCoeff());
}

constexpr TangentCase tangent_cases[] = {{Space::plane_strain, CellKind::quad4, Kinematics::finite},
                                         {Space::plane_stress, CellKind::tri6, Kinematics::small},
                                         {Space::axisymmetric, CellKind::quad4, Kinematics::small},
                                         {Space::axisymmetric, CellKind::quad4, Kinematics::finite},
                                         {Space::axisymmetric, CellKind::quad8, Kinematics::finite},
                                         {Space::axisymmetric, CellKind::tri3, Kinematics::finite},
                                         {Space::axisymmetric, CellKind::tri6, Kinematics::small},
                                         {Space::solid, CellKind::hex8, Kinematics::small},
                                         {Space::solid, CellKind::hex8, Kinematics::finite},
                                         {Space::solid, CellKind::tet4, Kinematics::finite},
                                         {Space::solid, CellKind::tet10, Kinematics::finite},
                                         {Space::solid, CellKind::hex20, Kinematics::small},
                                         {Space::solid, CellKind::hex20, Kinematics::finite}};

std::string tangent_name(const testing::TestParamInfo<TangentCase>& info) {
  constexpr const char* names[] = {"strain", "stress", "axis", "solid"};
  const TangentCase& c = info.param;
  return std::string(names[static_cast<int>(c.space)]) + "_" + name_of_kind(c.kind) + name_of(c.kinematics);
}
INSTANTIATE_TEST_SUITE_P(Spaces, Tangent, testing::ValuesIn(tangent_cases), tangent_name);

// ---- around an axis

class AroundAnAxis : public testing::TestWithParam<CellKind> {
protected:
  static constexpr double inner = 0.5;
  std::unique_ptr<FemDiscretisation> tube() const {
    return ready(Space::axisymmetric, distorted(GetParam(), 3, 0.05, Vec3(inner, 0.0, 0.0)), elastic());
  }
};

TEST_P(AroundAnAxis, VolumeAndWeightAreThoseOfTheTube) {
  const auto fem = tube();
  double volume = 0.0;
  for (double v : fem->material.volume) volume += v;
  const double expected = std::numbers::pi * (1.5 * 1.5 - 0.5 * 0.5);
  // One point in a straight triangle integrates a linear radius; the other rules do better.
  EXPECT_NEAR(volume, expected, 1e-12 * expected);
  NodalVector f(fem->n_nodes(), Vec3::Zero());
  fem->add_body_force([](int, const Vec3&) { return Vec3(0.0, -9.81, 0.0); }, f);
  EXPECT_NEAR(sum_of(f).y(), -9.81 * density * expected, 1e-9 * density);
}

TEST_P(AroundAnAxis, UniformExpansionStressesRadiusAndHoopAlike) {
  const auto fem = tube();
  const double a = 1e-3;
  for (const Kinematics kinematics : {Kinematics::small, Kinematics::finite}) {
    const NodalVector f = internal_force(*fem, at_nodes(*fem, [&](const Vec3& X) { return Vec3(a * X.x(), 0.0, 0.0); }),
                                         settings(Space::axisymmetric, kinematics));
    const double e = kinematics == Kinematics::small ? a : std::log1p(a);
    const double lambda = E * nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), mu = 0.5 * E / (1.0 + nu);
    for (const PointResponse& r : fem->material.trial) {
      EXPECT_NEAR(r.stress[XX], 2.0 * (lambda + mu) * e, 1e-9 * E * e);
      EXPECT_NEAR(r.stress[ZZ], 2.0 * (lambda + mu) * e, 1e-9 * E * e);
      EXPECT_NEAR(r.stress[YY], 2.0 * lambda * e, 1e-9 * E * e);
      EXPECT_NEAR(r.stress[XY], 0.0, 1e-9 * E * e);
    }
    // Equal radial and hoop stress are in equilibrium: the forces integrate d(R N)/dR, which the rules do exactly.
    const double scale = largest(f);
    double inside = 0.0;
    for (int i = 0; i < fem->n_nodes(); ++i)
      if (!on_surface(fem->nodes[i], 2, Vec3(inner, 0.0, 0.0))) inside = std::max(inside, f[i].norm());
    EXPECT_LT(inside, 1e-11 * scale);
    EXPECT_NEAR(sum_of(f).y(), 0.0, 1e-11 * scale);
  }
}

TEST_P(AroundAnAxis, MotionAlongTheAxisCostsNothingAndAcrossItDoes) {
  const auto fem = tube();
  const LawSettings s = settings(Space::axisymmetric, Kinematics::finite);
  const double along =
      largest(internal_force(*fem, at_nodes(*fem, [](const Vec3&) { return Vec3(0.0, 0.01, 0.0); }), s));
  const double across =
      largest(internal_force(*fem, at_nodes(*fem, [](const Vec3&) { return Vec3(0.01, 0.0, 0.0); }), s));
  EXPECT_LT(along, 1e-11 * across);
}

std::string axis_name(const testing::TestParamInfo<CellKind>& info) { return name_of_kind(info.param); }
INSTANTIATE_TEST_SUITE_P(Kinds, AroundAnAxis,
                         testing::Values(CellKind::tri3, CellKind::quad4, CellKind::tri6, CellKind::quad8), axis_name);

TEST(Fem, RefusesAMeshAcrossTheAxis) {
  FemDiscretisation fem(Space::axisymmetric);
  EXPECT_THROW(fem.add_body(0, "disc", elastic(), unit_mesh(CellKind::quad4, 2, Vec3(-0.5, 0.0, 0.0)), 1.0),
               InputError);
}

// ---- bodies, points, anchors, rows

TEST(Fem, NumbersPointsBodyByBody) {
  FemDiscretisation fem(Space::solid);
  const Mesh hexes = unit_mesh(CellKind::hex8, 2), tets = unit_mesh(CellKind::tet10, 1, Vec3(2.0, 0.0, 0.0));
  fem.add_body(3, "hexes", elastic(), hexes, 1.0);
  fem.add_body(1, "tets", damaged(), tets, 1.0);
  EXPECT_EQ(fem.points_of_body(3), 64);
  EXPECT_EQ(fem.points_of_body(1), 24);
  EXPECT_NEAR(fem.cell_size(), std::cbrt(2.0 / 14.0), 1e-12);
  fem.move_points(1.2);
  fem.begin_step({});
  EXPECT_EQ(fem.connectivity, 1);
  fem.move_points(1.2);
  fem.begin_step({});
  EXPECT_EQ(fem.connectivity, 1);
  ASSERT_EQ(fem.material.size(), 88);
  for (int p = 0; p < 88; ++p) EXPECT_EQ(fem.point_ids()[p], p);
  EXPECT_EQ(fem.material.slices[1].begin, 64);
  EXPECT_EQ(fem.material.slices[1].body, 1);
  ASSERT_EQ(fem.elements().size(), 14u);
  EXPECT_EQ(fem.first_point()[9], 68);
  EXPECT_EQ(fem.body_of_element(7), 3);
  EXPECT_EQ(fem.body_of_element(8), 1);
  EXPECT_EQ(fem.n_nodes(), hexes.n_nodes() + tets.n_nodes());
  double mass = 0.0;
  NodalVector f(fem.n_nodes(), Vec3::Zero());
  fem.add_body_force([](int, const Vec3&) { return Vec3(Vec3::UnitZ()); }, f);
  for (const Vec3& v : f) mass += v.z();
  EXPECT_NEAR(mass, 2.0 * density, 1e-9);
}

TEST(Fem, SaysWhatIsWrongWithAMesh) {
  Mesh mesh = unit_mesh(CellKind::hex8, 1);
  std::swap(mesh.connectivity[0], mesh.connectivity[6]);
  FemDiscretisation fem(Space::solid);
  try {
    fem.add_body(0, "block", elastic(), mesh, 1.0);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("body \"block\": element 0 of its mesh is turned inside out"),
              std::string::npos);
  }
  FemDiscretisation brittle(Space::solid);
  Material material = damaged();
  std::get<SimoJu>(material.law).fracture_energy = 1.0;
  EXPECT_THROW(brittle.add_body(0, "block", material, unit_mesh(CellKind::hex8, 1), 1.0), InputError);
  FemDiscretisation plane(Space::plane_strain);
  EXPECT_THROW(plane.add_body(0, "block", elastic(), unit_mesh(CellKind::hex8, 1), 1.0), InputError);
}

TEST(Fem, AnchorsMoveWithTheMaterial) {
  const Field field = [](const Vec3& X) {
    return Vec3(0.01 * X.x() * X.x() + 0.02 * X.y() * X.z(), -0.01 * X.y() * X.x(), 0.03 * X.z() * X.z());
  };
  for (const CellKind kind : {CellKind::tet10, CellKind::hex20}) {
    Anchor inside, corner, outside;
    inside.X = Vec3(0.31, 0.42, 0.77);
    corner.X = Vec3(1.0, 1.0, 1.0);
    outside.X = Vec3(1.01, 0.3, 0.6);  // no element holds it; the nearest one serves
    for (Anchor* a : {&inside, &corner, &outside}) a->x = a->X;
    outside.inward = -Vec3::UnitX();
    const std::vector<Anchor*> anchors = {&inside, &corner, &outside};
    const auto fem = ready(Space::solid, unit_mesh(kind, 3), elastic(), anchors);
    const NodalVector du = at_nodes(*fem, field);
    ASSERT_EQ(fem->evaluate(du, settings(Space::solid, Kinematics::finite)), Status::ok);
    fem->commit(du, anchors);
    for (const Anchor* a : anchors) {
      EXPECT_LT((a->u - field(a->X)).norm(), 1e-12);
      EXPECT_LT((a->x - a->X - a->u).norm(), 1e-14);
      EXPECT_EQ(fem->elements()[a->block], a->cell);
    }
    for (int p = 0; p < fem->material.size(); ++p) {
      const Vec3 X = fem->point_origins()[p];
      EXPECT_LT((fem->point_displacements()[p] - field(X)).norm(), 1e-12);
      EXPECT_LT((fem->point_positions()[p] - X - field(X)).norm(), 1e-12);
    }
    Anchor far;
    far.X = Vec3(3.0, 0.5, 0.5);
    EXPECT_THROW(fem->locate(far), RunError);
  }
}

/// A quarter ring with curved sides: the corner cells do not reach its outer side, and overlap its inner one.
TEST(Fem, FindsElementsWithCurvedSides) {
  Mesh mesh = unit_mesh(CellKind::hex20, 2);
  const auto bend = [](const Vec3& x) {
    const double r = 1.0 + x.x(), angle = 0.5 * std::numbers::pi * x.y();
    return Vec3(r * std::cos(angle), r * std::sin(angle), x.z());
  };
  for (Vec3& x : mesh.nodes) x = bend(x);
  std::vector<Anchor> surface;
  for (const double r : {0.0, 1.0})
    for (int i = 0; i < 40; ++i)
      for (const double z : {0.05, 0.5, 0.93}) {
        Anchor a;
        const Vec3 local(r, (i + 0.5) / 40.0, z);
        a.X = a.x = bend(local);
        a.inward = Vec3(a.X.x(), a.X.y(), 0.0).normalized() * (r > 0.5 ? -1.0 : 1.0);
        surface.push_back(a);
      }
  std::vector<Anchor*> anchors;
  for (Anchor& a : surface) anchors.push_back(&a);
  const auto fem = ready(Space::solid, mesh, elastic(), anchors);
  for (const Anchor* a : anchors) EXPECT_LT((a->stencil->interpolate(fem->nodes) - a->X).norm(), 1e-10);
  Anchor outside;  // and nothing says where inside is
  outside.X = 1.02 * surface.back().X;
  outside.X.z() = 0.6;
  fem->locate(outside);
  EXPECT_EQ(outside.cell, 7);
}

TEST(Fem, RowsCarryTheState) {
  for (const Space space : {Space::axisymmetric, Space::solid}) {
    const CellKind kind = space == Space::solid ? CellKind::hex8 : CellKind::quad8;
    const Mesh first_mesh = distorted(kind, 2, 0.05),
               second_mesh = unit_mesh(linear_kind(kind), 1, Vec3(2.0, 0.0, 0.0));
    const auto make = [&] {
      auto fem = std::make_unique<FemDiscretisation>(space);
      fem->add_body(0, "first", damaged(), first_mesh, 1.0);
      fem->add_body(1, "second", elastic(), second_mesh, 1.0);
      return fem;
    };
    const LawSettings s = settings(space, Kinematics::finite);
    const auto pull = [&](double size) {
      return [=](const Vec3& X) { return Vec3(size * X.x() * X.x(), size * X.x(), 0.0); };
    };
    const auto fem = make();
    fem->move_points(1.2);
    fem->begin_step({});
    const NodalVector du = at_nodes(*fem, pull(4e-4));
    ASSERT_EQ(fem->evaluate(du, s), Status::ok);
    fem->commit(du, {});
    ASSERT_GT(fem->material.max_damage(), 0.05);

    // Points in any order.
    std::vector<std::vector<double>> rows;
    for (int slice : {0, 1}) {
      const int width = fem->row_width(slice);
      const std::vector<double> in_order = fem->point_rows(slice);
      EXPECT_EQ(in_order.size() % width, 0u);
      rows.emplace_back();
      for (int p = static_cast<int>(in_order.size()) / width - 1; p >= 0; --p)
        rows.back().insert(rows.back().end(), in_order.begin() + p * width, in_order.begin() + (p + 1) * width);
    }
    const auto other = make();
    other->restore_points(rows);
    other->restore_nodes(fem->halo.ids, fem->node_state());
    other->move_points(1.2);
    other->begin_step({});
    EXPECT_EQ(other->material.stored_energy(), fem->material.stored_energy());
    EXPECT_EQ(other->material.dissipated_energy(), fem->material.dissipated_energy());
    const NodalVector more = at_nodes(*fem, pull(1e-4));
    const NodalVector f = internal_force(*fem, more, s), g = internal_force(*other, more, s);
    for (std::size_t i = 0; i < f.size(); ++i) EXPECT_EQ((f[i] - g[i]).norm(), 0.0);

    rows[0].resize(rows[0].size() - fem->row_width(0));
    EXPECT_THROW(make()->restore_points(rows), InputError);
    std::vector<double> short_state = fem->node_state();
    std::vector<std::int64_t> short_ids(fem->halo.ids.begin(), fem->halo.ids.end() - 1);
    short_state.resize(short_state.size() - Discretisation::node_width);
    EXPECT_THROW(make()->restore_nodes(short_ids, short_state), InputError);
  }
}

}  // namespace
}  // namespace berm
