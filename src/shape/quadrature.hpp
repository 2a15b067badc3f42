#pragma once
/// Gauss rules on the reference triangle (0,0)-(1,0)-(0,1) and on the reference square [-1,1]^2.

#include <vector>

#include "base/tensor.hpp"

namespace berm {

struct QuadraturePoint {
  Vec2 xi;
  double weight;  ///< sums to 1/2 (triangle) or 4 (square)
};

/// Gauss-Legendre on [-1, 1] with n = 1 ... 4 points: {position, weight}.
std::vector<std::pair<double, double>> gauss_line(int n);
/// n x n Gauss points of the square.
std::vector<QuadraturePoint> gauss_square(int n);
/// Symmetric rules with 1, 3, 6 or 12 points, exact to degree 1, 2, 4, 6 (Dunavant 1985).
std::vector<QuadraturePoint> gauss_triangle(int points);

}  // namespace berm
