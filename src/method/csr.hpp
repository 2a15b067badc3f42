#pragma once
/// Sparse matrix by rows, and its assembly from small dense blocks (one per cell) without searching.

#include <cstddef>
#include <span>
#include <vector>

namespace berm {

struct CsrMatrix {
  int n = 0;
  std::vector<int> row_begin = {0};
  std::vector<int> column;  ///< ascending in every row
  std::vector<double> value;
};

/// Node lists of the blocks: one per active cell, then one per stabilised face. Local node numbers.
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

/// A bordered system has one more unknown (the load factor) and one more equation (the controlled gauge): unknowns with an
/// entry in the last column, and in the last row.
struct Border {
  std::vector<int> column_rows, row_columns;
  bool active = false;
  bool operator==(const Border&) const = default;
};

/// Adds dense blocks into a CSR matrix at positions computed once per connectivity. Unknown number = dimension * node +
/// component, for the nodes of this process, ghosts included; prescribed unknowns keep their row: a diagonal alone.
class BlockAssembler {
public:
  /// dimension: unknowns a node.
  void build(const Blocks& blocks, int n_nodes, int dimension, const Border& border = {});
  /// Zeroes the values. fixed: one flag an unknown; their rows become `diagonal` times the identity where this process
  /// owns the node (the first n_owned nodes), else nothing. If `increment` is given (one an unknown), the columns of fixed
  /// unknowns are multiplied with it and summed into prescribed_force() before they are dropped.
  void zero(const std::vector<char>& fixed, int n_owned, double diagonal,
            const std::vector<double>* increment = nullptr);
  /// dense: row-major block, unknowns ordered node by node.
  void add(int block, const double* dense);
  /// Adds to the diagonal of an unknown; nothing if it is fixed.
  void add_diagonal(int unknown, double value);
  /// Multiplies everything added so far, prescribed_force() too.
  void scale(double factor);
  int nodes_of(int block) const { return static_cast<int>(blocks_[block].size()); }
  /// Last column / last row of a bordered system, in the order of Border's lists.
  void set_border(const std::vector<double>& column, const std::vector<double>& row);
  CsrMatrix& matrix() { return matrix_; }
  /// K_fp du_p, one entry an unknown.
  const std::vector<double>& prescribed_force() const { return prescribed_force_; }

private:
  int position(int row, int column) const;

  int dimension_ = 2;
  CsrMatrix matrix_;
  Blocks blocks_;
  std::vector<std::size_t> start_;  ///< first entry of a block in target_
  std::vector<int> target_;         ///< of a pair of nodes: place in matrix_.value of their first unknowns
  std::vector<int> diagonal_;       ///< place of every unknown's diagonal
  std::vector<int> border_column_, border_row_;
  const std::vector<char>* fixed_ = nullptr;
  const std::vector<double>* increment_ = nullptr;
  std::vector<char> touches_fixed_;  ///< of a block, for the flags of the last zero()
  std::vector<double> prescribed_force_;
};

}  // namespace berm
