#include "sim/local_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace berm {

PointBins::PointBins(const std::vector<Vec2>& x, double size) : x_(x), size_(size) {
  origin_ = x.front();
  Vec2 top = x.front();
  for (const Vec2& p : x) {
    origin_ = origin_.cwiseMin(p);
    top = top.cwiseMax(p);
  }
  nx_ = 1 + static_cast<int>((top.x() - origin_.x()) / size);
  ny_ = 1 + static_cast<int>((top.y() - origin_.y()) / size);
  first_.assign(nx_ * ny_ + 1, 0);
  for (const Vec2& p : x) ++first_[bin(p, 0, 0) + 1];
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
  list_.resize(x.size());
  std::vector<int> fill(first_.begin(), first_.end() - 1);
  for (std::size_t p = 0; p < x.size(); ++p) list_[fill[bin(x[p], 0, 0)]++] = static_cast<int>(p);
}

int PointBins::bin(const Vec2& x, int dx, int dy) const {
  const int i = static_cast<int>(std::floor((x.x() - origin_.x()) / size_)) + dx;
  const int j = static_cast<int>(std::floor((x.y() - origin_.y()) / size_)) + dy;
  return i < 0 || j < 0 || i >= nx_ || j >= ny_ ? -1 : j * nx_ + i;
}

LocalFit PointBins::fit(const Vec2& at, double radius, const std::vector<double>& volume) const {
  LocalFit out;
  Mat3 moments = Mat3::Zero();
  int nearest = -1;
  double nearest_distance = 0.0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int b = bin(at, dx, dy);
      if (b < 0) continue;
      for (int k = first_[b]; k < first_[b + 1]; ++k) {
        const int p = list_[k];
        const Vec2 d = (x_[p] - at) / radius;
        const double distance = d.norm();
        if (nearest < 0 || distance < nearest_distance) {
          nearest = p;
          nearest_distance = distance;
        }
        if (distance >= 1.0) continue;
        const Vec3 basis(1.0, d.x(), d.y());
        const double weight = volume[p] * (1.0 - distance);
        moments += weight * basis * basis.transpose();
        out.point.push_back(p);
        out.weight.push_back(weight);
      }
    }
  const Eigen::FullPivLU<Mat3> lu(moments);
  if (out.point.size() < 3 || lu.rcond() < 1e-10) {
    if (nearest < 0) {  // no point in the surrounding bins: search them all
      nearest = 0;
      for (std::size_t p = 1; p < x_.size(); ++p)
        if ((x_[p] - at).squaredNorm() < (x_[nearest] - at).squaredNorm()) nearest = static_cast<int>(p);
    }
    return {{nearest}, {1.0}};
  }
  const Vec3 first = lu.solve(Vec3(1.0, 0.0, 0.0));
  for (std::size_t k = 0; k < out.point.size(); ++k) {
    const Vec2 d = (x_[out.point[k]] - at) / radius;
    out.weight[k] *= first.dot(Vec3(1.0, d.x(), d.y()));
  }
  return out;
}

}  // namespace berm
