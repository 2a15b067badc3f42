#include "fem/element.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "fem/geometry.hpp"
#include "meshes.hpp"

namespace berm {
namespace {

class EveryKind : public testing::TestWithParam<CellKind> {
protected:
  CellKind kind() const { return GetParam(); }
  int dimension() const { return dimension_of(kind()); }

  /// Places inside of the reference cell.
  std::vector<Vec3> places() const {
    std::vector<Vec3> out = {{0.2, 0.3, 0.1}, {0.1, 0.1, 0.6}, {0.4, 0.25, 0.05}, {0.05, 0.7, 0.2}};
    if (!is_simplex(kind())) out.insert(out.end(), {{-0.7, 0.4, -0.2}, {0.9, -0.8, 0.5}, {-0.3, -0.6, 0.95}});
    if (dimension() == 2)
      for (Vec3& x : out) x.z() = 0.0;
    return out;
  }

  /// Local coordinates of the nodes: corners as in quadrature.hpp, mid-sides between them.
  std::vector<Vec3> nodes() const {
    std::vector<Vec3> out;
    if (is_simplex(kind())) {
      out = {Vec3::Zero(), Vec3::UnitX(), Vec3::UnitY()};
      if (dimension() == 3) out.push_back(Vec3::UnitZ());
    } else {
      for (int layer = 0; layer < dimension() - 1; ++layer) {
        const double z = dimension() == 2 ? 0.0 : 2.0 * layer - 1.0;
        out.insert(out.end(), {{-1.0, -1.0, z}, {1.0, -1.0, z}, {1.0, 1.0, z}, {-1.0, 1.0, z}});
      }
    }
    if (nodes_of(kind()) > corners_of(kind()))
      for (const auto& [a, b] : edge_ends(kind())) out.push_back(0.5 * (out[a] + out[b]));
    return out;
  }
};

TEST_P(EveryKind, IsOneAtItsNodeAndZeroAtTheOthers) {
  const std::vector<Vec3> at = nodes();
  ASSERT_EQ(static_cast<int>(at.size()), nodes_of(kind()));
  for (std::size_t i = 0; i < at.size(); ++i) {
    const fem::ElementShape s = fem::element_shape(kind(), at[i]);
    ASSERT_EQ(s.n, nodes_of(kind()));
    for (int k = 0; k < s.n; ++k) EXPECT_NEAR(s.N[k], k == static_cast<int>(i) ? 1.0 : 0.0, 1e-14);
  }
}

TEST_P(EveryKind, SumsToOneAndDerivativesToZero) {
  for (const Vec3& xi : places()) {
    const fem::ElementShape s = fem::element_shape(kind(), xi);
    double sum = 0.0;
    Vec3 derivative = Vec3::Zero();
    for (int k = 0; k < s.n; ++k) {
      sum += s.N[k];
      derivative += s.dN[k];
    }
    EXPECT_NEAR(sum, 1.0, 1e-14);
    EXPECT_LT(derivative.norm(), 1e-13);
  }
}

TEST_P(EveryKind, DerivativesAreThoseOfTheFunctions) {
  const double h = 1e-6;
  for (const Vec3& xi : places()) {
    const fem::ElementShape s = fem::element_shape(kind(), xi);
    for (int i = 0; i < dimension(); ++i) {
      const fem::ElementShape up = fem::element_shape(kind(), xi + h * Vec3::Unit(i));
      const fem::ElementShape down = fem::element_shape(kind(), xi - h * Vec3::Unit(i));
      for (int k = 0; k < s.n; ++k) EXPECT_NEAR(s.dN[k][i], (up.N[k] - down.N[k]) / (2.0 * h), 1e-9);
    }
    if (dimension() == 2) {
      for (int k = 0; k < s.n; ++k) EXPECT_EQ(s.dN[k].z(), 0.0);
    }
  }
}

/// Linear fields, quadratic ones with mid-sides.
TEST_P(EveryKind, InterpolatesPolynomialsExactly) {
  const bool squares = nodes_of(kind()) > corners_of(kind());
  const auto field = [&](const Vec3& x) {
    const double linear = 1.5 + 2.0 * x.x() - 3.0 * x.y() + 0.5 * x.z();
    return squares ? linear + x.x() * x.x() - 2.0 * x.y() * x.y() + 3.0 * x.z() * x.z() + x.x() * x.y() -
                         4.0 * x.y() * x.z() + 2.5 * x.x() * x.z()
                   : linear;
  };
  const std::vector<Vec3> at = nodes();
  for (const Vec3& xi : places()) {
    const fem::ElementShape s = fem::element_shape(kind(), xi);
    double value = 0.0;
    for (int k = 0; k < s.n; ++k) value += s.N[k] * field(at[k]);
    EXPECT_NEAR(value, field(xi), 1e-13);
  }
}

TEST_P(EveryKind, RuleHasTheMeasureOfTheCell) {
  constexpr int points[8] = {1, 4, 3, 4, 1, 8, 4, 8};
  constexpr double measure[8] = {0.5, 4.0, 0.5, 4.0, 1.0 / 6.0, 8.0, 1.0 / 6.0, 8.0};
  const int k = static_cast<int>(kind());
  const auto& rule = fem::element_rule(kind());
  EXPECT_EQ(static_cast<int>(rule.size()), points[k]);
  double sum = 0.0;
  for (const fem::RulePoint& q : rule) sum += q.weight;
  EXPECT_NEAR(sum, measure[k], 1e-14);
}

TEST_P(EveryKind, LocalCoordinatesInvertTheMap) {
  Mesh mesh = distorted(kind(), 2, 0.05);
  for (Vec3& x : mesh.nodes) x += 0.05 * Vec3(x.y() * x.y(), x.x() * x.x(), 0.0);  // curved sides
  for (int c = 0; c < mesh.n_cells(); ++c)
    for (const Vec3& xi : places()) {
      const Vec3 x = fem::place(mesh, c, fem::element_shape(kind(), xi));
      Vec3 found;
      ASSERT_TRUE(fem::local_coordinates(mesh, c, x, found));
      EXPECT_LT((found - xi).norm(), 1e-12);
      EXPECT_EQ(fem::distance_outside(mesh, c, x), 0.0);
    }
  EXPECT_GT(fem::distance_outside(mesh, 0, Vec3(-0.4, 0.2, 0.0)), 0.1);
}

std::string name_of(const testing::TestParamInfo<CellKind>& info) {
  constexpr const char* names[] = {"tri3", "quad4", "tri6", "quad8", "tet4", "hex8", "tet10", "hex20"};
  return names[static_cast<int>(info.param)];
}
INSTANTIATE_TEST_SUITE_P(Elements, EveryKind, testing::ValuesIn(all_kinds), name_of);

}  // namespace
}  // namespace berm
