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

namespace {

/// Monomials 1, x, y (degree 1), x^2, x y, y^2 (degree 2).
template <int degree>
Eigen::Matrix<double, (degree + 1) * (degree + 2) / 2, 1> basis(const Vec2& d) {
  Eigen::Matrix<double, (degree + 1) * (degree + 2) / 2, 1> b;
  if constexpr (degree == 1)
    b << 1.0, d.x(), d.y();
  else
    b << 1.0, d.x(), d.y(), d.x() * d.x(), d.x() * d.y(), d.y() * d.y();
  return b;
}

}  // namespace

/// Turns the weights of the points into those of the fit's value at `at`. False if they do not determine the fit.
template <int degree>
bool PointBins::solve(const Vec2& at, double radius, LocalFit& fit) const {
  constexpr int size = (degree + 1) * (degree + 2) / 2;
  if (fit.point.size() < (degree == 1 ? 3 : 8)) return false;
  Eigen::Matrix<double, size, size> moments = Eigen::Matrix<double, size, size>::Zero();
  for (std::size_t k = 0; k < fit.point.size(); ++k) {
    const auto b = basis<degree>((x_[fit.point[k]] - at) / radius);
    moments += fit.weight[k] * b * b.transpose();
  }
  const Eigen::FullPivLU<Eigen::Matrix<double, size, size>> lu(moments);
  if (lu.rcond() < (degree == 1 ? 1e-10 : 1e-6)) return false;
  const Eigen::Matrix<double, size, 1> first = lu.solve(Eigen::Matrix<double, size, 1>::Unit(0));
  for (std::size_t k = 0; k < fit.point.size(); ++k)
    fit.weight[k] *= first.dot(basis<degree>((x_[fit.point[k]] - at) / radius));
  return true;
}

LocalFit PointBins::fit(const Vec2& at, double radius, const std::vector<double>& volume, int degree) const {
  LocalFit out;
  int nearest = -1;
  double nearest_distance = 0.0;
  for (int dy = -1; dy <= 1; ++dy)
    for (int dx = -1; dx <= 1; ++dx) {
      const int b = bin(at, dx, dy);
      if (b < 0) continue;
      for (int k = first_[b]; k < first_[b + 1]; ++k) {
        const int p = list_[k];
        const double distance = (x_[p] - at).norm() / radius;
        if (nearest < 0 || distance < nearest_distance) {
          nearest = p;
          nearest_distance = distance;
        }
        if (distance >= 1.0) continue;
        out.point.push_back(p);
        out.weight.push_back(volume[p] * (1.0 - distance));
      }
    }
  if (degree >= 2 && solve<2>(at, radius, out)) return out;
  if (solve<1>(at, radius, out)) return out;
  if (nearest < 0) {  // no point in the surrounding bins: search them all
    nearest = 0;
    for (std::size_t p = 1; p < x_.size(); ++p)
      if ((x_[p] - at).squaredNorm() < (x_[nearest] - at).squaredNorm()) nearest = static_cast<int>(p);
  }
  return {{nearest}, {1.0}};
}

}  // namespace berm
