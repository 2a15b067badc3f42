#include "method/csr.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <random>

namespace berm {
namespace {

using RowMajor = Eigen::Matrix<double, -1, -1, Eigen::RowMajor>;

/// All entries; columns of a row ascend.
Eigen::MatrixXd dense_of(const CsrMatrix& csr) {
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(csr.n, csr.n);
  EXPECT_EQ(csr.row_begin.size(), csr.n + 1u);
  EXPECT_EQ(csr.value.size(), csr.column.size());
  for (int row = 0; row < csr.n; ++row)
    for (int k = csr.row_begin[row]; k < csr.row_begin[row + 1]; ++k) {
      if (k > csr.row_begin[row]) {
        EXPECT_LT(csr.column[k - 1], csr.column[k]);
      }
      found(row, csr.column[k]) = csr.value[k];
    }
  return found;
}

/// Adds random blocks to the assembler, and the same by the definition to a dense matrix and a force.
struct Reference {
  Eigen::MatrixXd matrix;
  Eigen::VectorXd force;

  void add(const Blocks& blocks, int dimension, const std::vector<char>& fixed, const std::vector<double>& increment,
           BlockAssembler& assembler) {
    for (int b = 0; b < blocks.size(); ++b) {
      std::vector<int> dofs;
      for (int node : blocks[b])
        for (int c = 0; c < dimension; ++c) dofs.push_back(dimension * node + c);
      const int m = static_cast<int>(dofs.size());
      const RowMajor block = RowMajor::Random(m, m);
      assembler.add(b, block.data());
      for (int i = 0; i < m; ++i)
        for (int j = 0; j < m; ++j) {
          if (fixed[dofs[i]]) continue;
          if (!fixed[dofs[j]])
            matrix(dofs[i], dofs[j]) += block(i, j);
          else
            force[dofs[i]] += block(i, j) * increment[dofs[j]];
        }
    }
  }
};

/// Three blocks over five nodes, two unknowns prescribed; compared with assembly into a dense matrix.
TEST(BlockAssembler, AgreesWithDenseAssembly) {
  Blocks blocks;
  blocks.add(std::vector<int>{0, 1, 2});
  blocks.add(std::vector<int>{2, 1, 4, 3});
  blocks.add(std::vector<int>{0, 4});
  const int n = 10;
  std::vector<char> fixed(n, 0);
  fixed[3] = fixed[6] = 1;
  BlockAssembler assembler;
  assembler.build(blocks, 5, 2);
  std::vector<double> increment(n, 0.0);
  increment[3] = 0.7;
  increment[6] = -1.3;
  assembler.zero(fixed, 5, 1.0, &increment);

  Reference reference{Eigen::MatrixXd::Zero(n, n), Eigen::VectorXd::Zero(n)};
  reference.matrix(3, 3) = reference.matrix(6, 6) = 1.0;
  reference.add(blocks, 2, fixed, increment, assembler);
  EXPECT_LT((dense_of(assembler.matrix()) - reference.matrix).cwiseAbs().maxCoeff(), 1e-14);
  ASSERT_EQ(assembler.prescribed_force().size(), std::size_t(n));
  for (int row = 0; row < n; ++row) EXPECT_NEAR(assembler.prescribed_force()[row], reference.force[row], 1e-14);
}

/// Random blocks of 1 to 20 nodes with 1, 2 or 3 unknowns, nodes in any order, some in no block, some ghosts;
/// prescribed unknowns; with and without a border. The same assembler serves all of them, and every matrix twice.
TEST(BlockAssembler, AgreesWithDenseAssemblyOfRandomBlocks) {
  std::mt19937 random(7);
  const auto upto = [&](int n) { return static_cast<int>(random() % (n + 1)); };
  BlockAssembler assembler;
  for (int trial = 0; trial < 120; ++trial) {
    const int dimension = 1 + trial % 3, n_nodes = 2 + upto(28), n_owned = trial % 4 == 0 ? n_nodes : upto(n_nodes);
    const int n = dimension * n_nodes;
    std::vector<int> all(n_nodes);
    for (int i = 0; i < n_nodes; ++i) all[i] = i;
    Blocks blocks;
    for (int b = upto(12); b >= 0; --b) {
      std::shuffle(all.begin(), all.end(), random);
      blocks.add({all.data(), static_cast<std::size_t>(1 + upto(std::min(n_nodes - 1, 19)))});
    }
    Border border;
    border.active = trial % 2 == 1;
    if (border.active) {
      for (int i = 0; i < n; ++i) {
        if (upto(2) == 0) border.column_rows.push_back(i);
        if (upto(2) == 0) border.row_columns.push_back(i);
      }
      std::shuffle(border.row_columns.begin(), border.row_columns.end(), random);
    }
    assembler.build(blocks, n_nodes, dimension, border);
    const int size = n + border.active;
    ASSERT_EQ(assembler.matrix().n, size);
    for (const bool with_increment : {true, false}) {
      std::vector<char> fixed(n, 0);
      if (trial % 5)
        for (char& f : fixed) f = upto(4) == 0;
      const Eigen::VectorXd given = Eigen::VectorXd::Random(n);
      const std::vector<double> increment(given.data(), given.data() + n);
      const double diagonal = 1e3 + trial;
      assembler.zero(fixed, n_owned, diagonal, with_increment ? &increment : nullptr);
      Reference reference{Eigen::MatrixXd::Zero(size, size), Eigen::VectorXd::Zero(n)};
      for (int i = 0; i < dimension * n_owned; ++i)
        if (fixed[i]) reference.matrix(i, i) = diagonal;  // a ghost's row is its owner's business
      reference.add(blocks, dimension, fixed, increment, assembler);
      if (border.active) {
        std::vector<double> column, row;
        for (int i : border.column_rows) reference.matrix(i, n) = column.emplace_back(2.0 + i);
        for (int i : border.row_columns) reference.matrix(n, i) = row.emplace_back(-3.0 - i);
        assembler.set_border(column, row);
      }
      const double error = (dense_of(assembler.matrix()) - reference.matrix).cwiseAbs().maxCoeff();
      EXPECT_LT(error, 1e-13) << trial;
      if (!with_increment) continue;
      ASSERT_EQ(assembler.prescribed_force().size(), std::size_t(n));
      for (int i = 0; i < n; ++i) EXPECT_NEAR(assembler.prescribed_force()[i], reference.force[i], 1e-13);
    }
  }
}

/// Every unknown has its diagonal in the pattern, also that of a node without blocks and that of the border.
TEST(BlockAssembler, PatternHoldsNeighboursAndDiagonals) {
  Blocks blocks;
  blocks.add(std::vector<int>{3, 1});
  for (int dimension : {1, 2, 3}) {
    BlockAssembler assembler;
    Border border;
    border.active = true;
    assembler.build(blocks, 4, dimension, border);
    const CsrMatrix& csr = assembler.matrix();
    const int n = 4 * dimension;
    ASSERT_EQ(csr.n, n + 1);
    for (int row = 0; row < n; ++row) {
      const int node = row / dimension, neighbours = node % 2 ? 2 : 1;
      ASSERT_EQ(csr.row_begin[row + 1] - csr.row_begin[row], neighbours * dimension);
      const auto first = csr.column.begin() + csr.row_begin[row], last = csr.column.begin() + csr.row_begin[row + 1];
      EXPECT_EQ(std::count(first, last, row), 1);
    }
    EXPECT_EQ(csr.row_begin[n + 1] - csr.row_begin[n], 1);
    EXPECT_EQ(csr.column.back(), n);
  }
}

TEST(BlockAssembler, WithoutNodesIsEmpty) {
  BlockAssembler assembler;
  assembler.build({}, 0, 3);
  assembler.zero({}, 0, 1.0);
  EXPECT_EQ(assembler.matrix().n, 0);
  EXPECT_TRUE(assembler.matrix().column.empty());
}

TEST(BlockAssembler, BorderTakesItsPlace) {
  Blocks blocks;
  blocks.add(std::vector<int>{0, 1});
  BlockAssembler assembler;
  Border border;
  border.active = true;
  border.column_rows = {1, 3};
  border.row_columns = {0, 2};
  assembler.build(blocks, 2, 2, border);
  const std::vector<char> fixed(4, 0);
  assembler.zero(fixed, 2, 1.0);
  assembler.set_border({5.0, 6.0}, {7.0, 8.0});
  ASSERT_EQ(assembler.matrix().n, 5);
  const Eigen::MatrixXd found = dense_of(assembler.matrix());
  EXPECT_EQ(found(1, 4), 5.0);
  EXPECT_EQ(found(3, 4), 6.0);
  EXPECT_EQ(found(4, 0), 7.0);
  EXPECT_EQ(found(4, 2), 8.0);
  EXPECT_EQ(found.cwiseAbs().sum(), 26.0);
}

}  // namespace
}  // namespace berm
