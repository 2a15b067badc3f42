#pragma once
#include <cstddef>
#include <numeric>
#include <vector>

namespace berm {

/// Sets that grow together.
class Groups {
public:
  explicit Groups(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), 0); }
  int of(int k) {
    while (parent_[k] != k) k = parent_[k] = parent_[parent_[k]];
    return k;
  }
  void join(int a, int b) { parent_[of(a)] = of(b); }

private:
  std::vector<int> parent_;
};

}  // namespace berm
