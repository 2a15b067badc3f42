#include "sim/recovery.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace berm {
namespace {

/// n cells an edge of the unit square or cube, two Gauss points a direction.
struct Lattice {
  int n, dimension;
  std::vector<PatchCell> cells;
  std::vector<Vec3> x;
  std::vector<double> volume;

  Lattice(int n_, int dimension_) : n(n_), dimension(dimension_) {
    const int deep = dimension == 3 ? n : 1, above = dimension == 3 ? 2 : 1;
    const double gauss[] = {0.5 - 0.5 / std::sqrt(3.0), 0.5 + 0.5 / std::sqrt(3.0)};
    for (int k = 0; k < deep; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          PatchCell& cell = cells.emplace_back();
          for (int c = 0; c < above; ++c)
            for (int b = 0; b < 2; ++b)
              for (int a = 0; a < 2; ++a) {
                cell.nodes.push_back(number(i + a, j + b, k + c));
                cell.points.push_back(static_cast<int>(x.size()));
                x.emplace_back((i + gauss[a]) / n, (j + gauss[b]) / n, dimension == 3 ? (k + gauss[c]) / n : 0.0);
                volume.push_back(std::pow(0.5 / n, dimension));
              }
        }
  }

  long number(int i, int j, int k) const { return i + long{n + 1} * (j + long{n + 1} * k); }
  Vec3 place(long node) const { return Vec3(node % (n + 1), node / (n + 1) % (n + 1), node / ((n + 1) * (n + 1))) / n; }

  template <class Field>
  RecoveredStress recover(int degree, Field&& field) const {
    std::vector<Voigt> stress;
    for (const Vec3& at : x) stress.push_back(field(at));
    return recover_stress(Comm(), dimension, degree, 1.0 / n, cells, {x, volume, stress},
                          [&](long node) { return place(node); });
  }
};

Voigt linear(const Vec3& x) {
  Voigt s;
  s << 2.0 - 3.0 * x.x() + 0.7 * x.y() + 1.9 * x.z(), x.y(), x.z() - x.x(), 1.0, x.x() + x.y(), 0.0;
  return s;
}

Voigt quadratic(const Vec3& x) { return linear(x) + Voigt::Unit(0) * (x.x() * x.y() - 2.0 * x.y() * x.y() + x.z()); }

double largest_error(const Lattice& lattice, const RecoveredStress& r, Voigt (*field)(const Vec3&)) {
  double largest = 0.0;
  for (const auto& [node, s] : r.node) largest = std::max(largest, (s - field(lattice.place(node))).norm());
  return largest;
}

/// Up to the share by which slopes are held, which is largest in the corners.
TEST(Recovery, KeepsPolynomialsUpToItsDegree) {
  for (int dimension : {2, 3}) {
    const Lattice lattice(4, dimension);
    const RecoveredStress first = lattice.recover(1, linear);
    EXPECT_EQ(first.node.size(), std::size_t(std::pow(5, dimension) + 0.5));
    EXPECT_LT(largest_error(lattice, first, linear), 2e-3);
    EXPECT_LT(first.relative_error, 1e-3);
    EXPECT_LT(largest_error(lattice, lattice.recover(2, linear), linear), 0.02);
    const RecoveredStress second = lattice.recover(2, quadratic);
    EXPECT_LT(second.relative_error, 0.25 * lattice.recover(1, quadratic).relative_error);
  }
}

/// Inside of the body every patch is whole, and linear fields are kept exactly, since nothing holds the constant.
TEST(Recovery, IsExactInsideAndOfOrderTwoOnTheBoundary) {
  const auto wave = [](const Vec3& x) { return Voigt(Voigt::Ones() * std::sin(2.0 * x.x() + x.y())); };
  double before = 0.0;
  for (int n : {8, 16, 32}) {
    const Lattice lattice(n, 2);
    const RecoveredStress of_line = lattice.recover(1, linear);
    for (const auto& [node, s] : of_line.node) {
      const Vec3 x = lattice.place(node);
      if (x.x() > 0.0 && x.x() < 1.0 && x.y() > 0.0 && x.y() < 1.0) EXPECT_LT((s - linear(x)).norm(), 1e-12);
    }
    const RecoveredStress r = lattice.recover(1, wave);
    double largest = 0.0;
    for (const auto& [node, s] : r.node) largest = std::max(largest, (s - wave(lattice.place(node))).norm());
    if (before > 0.0) EXPECT_GT(std::log2(before / largest), 1.8) << n;
    before = largest;
  }
}

/// A stress that jumps from cell to cell by +- 1 about a linear field, as in a chessboard: that is its error.
TEST(Recovery, EstimatesTheErrorOfAStressThatJumps) {
  Lattice lattice(8, 2);
  const auto board = [](const Vec3& x) {
    const int cell = static_cast<int>(8 * x.x()) + static_cast<int>(8 * x.y());
    return Voigt(Voigt::Unit(0) * (10.0 + (cell % 2 ? 1.0 : -1.0)));
  };
  const RecoveredStress r = lattice.recover(1, board);
  EXPECT_NEAR(r.cell_error[3 * 8 + 3], 1.0, 1e-12);
  EXPECT_NEAR(r.relative_error, 0.1, 0.02);
}

/// A shear stress counts twice in the norm of the tensor.
TEST(Recovery, CountsShearTwice) {
  Lattice lattice(8, 2);
  const auto board = [](int component) {
    return [component](const Vec3& x) {
      const int cell = static_cast<int>(8 * x.x()) + static_cast<int>(8 * x.y());
      return Voigt(Voigt::Unit(component) * (cell % 2 ? 1.0 : -1.0));
    };
  };
  const double xx = lattice.recover(1, board(XX)).cell_error[27], xy = lattice.recover(1, board(XY)).cell_error[27];
  EXPECT_NEAR(xy / xx, std::sqrt(2.0), 1e-12);
}

/// A node that a single point tells about has the stress of that point, and so have those of an empty cell beside it.
TEST(Recovery, GetsAlongWithSinglePoints) {
  const std::vector<PatchCell> cells = {{{0, 1, 2, 3}, {0}}, {{1, 4, 2, 5}, {}}};
  const std::vector<Vec3> x = {Vec3(0.1, 0.2, 0.0)};
  const std::vector<double> volume = {1e-12};
  const std::vector<Voigt> stress = {linear(Vec3(0.3, 0.4, 0.0))};
  for (int degree : {1, 2}) {
    const RecoveredStress r = recover_stress(Comm(), 2, degree, 1.0, cells, {x, volume, stress},
                                             [](long node) { return Vec3(node % 2, node / 2, 0.0); });
    for (long node : {0, 1, 2, 3, 4, 5}) EXPECT_LT((r.node.at(node) - stress[0]).norm(), 1e-12);
    EXPECT_LT(r.relative_error, 1e-12);
    EXPECT_EQ(r.cell_error[1], 0.0);
  }
}

}  // namespace
}  // namespace berm
