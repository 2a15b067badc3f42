/// B-splines and linear functions on background grids.   [docs/theory/formulation.md, section 16]

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "base/error.hpp"
#include "shape/grid_basis.hpp"

namespace berm {
namespace {

Grid grid_of(int dimension, double angle = 0.0, GridKind kind = GridKind::quads) {
  StructuredGrid s;
  s.kind = dimension == 3 ? GridKind::hexahedra : kind;
  s.origin = Vec3(-0.3, 0.2, dimension == 3 ? 0.1 : 0.0);
  s.cell_size = Vec3(0.1, 0.2, dimension == 3 ? 0.15 : 0.0);
  s.nx = 5, s.ny = 4, s.nz = dimension == 3 ? 3 : 0;
  s.angle = angle;
  return make_structured_grid(s);
}

/// Calls work(basis, grid) for all degrees, in the plane, turned, and in space.
template <class Work>
void for_all(Work work) {
  for (int degree : {1, 2, 3})
    for (const auto& [dimension, angle] : {std::pair{2, 0.0}, std::pair{2, 0.3}, std::pair{3, 0.0}, std::pair{3, 0.3}}) {
      SCOPED_TRACE(testing::Message() << "degree " << degree << ", dimension " << dimension << ", angle " << angle);
      const Grid grid = grid_of(dimension, angle);
      work(GridBasis(grid, degree), grid);
    }
}

/// A place in a cell, in units of it.
Vec3 place_in(const Grid& grid, int cell, const Vec3& at) {
  const Mesh& mesh = grid.mesh;
  const auto list = mesh.nodes_of_cell(cell);
  const Vec3& o = mesh.nodes[list[0]];
  Vec3 x = o + at.x() * (mesh.nodes[list[1]] - o) + at.y() * (mesh.nodes[list[3]] - o);
  if (grid.dimension() == 3) x += at.z() * (mesh.nodes[list[4]] - o);
  return x;
}

TEST(GridBasis, ReproducesLinearFields) {
  std::mt19937 generator(3);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  for_all([&](const GridBasis& basis, const Grid& grid) {
    BasisAt at;
    for (int cell = 0; cell < grid.mesh.n_cells(); ++cell) {
      const Vec3 x = place_in(grid, cell, Vec3(uniform(generator), uniform(generator), uniform(generator)));
      ASSERT_TRUE(basis.evaluate(cell, x, at));
      ASSERT_EQ(at.n, static_cast<int>(basis.nodes_of(cell).size()));
      double one = 0.0;
      Vec3 place = Vec3::Zero(), zero = Vec3::Zero();
      Mat3 unit = Mat3::Zero();
      for (int k = 0; k < at.n; ++k) {
        EXPECT_EQ(at.nodes[k], basis.nodes_of(cell)[k]);
        EXPECT_GE(at.N[k], -1e-15);
        one += at.N[k];
        place += at.N[k] * basis.places()[at.nodes[k]];
        zero += at.grad[k];
        unit += basis.places()[at.nodes[k]] * at.grad[k].transpose();
      }
      const int d = grid.dimension();
      EXPECT_NEAR(one, 1.0, 1e-13);
      EXPECT_LT((place - x).norm(), 1e-13);
      EXPECT_LT(zero.norm(), 1e-11);
      EXPECT_LT((unit - Mat3::Identity()).topLeftCorner(d, d).norm(), 1e-11);
    }
  });
}

TEST(GridBasis, GradientIsTheDerivative) {
  for_all([&](const GridBasis& basis, const Grid& grid) {
    const double eps = 1e-6;
    BasisAt at, plus, minus;
    for (int cell = 0; cell < grid.mesh.n_cells(); ++cell) {
      const Vec3 x = place_in(grid, cell, Vec3(0.3, 0.6, 0.8));
      basis.evaluate(cell, x, at);
      for (int i = 0; i < grid.dimension(); ++i) {
        basis.evaluate(cell, x + eps * Vec3::Unit(i), plus);
        basis.evaluate(cell, x - eps * Vec3::Unit(i), minus);
        for (int k = 0; k < at.n; ++k) EXPECT_NEAR(at.grad[k][i], (plus.N[k] - minus.N[k]) / (2.0 * eps), 1e-7);
      }
    }
  });
}

/// Values, and derivatives up to degree - 1, are the same from both sides of a face; the one of order degree jumps.
TEST(GridBasis, IsSmoothAcrossFaces) {
  for_all([&](const GridBasis& basis, const Grid& grid) {
    const Vec3 x = place_in(grid, 6, Vec3(1.0, 0.4, 0.7));
    const Vec3 normal = (place_in(grid, 6, Vec3(1.0, 0.0, 0.0)) - place_in(grid, 6, Vec3::Zero())).normalized();
    BasisAt a, b;
    const auto by_node = [&](const BasisAt& s, auto value) {
      std::vector<double> out(basis.n_nodes(), 0.0);
      for (int k = 0; k < s.n; ++k) out[s.nodes[k]] = value(k);
      return out;
    };
    const auto difference = [&](auto value) {
      const std::vector<double> left = by_node(a, [&](int k) { return value(a, k); });
      const std::vector<double> right = by_node(b, [&](int k) { return value(b, k); });
      double most = 0.0;
      for (std::size_t k = 0; k < left.size(); ++k) most = std::max(most, std::abs(left[k] - right[k]));
      return most;
    };
    basis.evaluate(6, x, a);
    basis.evaluate(7, x, b);
    EXPECT_LT(difference([](const BasisAt& s, int k) { return s.N[k]; }), 1e-12);
    if (basis.degree() > 1) {
      EXPECT_LT(difference([&](const BasisAt& s, int k) { return s.grad[k].norm(); }), 1e-10);
    }
    basis.highest_derivative(6, x, normal, a);
    basis.highest_derivative(7, x, normal, b);
    EXPECT_GT(difference([](const BasisAt& s, int k) { return s.N[k]; }), 1.0);
  });
}

/// The derivative of order degree by differences of gradients.
TEST(GridBasis, HighestDerivative) {
  for_all([&](const GridBasis& basis, const Grid& grid) {
    const Vec3 x = place_in(grid, 7, Vec3(0.5, 0.5, 0.5));
    const Vec3 normal = (place_in(grid, 7, Vec3(0.0, 1.0, 0.0)) - place_in(grid, 7, Vec3::Zero())).normalized();
    const double eps = 0.02;  // exact for polynomials
    BasisAt highest, at[3];
    basis.highest_derivative(7, x, normal, highest);
    for (int i = 0; i < 3; ++i) basis.evaluate(7, x + (i - 1) * eps * normal, at[i]);
    for (int k = 0; k < highest.n; ++k) {
      const double before = at[0].grad[k].dot(normal), now = at[1].grad[k].dot(normal), after = at[2].grad[k].dot(normal);
      const double expected = basis.degree() == 1   ? now
                              : basis.degree() == 2 ? (after - before) / (2.0 * eps)
                                                    : (after - 2.0 * now + before) / (eps * eps);
      EXPECT_NEAR(highest.N[k], expected, 1e-8 * std::max(1.0, std::abs(expected)));
    }
  });
}

/// On an edge of the grid only the functions of its own nodes are not zero: supports are exact there.
TEST(GridBasis, EdgesBelongToTheirNodes) {
  for_all([&](const GridBasis& basis, const Grid& grid) {
    BasisAt at;
    basis.evaluate(0, place_in(grid, 0, Vec3(0.37, 0.0, 0.6)), at);
    const Vec3 corner = place_in(grid, 0, Vec3::Zero()), up = place_in(grid, 0, Vec3(0.0, 1.0, 0.0)) - corner;
    for (int k = 0; k < at.n; ++k) {
      const double height = (basis.places()[at.nodes[k]] - corner).dot(up);
      if (height > 1e-12) {
        EXPECT_NEAR(at.N[k], 0.0, 1e-14);
      }
    }
  });
}

TEST(GridBasis, SplinesNeedBoxes) {
  const Grid triangles = grid_of(2, 0.0, GridKind::union_jack);
  EXPECT_THROW(GridBasis(triangles, 2), InputError);
  EXPECT_NO_THROW(GridBasis(triangles, 1));
}

}  // namespace
}  // namespace berm
