#pragma once
/// Places far from the origin as the decimals that somebody wrote.

#include <cmath>
#include <limits>

#include "base/tensor.hpp"

namespace berm {

/// Differences to a place are rounded to multiples of one over this: decimals that numbers of its size still have. Their last
/// binary digits would cut slivers from cells.
inline double decimals_at(const Vec3& place) {
  const double digits = std::floor(-std::log10(4.0 * place.cwiseAbs().maxCoeff() * std::numeric_limits<double>::epsilon()));
  return std::pow(10.0, std::max(0.0, digits));
}

/// x - from, rounded; infinite ends stay.
inline double difference(double x, double from, double decimals) {
  return from != 0.0 && std::isfinite(x) ? std::round((x - from) * decimals) / decimals : x;
}

}  // namespace berm
