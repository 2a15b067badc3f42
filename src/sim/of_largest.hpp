#pragma once
#include <vector>

#include "comm/comm.hpp"

namespace berm {

/// The row of the process whose value is the largest; `largest`: of all. Collective.
inline std::vector<double> row_of_largest(const Comm& comm, double value, double largest, std::vector<double> row) {
  if (value != largest) row.clear();
  return comm.all_gather(row);  // where several have it, that of the first one is in front
}

}  // namespace berm
