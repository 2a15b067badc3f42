/// B-splines and linear functions on background grids.   [docs/theory/formulation.md, section 16]

#include <gtest/gtest.h>

#include <Eigen/Geometry>
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

/// Bardenhagen and Kober (2004): the mean of a hat function of width h over x - l ... x + l, by the distance.
double gimp_hat(double x, double l, double h) {
  x = std::abs(x);
  if (x < l) return 1.0 - (x * x + l * l) / (2.0 * h * l);
  if (x <= h - l) return 1.0 - x / h;
  return x < h + l ? (h + l - x) * (h + l - x) / (4.0 * h * l) : 0.0;
}

TEST(GridBasis, MeansOfLinearFunctionsAreThoseOfGimp) {
  const Grid grid = grid_of(2);
  const GridBasis basis(grid, 1);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  BasisAt out;
  for (int trial = 0; trial < 1000; ++trial) {
    const Vec3 edges(0.1 * unit(random), 0.2 * unit(random), 0.0);
    const Vec3 x(-0.15 + 0.2 * unit(random), 0.4 + 0.4 * unit(random), 0.0);
    basis.average_box(x, edges, out);
    for (int k = 0; k < out.n; ++k) {
      ASSERT_GE(out.nodes[k], 0);
      const Vec3 to = x - basis.places()[out.nodes[k]];
      EXPECT_NEAR(out.N[k], gimp_hat(to.x(), 0.5 * edges.x(), 0.1) * gimp_hat(to.y(), 0.5 * edges.y(), 0.2), 1e-12);
    }
  }
}

TEST(GridBasis, MeansKeepLinearFieldsAndTheirGradientsAreDerivatives) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for_all([&](const GridBasis& basis, const Grid& grid) {
    if (basis.degree() == 3) return;
    const int d = grid.dimension();
    const Mat3 turn = Eigen::AngleAxisd(grid.structure->angle, Vec3::UnitZ()).toRotationMatrix();
    BasisAt at, ahead, behind;
    for (int trial = 0; trial < 200; ++trial) {
      Vec3 edges(0.1, 0.2, 0.15), y(0.5, 0.8, 0.45);
      for (int i = 0; i < 3; ++i) {
        edges[i] *= 0.05 + 0.9 * unit(random);
        y[i] = 0.5 * edges[i] + 0.01 * edges[i] + (y[i] - 1.02 * edges[i]) * unit(random);
      }
      if (d == 2) y.z() = edges.z() = 0.0;
      const Vec3 x = turn * (y + grid.structure->origin);
      const Cover cover = basis.average_box(x, edges, at);
      const int cell = cover.cell[0];
      EXPECT_EQ(cell, grid.locator->locate(turn * (y - 0.5 * edges + grid.structure->origin), -1));
      double sum = 0.0;
      Vec3 place = Vec3::Zero();
      Mat3 gradient = Mat3::Zero();
      for (int k = 0; k < at.n; ++k) {
        if (at.nodes[k] < 0) {
          EXPECT_EQ(at.N[k], 0.0);
          EXPECT_TRUE(at.grad[k].isZero(0.0));
          continue;
        }
        sum += at.N[k];
        place += at.N[k] * basis.places()[at.nodes[k]];
        gradient += basis.places()[at.nodes[k]] * at.grad[k].transpose();
      }
      EXPECT_NEAR(sum, 1.0, 1e-12);
      EXPECT_LT((place - x).head(d).norm(), 1e-12);
      EXPECT_LT((gradient - Mat3::Identity()).topLeftCorner(d, d).norm(), 1e-10);
      for (int i = 0; i < d; ++i) {
        constexpr double h = 1e-6;
        if (basis.average_box(x + h * Vec3::Unit(i), edges, ahead).cell[0] != cell ||
            basis.average_box(x - h * Vec3::Unit(i), edges, behind).cell[0] != cell)
          continue;
        for (int k = 0; k < at.n; ++k)
          EXPECT_NEAR(at.grad[k][i], (ahead.N[k] - behind.N[k]) / (2.0 * h), 1e-3);  // kinks: order h
      }
    }
  });
}

/// What reaches out of the grid is cut off: the nodes on the edge alone decide about values there.
TEST(GridBasis, MeansCutBoxesAtTheEdge) {
  for (const int degree : {1, 2}) {
    const Grid grid = grid_of(2);
    const GridBasis basis(grid, degree);
    BasisAt at;
    EXPECT_EQ(basis.average_box(Vec3(-0.3, 0.2, 0.0), Vec3(0.1, 0.2, 0.0), at).cell[0], 0);
    Vec3 place = Vec3::Zero();
    for (int k = 0; k < at.n; ++k)
      if (at.nodes[k] >= 0) place += at.N[k] * basis.places()[at.nodes[k]];
    EXPECT_LT((place - Vec3(-0.275, 0.25, 0.0)).norm(), 1e-12);
    EXPECT_EQ(basis.average_box(Vec3(0.2, 1.0, 0.0), Vec3(0.1, 0.2, 0.0), at).cell[0], 19);
  }
}

}  // namespace
}  // namespace berm
