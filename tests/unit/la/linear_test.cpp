#include <gtest/gtest.h>

#include <cmath>

#include "la/newton.hpp"
#include "method/csr.hpp"

namespace berm {
namespace {

constexpr int n = 9;  // nodes an edge of a cube; three unknowns a node

int node(int i, int j, int k) { return (k * n + j) * n + i; }

/// Springs between neighbouring nodes in all three directions, one face held by springs: symmetric, positive definite.
/// Those above the middle have `soft` times the stiffness; unsymmetric: a part that turns the forces by a few degrees.
class SpringCube {
public:
  explicit SpringCube(bool symmetric) : symmetric_(symmetric) {
    start_petsc("");
    Blocks blocks;
    for (int k = 0; k < n; ++k)
      for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
          layout_.places.emplace_back(i, j, k);
          const int a = node(i, j, k);
          if (i + 1 < n) add(blocks, a, node(i + 1, j, k));
          if (j + 1 < n) add(blocks, a, node(i, j + 1, k));
          if (k + 1 < n) add(blocks, a, node(i, j, k + 1));
        }
    assembler_.build(blocks, n * n * n, 3);
    layout_.dimension = 3;
    layout_.n_mine = 3 * n * n * n;
    layout_.n_global = layout_.n_mine;
    for (int u = 0; u < layout_.n_mine; ++u) layout_.global.push_back(u);
    free_.assign(layout_.n_mine, 0);
    fill(1.0);
  }

  void fill(double soft) {
    assembler_.zero(free_, n * n * n, 1.0);
    for (std::size_t b = 0; b < pairs_.size(); ++b) {
      const auto [lower, upper] = pairs_[b];
      const double stiffness = layout_.places[lower].z() > n / 2 ? soft : 1.0;
      double dense[6][6] = {};
      for (int i = 0; i < 3; ++i) {
        dense[i][i] = dense[3 + i][3 + i] = stiffness;
        dense[i][3 + i] = dense[3 + i][i] = -stiffness;
        if (!symmetric_) dense[i][3 + (i + 1) % 3] = 0.1 * stiffness;
        if (layout_.places[lower].z() == 0.0) dense[i][i] += stiffness;
      }
      assembler_.add(static_cast<int>(b), &dense[0][0]);
    }
  }

  NewtonSolver& hand_to(NewtonSolver& solver) {
    solver.set_matrix(assembler_.matrix(), layout_, symmetric_);
    return solver;
  }

  /// |A x - b| / |b|
  double residual(const std::vector<double>& x, const std::vector<double>& b) {
    const CsrMatrix& A = assembler_.matrix();
    double difference = 0.0, size = 0.0;
    for (int r = 0; r < A.n; ++r) {
      double sum = -b[r];
      for (int k = A.row_begin[r]; k < A.row_begin[r + 1]; ++k) sum += A.value[k] * x[A.column[k]];
      difference += sum * sum;
      size += b[r] * b[r];
    }
    return std::sqrt(difference / size);
  }

  std::vector<double> load() const {
    std::vector<double> b(layout_.n_mine);
    for (std::size_t u = 0; u < b.size(); ++u) b[u] = std::sin(0.1 * static_cast<double>(u));
    return b;
  }

private:
  void add(Blocks& blocks, int a, int b) {
    const int pair[2] = {a, b};
    blocks.add(pair);
    pairs_.emplace_back(a, b);
  }

  bool symmetric_;
  std::vector<std::pair<int, int>> pairs_;
  std::vector<char> free_;
  SystemLayout layout_;
  BlockAssembler assembler_;
};

Solver iterative() {
  Solver options;
  options.linear = Solver::Linear::iterative;
  options.linear_tolerance = 1e-9;
  return options;
}

class KeptMultigrid : public ::testing::TestWithParam<bool> {};

/// Multigrid of an earlier matrix may cost iterations, never accuracy.
TEST_P(KeptMultigrid, SolveEverySystem) {
  SpringCube cube(GetParam());
  const Solver options = iterative();
  NewtonSolver solver(options, Comm::world());
  cube.hand_to(solver);
  const std::vector<double> b = cube.load();
  for (double soft = 1.0; soft > 1e-4; soft *= 0.5) {
    cube.fill(soft);
    std::vector<double> x(b.size());
    ASSERT_TRUE(solver.solve_linear(b, x));
    EXPECT_LT(cube.residual(x, b), 2e-9) << soft;
  }
  EXPECT_EQ(solver.count().fallbacks, 0);
}

/// When the matrix has become another one, what keeping multigrid costs is bounded: 30 iterations, and those of the
/// system at which that is noticed.
TEST_P(KeptMultigrid, AreMadeAnewWhenTheyNoLongerServe) {
  SpringCube cube(GetParam());
  const Solver options = iterative();
  const std::vector<double> b = cube.load();
  std::vector<double> x(b.size());

  NewtonSolver kept(options, Comm::world());
  cube.hand_to(kept);
  ASSERT_TRUE(kept.solve_linear(b, x));
  const long first = kept.count().iterations;
  cube.fill(1e-6);
  ASSERT_TRUE(kept.solve_linear(b, x));
  const long stale = kept.count().iterations - first;

  NewtonSolver fresh(options, Comm::world());
  cube.hand_to(fresh);
  ASSERT_TRUE(fresh.solve_linear(b, x));
  const long needed = fresh.count().iterations;
  ASSERT_GT(stale, needed) << "the change is too small to be noticed";

  constexpr int more = 60;
  for (int k = 0; k < more; ++k) ASSERT_TRUE(kept.solve_linear(b, x));
  EXPECT_LE(kept.count().iterations, first + (more + 1) * needed + 30 + stale + first);
  const long before = kept.count().iterations;
  ASSERT_TRUE(kept.solve_linear(b, x));
  EXPECT_EQ(kept.count().iterations - before, needed);
}

INSTANTIATE_TEST_SUITE_P(Symmetry, KeptMultigrid, ::testing::Bool(),
                         [](const auto& one) { return one.param ? "symmetric" : "unsymmetric"; });

}  // namespace
}  // namespace berm
