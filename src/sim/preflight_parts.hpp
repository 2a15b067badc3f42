#pragma once
/// What the two halves of the checks before a run have in common.

#include <map>
#include <numeric>
#include <vector>

#include "case/case.hpp"

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

/// By body of the case.
inline std::map<int, Region> regions_of_shapes(const Case& c, double size) {
  std::map<int, Region> regions;
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].shape) regions.try_emplace(static_cast<int>(b), *c.bodies[b].shape, size);
  return regions;
}

}  // namespace berm
