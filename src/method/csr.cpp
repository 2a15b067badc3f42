#include "method/csr.hpp"

#include <algorithm>

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
    row.clear();
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

void BlockAssembler::build(const Blocks& blocks, const std::vector<int>& equation, int n_equations,
                           const Border& border) {
  const int n_nodes = static_cast<int>(equation.size()) / 2;
  const Blocks neighbours = node_neighbours(blocks, n_nodes);
  const int n = n_equations + (border.active ? 1 : 0);

  std::vector<char> in_border_column(n, 0);
  for (int row : border.column_rows) in_border_column[row] = 1;

  // Equations are numbered by ascending node, so that rows come out in order and columns ascending.
  matrix_.n = n;
  matrix_.row_begin.assign(1, 0);
  matrix_.column.clear();
  for (int node = 0; node < n_nodes; ++node)
    for (int c = 0; c < 2; ++c) {
      const int row = equation[2 * node + c];
      if (row < 0) continue;
      for (int other : neighbours[node])
        for (int d = 0; d < 2; ++d)
          if (equation[2 * other + d] >= 0) matrix_.column.push_back(equation[2 * other + d]);
      if (in_border_column[row]) matrix_.column.push_back(n_equations);
      matrix_.row_begin.push_back(static_cast<int>(matrix_.column.size()));
    }
  if (border.active) {
    std::vector<int> columns = border.row_columns;
    columns.push_back(n_equations);
    std::sort(columns.begin(), columns.end());
    matrix_.column.insert(matrix_.column.end(), columns.begin(), columns.end());
    matrix_.row_begin.push_back(static_cast<int>(matrix_.column.size()));
  }
  matrix_.value.assign(matrix_.column.size(), 0.0);

  start_.clear();
  size_.clear();
  target_.clear();
  dof_.clear();
  dof_start_.clear();
  touches_prescribed_.clear();
  equation_ = equation;
  std::vector<int> dofs;
  for (int b = 0; b < blocks.size(); ++b) {
    dofs.clear();
    dof_start_.push_back(dof_.size());
    bool touches = false;
    for (int node : blocks[b])
      for (int c = 0; c < 2; ++c) {
        dof_.push_back(2 * node + c);
        dofs.push_back(equation[2 * node + c]);
        touches = touches || dofs.back() < 0;
      }
    touches_prescribed_.push_back(touches);
    start_.push_back(target_.size());
    size_.push_back(static_cast<int>(dofs.size()));
    for (int row : dofs)
      for (int column : dofs) target_.push_back(row < 0 || column < 0 ? -1 : position(row, column));
  }
  border_column_.clear();
  border_row_.clear();
  for (int row : border.column_rows) border_column_.push_back(position(row, n_equations));
  for (int column : border.row_columns) border_row_.push_back(position(n_equations, column));
}

int BlockAssembler::position(int row, int column) const {
  const auto first = matrix_.column.begin() + matrix_.row_begin[row];
  const auto last = matrix_.column.begin() + matrix_.row_begin[row + 1];
  return static_cast<int>(std::lower_bound(first, last, column) - matrix_.column.begin());
}

void BlockAssembler::zero(const std::vector<double>* increment) {
  std::fill(matrix_.value.begin(), matrix_.value.end(), 0.0);
  increment_ = increment;
  if (increment_) prescribed_force_.assign(matrix_.n, 0.0);
}

void BlockAssembler::add(int block, const double* dense) {
  const int* target = target_.data() + start_[block];
  const int entries = size_[block] * size_[block];
  double* value = matrix_.value.data();
  for (int k = 0; k < entries; ++k)
    if (target[k] >= 0) value[target[k]] += dense[k];
  if (!increment_ || !touches_prescribed_[block]) return;
  const int n = size_[block];
  const int* dof = dof_.data() + dof_start_[block];
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      if (equation_[dof[i]] >= 0 && equation_[dof[j]] < 0)
        prescribed_force_[equation_[dof[i]]] += dense[i * n + j] * (*increment_)[dof[j]];
}

void BlockAssembler::set_border(const std::vector<double>& column, const std::vector<double>& row) {
  for (std::size_t k = 0; k < border_column_.size(); ++k) matrix_.value[border_column_[k]] = column[k];
  for (std::size_t k = 0; k < border_row_.size(); ++k) matrix_.value[border_row_[k]] = row[k];
}

}  // namespace berm
