#pragma once
/// Sparse matrices as dense ones, to look at.

#include <Eigen/Core>

#include "method/csr.hpp"

namespace berm {

inline Eigen::MatrixXd dense_of(const CsrMatrix& csr) {
  Eigen::MatrixXd K = Eigen::MatrixXd::Zero(csr.n, csr.n);
  for (int row = 0; row < csr.n; ++row)
    for (int k = csr.row_begin[row]; k < csr.row_begin[row + 1]; ++k) K(row, csr.column[k]) = csr.value[k];
  return K;
}

}  // namespace berm
