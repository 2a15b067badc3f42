#include "shape/quadrature.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "base/error.hpp"

using namespace berm;

namespace {

double factorial(int n) { return n < 2 ? 1.0 : n * factorial(n - 1); }

double integral(const std::vector<QuadraturePoint>& rule, int a, int b, int c) {
  double sum = 0.0;
  for (const QuadraturePoint& q : rule)
    sum += q.weight * std::pow(q.xi.x(), a) * std::pow(q.xi.y(), b) * std::pow(q.xi.z(), c);
  return sum;
}

double on_line(int a) { return a % 2 == 0 ? 2.0 / (a + 1) : 0.0; }

}  // namespace

TEST(Quadrature, MonomialsOnTheCubeAndTheSquare) {
  for (int n = 1; n <= 4; ++n) {
    EXPECT_EQ(gauss_cube(n).size(), static_cast<std::size_t>(n * n * n));
    EXPECT_EQ(gauss_square(n).size(), static_cast<std::size_t>(n * n));
    for (int a = 0; a < 2 * n; ++a)
      for (int b = 0; b < 2 * n; ++b) {
        EXPECT_NEAR(integral(gauss_square(n), a, b, 0), on_line(a) * on_line(b), 1e-14);
        for (int c = 0; c < 2 * n; ++c)
          EXPECT_NEAR(integral(gauss_cube(n), a, b, c), on_line(a) * on_line(b) * on_line(c), 1e-14);
      }
    EXPECT_GT(std::abs(integral(gauss_cube(n), 2 * n, 0, 0) - 4.0 * on_line(2 * n)), 1e-3);
  }
}

TEST(Quadrature, MonomialsOnTheTetrahedron) {
  for (const auto& [points, degree] : {std::pair{1, 1}, std::pair{4, 2}}) {
    const auto rule = gauss_tetrahedron(points);
    ASSERT_EQ(rule.size(), static_cast<std::size_t>(points));
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b)
        for (int c = 0; a + b + c <= degree; ++c)
          EXPECT_NEAR(integral(rule, a, b, c), factorial(a) * factorial(b) * factorial(c) / factorial(a + b + c + 3),
                      1e-16);
    for (const QuadraturePoint& q : rule) {
      EXPECT_GT(q.weight, 0.0);
      EXPECT_GT(q.xi.minCoeff(), 0.0);
      EXPECT_LT(q.xi.sum(), 1.0);
    }
  }
}

TEST(Quadrature, MonomialsOnTheTriangle) {
  for (const auto& [points, degree] : {std::pair{1, 1}, std::pair{3, 2}, std::pair{6, 4}, std::pair{12, 6}}) {
    const auto rule = gauss_triangle(points);
    ASSERT_EQ(rule.size(), static_cast<std::size_t>(points));
    for (int a = 0; a <= degree; ++a)
      for (int b = 0; a + b <= degree; ++b)
        EXPECT_NEAR(integral(rule, a, b, 0), factorial(a) * factorial(b) / factorial(a + b + 2), 1e-14);
    for (const QuadraturePoint& q : rule) EXPECT_EQ(q.xi.z(), 0.0);
  }
}

TEST(Quadrature, RefusesOtherNumbersOfPoints) {
  EXPECT_THROW(gauss_line(0), InputError);
  EXPECT_THROW(gauss_line(5), InputError);
  EXPECT_THROW(gauss_cube(5), InputError);
  EXPECT_THROW(gauss_triangle(4), InputError);
  EXPECT_THROW(gauss_tetrahedron(5), InputError);
}
