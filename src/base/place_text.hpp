#pragma once
/// A place as messages write it.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "base/tensor.hpp"

namespace berm {

/// The first two or three coordinates [m], with the digits that those of a map need.
inline std::string place_text(const Vec3& place, int dimension) {
  constexpr double round_off = 1e-12;  // of the place, or of a millimetre
  Vec3 x = place;
  for (double& value : x)
    if (std::abs(value) < round_off * std::max(1e-3, place.cwiseAbs().maxCoeff())) value = 0.0;
  return x.cwiseAbs().maxCoeff() < 1e5 ? fmt::format("({:.6g})", fmt::join(x.data(), x.data() + dimension, ", "))
                                       : fmt::format("({:.10g})", fmt::join(x.data(), x.data() + dimension, ", "));
}

}  // namespace berm
