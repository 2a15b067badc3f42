#pragma once
/// A place as messages write it.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <string>

#include "base/tensor.hpp"

namespace berm {

/// The first two or three coordinates [m], with the digits that those of a map need.
inline std::string place_text(const Vec3& x, int dimension) {
  return x.cwiseAbs().maxCoeff() < 1e5 ? fmt::format("({:.6g})", fmt::join(x.data(), x.data() + dimension, ", "))
                                       : fmt::format("({:.10g})", fmt::join(x.data(), x.data() + dimension, ", "));
}

}  // namespace berm
