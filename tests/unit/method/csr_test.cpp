#include "method/csr.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>

namespace berm {
namespace {

/// Three blocks over five nodes, two dofs prescribed; compared with assembly into a dense matrix.
TEST(BlockAssembler, AgreesWithDenseAssembly) {
  Blocks blocks;
  blocks.add(std::vector<int>{0, 1, 2});
  blocks.add(std::vector<int>{2, 1, 4, 3});
  blocks.add(std::vector<int>{0, 4});
  std::vector<int> equation = {0, 1, 2, -1, 3, 4, -1, 5, 6, 7};
  const int n = 8;
  BlockAssembler assembler;
  assembler.build(blocks, equation, n);
  std::vector<double> increment(10, 0.0);
  increment[3] = 0.7;
  increment[6] = -1.3;
  assembler.zero(&increment);

  Eigen::MatrixXd dense = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd force = Eigen::VectorXd::Zero(n);
  for (int b = 0; b < blocks.size(); ++b) {
    std::vector<int> dofs;
    for (int node : blocks[b])
      for (int c : {0, 1}) dofs.push_back(2 * node + c);
    const int m = static_cast<int>(dofs.size());
    Eigen::Matrix<double, -1, -1, Eigen::RowMajor> block = Eigen::MatrixXd::Random(m, m);
    assembler.add(b, block.data());
    for (int i = 0; i < m; ++i)
      for (int j = 0; j < m; ++j) {
        if (equation[dofs[i]] < 0) continue;
        if (equation[dofs[j]] >= 0)
          dense(equation[dofs[i]], equation[dofs[j]]) += block(i, j);
        else
          force[equation[dofs[i]]] += block(i, j) * increment[dofs[j]];
      }
  }
  const CsrMatrix& csr = assembler.matrix();
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(n, n);
  for (int row = 0; row < n; ++row)
    for (int k = csr.row_begin[row]; k < csr.row_begin[row + 1]; ++k) {
      if (k > csr.row_begin[row]) {
        EXPECT_LT(csr.column[k - 1], csr.column[k]);
      }
      found(row, csr.column[k]) = csr.value[k];
    }
  EXPECT_LT((found - dense).cwiseAbs().maxCoeff(), 1e-14);
  for (int row = 0; row < n; ++row) EXPECT_NEAR(assembler.prescribed_force()[row], force[row], 1e-14);
}

TEST(BlockAssembler, BorderTakesItsPlace) {
  Blocks blocks;
  blocks.add(std::vector<int>{0, 1});
  BlockAssembler assembler;
  Border border;
  border.active = true;
  border.column_rows = {1, 3};
  border.row_columns = {0, 2};
  assembler.build(blocks, {0, 1, 2, 3}, 4, border);
  assembler.zero();
  assembler.set_border({5.0, 6.0}, {7.0, 8.0});
  const CsrMatrix& csr = assembler.matrix();
  ASSERT_EQ(csr.n, 5);
  Eigen::MatrixXd found = Eigen::MatrixXd::Zero(5, 5);
  for (int row = 0; row < 5; ++row)
    for (int k = csr.row_begin[row]; k < csr.row_begin[row + 1]; ++k) found(row, csr.column[k]) = csr.value[k];
  EXPECT_EQ(found(1, 4), 5.0);
  EXPECT_EQ(found(3, 4), 6.0);
  EXPECT_EQ(found(4, 0), 7.0);
  EXPECT_EQ(found(4, 2), 8.0);
  EXPECT_EQ(found.cwiseAbs().sum(), 26.0);
}

}  // namespace
}  // namespace berm
