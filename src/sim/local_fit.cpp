#include "sim/local_fit.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

namespace berm {

PointBins::PointBins(const std::vector<Vec3>& x, double size, int dimension)
    : x_(x), dimension_(dimension), origin_(Vec3::Zero()), size_(size) {
  if (x.empty()) {
    first_ = {0, 0};
    return;
  }
  origin_ = x.front();
  Vec3 top = x.front();
  for (const Vec3& p : x) {
    origin_ = origin_.cwiseMin(p);
    top = top.cwiseMax(p);
  }
  for (int d = 0; d < dimension; ++d) n_[d] = 1 + static_cast<int>((top[d] - origin_[d]) / size);
  first_.assign(std::size_t(n_[0]) * n_[1] * n_[2] + 1, 0);
  for (const Vec3& p : x) ++first_[bin(p, 0, 0, 0) + 1];
  for (std::size_t k = 1; k < first_.size(); ++k) first_[k] += first_[k - 1];
  list_.resize(x.size());
  std::vector<int> fill(first_.begin(), first_.end() - 1);
  for (std::size_t p = 0; p < x.size(); ++p) list_[fill[bin(x[p], 0, 0, 0)]++] = static_cast<int>(p);
}

int PointBins::bin(const Vec3& x, int dx, int dy, int dz) const {
  const int step[3] = {dx, dy, dz};
  int index[3] = {0, 0, 0};
  for (int d = 0; d < dimension_; ++d) {
    index[d] = static_cast<int>(std::floor((x[d] - origin_[d]) / size_)) + step[d];
    if (index[d] < 0 || index[d] >= n_[d]) return -1;
  }
  return (index[2] * n_[1] + index[1]) * n_[0] + index[0];
}

namespace {

constexpr int basis_size(int dimension, int degree) {
  return degree == 1 ? 1 + dimension : (dimension + 1) * (dimension + 2) / 2;
}

/// Monomials 1, x, y(, z) and with degree 2 all products of two coordinates.
template <int dimension, int degree>
Eigen::Matrix<double, basis_size(dimension, degree), 1> basis(const Vec3& d) {
  Eigen::Matrix<double, basis_size(dimension, degree), 1> b;
  int k = 0;
  b[k++] = 1.0;
  for (int i = 0; i < dimension; ++i) b[k++] = d[i];
  if constexpr (degree == 2)
    for (int i = 0; i < dimension; ++i)
      for (int j = i; j < dimension; ++j) b[k++] = d[i] * d[j];
  return b;
}

}  // namespace

/// Turns the weights of the points into those of the fit's value at `at`. False if they do not determine the fit.
template <int dimension, int degree>
bool PointBins::solve(const Vec3& at, double radius, LocalFit& fit) const {
  constexpr int size = basis_size(dimension, degree);
  constexpr int enough = degree == 1 ? dimension + 1 : dimension == 2 ? 8 : 14;
  if (fit.point.size() < enough) return false;
  Eigen::Matrix<double, size, size> moments = Eigen::Matrix<double, size, size>::Zero();
  double total = 0.0;
  for (double w : fit.weight) total += w;
  for (std::size_t k = 0; k < fit.point.size(); ++k) {
    const auto b = basis<dimension, degree>((x_[fit.point[k]] - at) / radius);
    moments += fit.weight[k] / total * b * b.transpose();
  }
  const Eigen::FullPivLU<Eigen::Matrix<double, size, size>> lu(moments);
  // rcond leaves out what the decomposition takes for zero.
  if (!lu.isInvertible() || lu.rcond() < (degree == 1 ? 1e-10 : 1e-6)) return false;
  const Eigen::Matrix<double, size, 1> first = lu.solve(Eigen::Matrix<double, size, 1>::Unit(0)) / total;
  for (std::size_t k = 0; k < fit.point.size(); ++k)
    fit.weight[k] *= first.dot(basis<dimension, degree>((x_[fit.point[k]] - at) / radius));
  return true;
}

LocalFit PointBins::fit(const Vec3& at, double radius, const std::vector<double>& volume, int degree) const {
  LocalFit out;
  int nearest = -1;
  double nearest_distance = 0.0;
  const int deep = dimension_ == 3 ? 1 : 0;
  for (int dz = -deep; dz <= deep; ++dz)
    for (int dy = -1; dy <= 1; ++dy)
      for (int dx = -1; dx <= 1; ++dx) {
        const int b = bin(at, dx, dy, dz);
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
  const bool space = dimension_ == 3;
  if (degree >= 2 && (space ? solve<3, 2>(at, radius, out) : solve<2, 2>(at, radius, out))) return out;
  if (space ? solve<3, 1>(at, radius, out) : solve<2, 1>(at, radius, out)) return out;
  if (nearest < 0) {  // no point in the surrounding bins: search them all
    nearest = 0;
    for (std::size_t p = 1; p < x_.size(); ++p)
      if ((x_[p] - at).squaredNorm() < (x_[nearest] - at).squaredNorm()) nearest = static_cast<int>(p);
  }
  return {{nearest}, {1.0}};
}

}  // namespace berm
