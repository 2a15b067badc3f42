#pragma once
/// Sparse matrix by rows, and its assembly from small dense blocks (one per cell) without searching.

#include <span>
#include <vector>

namespace berm {

struct CsrMatrix {
  int n = 0;
  std::vector<int> row_begin = {0};
  std::vector<int> column;  ///< ascending in every row
  std::vector<double> value;
};

/// Node lists of the blocks: one per active cell, then one per stabilised face.
struct Blocks {
  std::vector<int> offsets = {0};
  std::vector<int> nodes;

  int size() const { return static_cast<int>(offsets.size()) - 1; }
  std::span<const int> operator[](int b) const { return {nodes.data() + offsets[b], nodes.data() + offsets[b + 1]}; }
  void add(std::span<const int> list) {
    nodes.insert(nodes.end(), list.begin(), list.end());
    offsets.push_back(static_cast<int>(nodes.size()));
  }
  bool operator==(const Blocks&) const = default;
};

/// A bordered system has one more unknown (the load factor) and one more equation (the controlled gauge):
/// equations with an entry in the last column, and in the last row.
struct Border {
  std::vector<int> column_rows, row_columns;
  bool active = false;
  bool operator==(const Border&) const = default;
};

/// Adds dense blocks into a CSR matrix at positions computed once per connectivity.
class BlockAssembler {
public:
  /// equation: 2 per node, -1 where the displacement is prescribed.
  void build(const Blocks& blocks, const std::vector<int>& equation, int n_equations, const Border& border = {});
  /// Zeroes the values. If `increment` is given (2 per node), the columns of prescribed dofs are not dropped but
  /// multiplied with it and summed into prescribed_force().
  void zero(const std::vector<double>* increment = nullptr);
  /// dense: (2n x 2n) row-major block, dofs ordered node by node (x, y).
  void add(int block, const double* dense);
  /// Last column / last row of a bordered system, in the order of Border's lists.
  void set_border(const std::vector<double>& column, const std::vector<double>& row);
  CsrMatrix& matrix() { return matrix_; }
  /// K_fp du_p, one entry an equation.
  const std::vector<double>& prescribed_force() const { return prescribed_force_; }

private:
  int position(int row, int column) const;

  CsrMatrix matrix_;
  std::vector<std::size_t> start_;  ///< first entry of a block in target_
  std::vector<int> size_;           ///< dofs of a block
  std::vector<int> target_;         ///< position in matrix_.value, or -1
  std::vector<int> border_column_, border_row_;
  std::vector<int> dof_, equation_;
  std::vector<std::size_t> dof_start_;
  std::vector<char> touches_prescribed_;
  const std::vector<double>* increment_ = nullptr;
  std::vector<double> prescribed_force_;
};

}  // namespace berm
