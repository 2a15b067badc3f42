#include "mesh/closed_spline.hpp"

#include <Eigen/Sparse>
#include <Eigen/SparseLU>

#include "base/error.hpp"

namespace berm {
namespace {

/// Second derivatives at the points: slopes agree at every one of them, with knots d[i] from point i to the next.
Eigen::MatrixX2d second_derivatives(const std::vector<Vec2>& x, const std::vector<double>& d) {
  const int n = int(x.size());
  Eigen::SparseMatrix<double> A(n, n);
  Eigen::MatrixX2d b(n, 2);
  for (int i = 0; i < n; ++i) {
    const int before = (i + n - 1) % n, after = (i + 1) % n;
    A.coeffRef(i, before) += d[before] / 6.0;
    A.coeffRef(i, i) += (d[before] + d[i]) / 3.0;
    A.coeffRef(i, after) += d[i] / 6.0;
    b.row(i) = (x[after] - x[i]) / d[i] - (x[i] - x[before]) / d[before];
  }
  A.makeCompressed();
  Eigen::SparseLU<Eigen::SparseMatrix<double>> lu(A);  // diagonally dominant
  if (lu.info() != Eigen::Success) throw InputError("the points of the spline are too far apart");
  return lu.solve(b);
}

}  // namespace

std::vector<Vec2> closed_spline(const std::vector<Vec2>& points, int pieces) {
  const std::size_t n = points.size();
  std::vector<double> d;
  for (std::size_t i = 0; i < n; ++i) d.push_back((points[(i + 1) % n] - points[i]).norm());
  const Eigen::MatrixX2d second = second_derivatives(points, d);

  std::vector<Vec2> curve;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t next = (i + 1) % n;
    for (int k = 0; k < pieces; ++k) {
      const double b = double(k) / pieces, a = 1.0 - b, scale = d[i] * d[i] / 6.0;
      const Vec2 bend = (a * a * a - a) * second.row(i) + (b * b * b - b) * second.row(next);
      curve.push_back(a * points[i] + b * points[next] + scale * bend);
    }
  }
  return curve;
}

}  // namespace berm
