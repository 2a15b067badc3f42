#pragma once
/// What the two halves of the checks before a run have in common.

#include <map>

#include "base/groups.hpp"
#include "case/case.hpp"

namespace berm {

/// By body of the case.
inline std::map<int, Region> regions_of_shapes(const Case& c, double size) {
  std::map<int, Region> regions;
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].shape) regions.try_emplace(static_cast<int>(b), *c.bodies[b].shape, size);
  return regions;
}

}  // namespace berm
