#pragma once
#include <array>
#include <cmath>

#include "base/tensor.hpp"

namespace berm {

/// Space in cubes, by three whole numbers.
using Cube = std::array<long, 3>;
inline Cube cube_of(const Vec3& x, double width) {
  return {std::lround(std::floor(x.x() / width)), std::lround(std::floor(x.y() / width)), std::lround(std::floor(x.z() / width))};
}

}  // namespace berm
