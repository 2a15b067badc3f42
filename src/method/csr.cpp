#include "method/csr.hpp"

#include <algorithm>
#include <limits>

#include "base/error.hpp"

namespace berm {
namespace {

/// Nodes that share a block with each node, ascending (CSR).
Blocks node_neighbours(const Blocks& blocks, int n_nodes) {
  std::vector<int> count(n_nodes + 1, 0);
  for (int node : blocks.nodes) ++count[node + 1];
  for (int i = 0; i < n_nodes; ++i) count[i + 1] += count[i];
  std::vector<int> blocks_of(blocks.nodes.size());
  std::vector<int> fill(count.begin(), count.end() - 1);
  for (int b = 0; b < blocks.size(); ++b)
    for (int node : blocks[b]) blocks_of[fill[node]++] = b;

  Blocks neighbours;
  std::vector<int> stamp(n_nodes, -1);
  std::vector<int> row;
  for (int node = 0; node < n_nodes; ++node) {
    row.assign(1, node);  // a node without blocks here keeps its diagonal
    stamp[node] = node;
    for (int k = count[node]; k < count[node + 1]; ++k)
      for (int other : blocks[blocks_of[k]])
        if (stamp[other] != node) {
          stamp[other] = node;
          row.push_back(other);
        }
    std::sort(row.begin(), row.end());
    neighbours.add(row);
  }
  return neighbours;
}

}  // namespace

void BlockAssembler::build(const Blocks& blocks, int n_nodes, int dimension, const Border& border) {
  dimension_ = dimension;
  blocks_ = blocks;
  const Blocks neighbours = node_neighbours(blocks, n_nodes);
  const int n_unknowns = dimension * n_nodes;
  matrix_.n = n_unknowns + (border.active ? 1 : 0);
  std::vector<char> in_border_column(n_unknowns, 0);
  for (int row : border.column_rows) in_border_column[row] = 1;
  const std::size_t entries = neighbours.nodes.size() * dimension * dimension + border.column_rows.size() +
                              border.row_columns.size() + 1;
  if (entries > static_cast<std::size_t>(std::numeric_limits<int>::max()))
    throw RunError("the matrix of a process has more than 2^31 entries: take more processes or larger cells");

  matrix_.row_begin.assign(1, 0);
  matrix_.column.clear();
  matrix_.column.reserve(entries);
  diagonal_.resize(n_unknowns);
  for (int node = 0; node < n_nodes; ++node)
    for (int c = 0; c < dimension; ++c) {
      const int row = dimension * node + c;
      for (int other : neighbours[node])
        for (int d = 0; d < dimension; ++d) {
          if (other == node && d == c) diagonal_[row] = static_cast<int>(matrix_.column.size());
          matrix_.column.push_back(dimension * other + d);
        }
      if (in_border_column[row]) matrix_.column.push_back(n_unknowns);
      matrix_.row_begin.push_back(static_cast<int>(matrix_.column.size()));
    }
  if (border.active) {
    std::vector<int> columns = border.row_columns;
    columns.push_back(n_unknowns);
    std::sort(columns.begin(), columns.end());
    matrix_.column.insert(matrix_.column.end(), columns.begin(), columns.end());
    matrix_.row_begin.push_back(static_cast<int>(matrix_.column.size()));
  }
  matrix_.value.assign(matrix_.column.size(), 0.0);

  start_.clear();
  target_.clear();
  for (int b = 0; b < blocks.size(); ++b) {
    start_.push_back(target_.size());
    for (int i : blocks[b])
      for (int j : blocks[b]) target_.push_back(position(dimension * i, dimension * j));
  }
  border_column_.clear();
  border_row_.clear();
  for (int row : border.column_rows) border_column_.push_back(position(row, n_unknowns));
  for (int column : border.row_columns) border_row_.push_back(position(n_unknowns, column));
}

int BlockAssembler::position(int row, int column) const {
  const auto first = matrix_.column.begin() + matrix_.row_begin[row];
  const auto last = matrix_.column.begin() + matrix_.row_begin[row + 1];
  return static_cast<int>(std::lower_bound(first, last, column) - matrix_.column.begin());
}

void BlockAssembler::zero(const std::vector<char>& fixed, int n_owned, double diagonal,
                          const std::vector<double>* increment) {
  std::fill(matrix_.value.begin(), matrix_.value.end(), 0.0);
  fixed_ = &fixed;
  increment_ = increment;
  if (increment_) prescribed_force_.assign(fixed.size(), 0.0);
  for (int row = 0; row < dimension_ * n_owned; ++row)
    if (fixed[row]) matrix_.value[diagonal_[row]] = diagonal;
  touches_fixed_.assign(blocks_.size(), 0);
  for (int b = 0; b < blocks_.size(); ++b)
    for (int node : blocks_[b])
      for (int c = 0; c < dimension_; ++c) touches_fixed_[b] |= fixed[dimension_ * node + c];
}

void BlockAssembler::add(int block, const double* dense) {
  const std::span<const int> nodes = blocks_[block];
  const int n = static_cast<int>(nodes.size()), d = dimension_, width = n * d;
  const int* target = target_.data() + start_[block];
  const std::vector<char>& fixed = *fixed_;
  for (int i = 0; i < n; ++i) {
    for (int c = 0; c < d; ++c) {
      const int row = d * nodes[i] + c;
      const double* from = dense + (i * d + c) * width;
      // Rows of a node are equally long, but for a border's column at the end of some.
      const int shift = matrix_.row_begin[row] - matrix_.row_begin[d * nodes[i]];
      if (!touches_fixed_[block]) {
        for (int j = 0; j < n; ++j) {
          double* to = &matrix_.value[target[i * n + j] + shift];
          for (int e = 0; e < d; ++e) to[e] += from[j * d + e];
        }
        continue;
      }
      if (fixed[row]) continue;
      for (int j = 0; j < n; ++j)
        for (int e = 0; e < d; ++e) {
          const int column = d * nodes[j] + e;
          if (!fixed[column])
            matrix_.value[target[i * n + j] + shift + e] += from[j * d + e];
          else if (increment_)
            prescribed_force_[row] += from[j * d + e] * (*increment_)[column];
        }
    }
  }
}

void BlockAssembler::add_diagonal(int unknown, double value) {
  if (!(*fixed_)[unknown]) matrix_.value[diagonal_[unknown]] += value;
}

void BlockAssembler::scale(double factor) {
  for (double& value : matrix_.value) value *= factor;
  for (double& value : prescribed_force_) value *= factor;
}

void BlockAssembler::set_border(const std::vector<double>& column, const std::vector<double>& row) {
  for (std::size_t k = 0; k < border_column_.size(); ++k) matrix_.value[border_column_[k]] = column[k];
  for (std::size_t k = 0; k < border_row_.size(); ++k) matrix_.value[border_row_[k]] = row[k];
}

}  // namespace berm
