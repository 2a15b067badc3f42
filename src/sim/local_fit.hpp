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
  PointBins(const std::vector<Vec2>& x, double size);
  /// Fit over the points within `radius` of `at` (at most the bin size), weighted by volume and a linear hat. A fit of
  /// degree 2 does not flatten peaks; it needs 8 points that determine it. Too few points, or points in a line: the
  /// next lower degree, at last the nearest point.
  LocalFit fit(const Vec2& at, double radius, const std::vector<double>& volume, int degree = 1) const;

private:
  template <int degree>
  bool solve(const Vec2& at, double radius, LocalFit& fit) const;
  int bin(const Vec2& x, int dx, int dy) const;

  const std::vector<Vec2>& x_;
  Vec2 origin_;
  double size_;
  int nx_ = 1, ny_ = 1;
  std::vector<int> first_, list_;
};

}  // namespace berm
