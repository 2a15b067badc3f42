#pragma once
#include <algorithm>
#include <vector>

namespace berm {

/// Ascending, every value once.
template <class T>
void sort_unique(std::vector<T>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace berm
