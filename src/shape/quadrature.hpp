#pragma once
/// Gauss rules on the reference triangle (0,0)-(1,0)-(0,1), tetrahedron (corners 0, e_1, e_2, e_3), square and cube
/// [-1,1]^d.

#include <vector>

#include "base/tensor.hpp"

namespace berm {

struct QuadraturePoint {
  Vec3 xi;
  double weight;  ///< sums to 1/2 (triangle), 4 (square), 1/6 (tetrahedron), 8 (cube)
};

/// Gauss-Legendre on [-1, 1] with n = 1 ... 4 points: {position, weight}.
std::vector<std::pair<double, double>> gauss_line(int n);
/// n x n Gauss points of the square.
std::vector<QuadraturePoint> gauss_square(int n);
/// n x n x n Gauss points of the cube.
std::vector<QuadraturePoint> gauss_cube(int n);
/// Symmetric rules with 1, 3, 6 or 12 points, exact to degree 1, 2, 4, 6 (Dunavant 1985).
std::vector<QuadraturePoint> gauss_triangle(int points);
/// Rules with 1 or 4 points, exact to degree 1, 2 (Keast 1986).
std::vector<QuadraturePoint> gauss_tetrahedron(int points);

}  // namespace berm
