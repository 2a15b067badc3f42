#pragma once
/// Values between points: a weighted least-squares fit over the neighbourhood. Used by probes and for the stress noise
/// metric.

#include <vector>

#include "base/tensor.hpp"

namespace berm {

/// Weights such that value(at) = sum weight[k] * value(point[k]); exact for linear fields (degree 2: quadratic ones).
struct LocalFit {
  std::vector<int> point;
  std::vector<double> weight;

  template <class Value>
  double apply(Value&& value) const {
    double sum = 0.0;
    for (std::size_t k = 0; k < point.size(); ++k) sum += weight[k] * value(point[k]);
    return sum;
  }
};

/// Bins points, to find those near a place.
class PointBins {
public:
  /// dimension 2: z does not matter.
  PointBins(const std::vector<Vec3>& x, double size, int dimension);
  /// Fit over the points within `radius` of `at` (at most the bin size), weighted by volume and a linear hat. A fit of
  /// degree 2 does not flatten peaks; it needs 8 points (space: 14) that determine it. Too few points, or points in a
  /// line or plane: the next lower degree, at last the nearest point.
  LocalFit fit(const Vec3& at, double radius, const std::vector<double>& volume, int degree = 1) const;

private:
  template <int dimension, int degree>
  bool solve(const Vec3& at, double radius, LocalFit& fit) const;
  int bin(const Vec3& x, int dx, int dy, int dz) const;

  const std::vector<Vec3>& x_;
  int dimension_;
  Vec3 origin_;
  double size_;
  int n_[3] = {1, 1, 1};
  std::vector<int> first_, list_;
};

}  // namespace berm
