#pragma once
/// history.csv: one row a converged step (docs/output.md).

#include <string>
#include <vector>

#include "io/file.hpp"

namespace berm {

/// The columns that every history starts with, in this order. Gauges, probes and named reactions follow.
std::vector<std::string> standard_history_columns();

class HistoryWriter {
public:
  /// Column names carry their unit: "reaction [N]". Writes the header. Throws RunError if the file cannot be written.
  HistoryWriter(const std::string& path, const std::vector<std::string>& columns);
  /// Writes a row with the shortest digits that read back to the same doubles, and flushes it. Throws RunError naming
  /// the file if it cannot be written or something else has changed it, std::invalid_argument if the number of values is not the number of columns.
  void append(const std::vector<double>& row);

private:
  OutputFile file_;
  std::size_t n_columns_;
};

}  // namespace berm
