#include "shape/quadrature.hpp"

#include <cmath>

#include "base/error.hpp"

namespace berm {

std::vector<std::pair<double, double>> gauss_line(int n) {
  switch (n) {
    case 1:
      return {{0.0, 2.0}};
    case 2: {
      const double a = 1.0 / std::sqrt(3.0);
      return {{-a, 1.0}, {a, 1.0}};
    }
    case 3: {
      const double a = std::sqrt(0.6);
      return {{-a, 5.0 / 9.0}, {0.0, 8.0 / 9.0}, {a, 5.0 / 9.0}};
    }
    case 4: {
      const double s = 2.0 / 7.0 * std::sqrt(1.2);
      const double a = std::sqrt(3.0 / 7.0 - s), b = std::sqrt(3.0 / 7.0 + s);
      const double wa = (18.0 + std::sqrt(30.0)) / 36.0, wb = (18.0 - std::sqrt(30.0)) / 36.0;
      return {{-b, wb}, {-a, wa}, {a, wa}, {b, wb}};
    }
    default:
      throw InputError("a Gauss rule has 1 to 4 points a direction, not " + std::to_string(n));
  }
}

std::vector<QuadraturePoint> gauss_square(int n) {
  std::vector<QuadraturePoint> rule;
  for (const auto& [y, wy] : gauss_line(n))
    for (const auto& [x, wx] : gauss_line(n)) rule.push_back({Vec3(x, y, 0.0), wx * wy});
  return rule;
}

std::vector<QuadraturePoint> gauss_cube(int n) {
  std::vector<QuadraturePoint> rule;
  for (const auto& [z, wz] : gauss_line(n))
    for (const QuadraturePoint& q : gauss_square(n)) rule.push_back({q.xi + z * Vec3::UnitZ(), q.weight * wz});
  return rule;
}

namespace {

void add_orbit3(std::vector<QuadraturePoint>& rule, double a, double weight) {
  const double b = 1.0 - 2.0 * a;
  for (const Vec2& xi : {Vec2(a, a), Vec2(b, a), Vec2(a, b)}) rule.push_back({in_space(xi), 0.5 * weight});
}

void add_orbit6(std::vector<QuadraturePoint>& rule, double a, double b, double weight) {
  const double c = 1.0 - a - b;
  for (const Vec2& xi : {Vec2(a, b), Vec2(b, a), Vec2(a, c), Vec2(c, a), Vec2(b, c), Vec2(c, b)})
    rule.push_back({in_space(xi), 0.5 * weight});
}

}  // namespace

std::vector<QuadraturePoint> gauss_triangle(int points) {
  std::vector<QuadraturePoint> rule;
  switch (points) {
    case 1:
      return {{Vec3(1.0 / 3.0, 1.0 / 3.0, 0.0), 0.5}};
    case 3:
      add_orbit3(rule, 1.0 / 6.0, 1.0 / 3.0);
      return rule;
    case 6:
      add_orbit3(rule, 0.445948490915965, 0.223381589678011);
      add_orbit3(rule, 0.091576213509771, 0.109951743655322);
      return rule;
    case 12:
      add_orbit3(rule, 0.249286745170910, 0.116786275726379);
      add_orbit3(rule, 0.063089014491502, 0.050844906370207);
      add_orbit6(rule, 0.310352451033785, 0.053145049844816, 0.082851075618374);
      return rule;
    default:
      throw InputError("a triangle takes 1, 3, 6 or 12 points, not " + std::to_string(points));
  }
}

std::vector<QuadraturePoint> gauss_tetrahedron(int points) {
  if (points == 1) return {{Vec3::Constant(0.25), 1.0 / 6.0}};
  if (points != 4) throw InputError("a tetrahedron takes 1 or 4 points, not " + std::to_string(points));
  const double a = (5.0 - std::sqrt(5.0)) / 20.0, b = 1.0 - 3.0 * a;
  std::vector<QuadraturePoint> rule = {{Vec3::Constant(a), 1.0 / 24.0}};
  for (int i = 0; i < 3; ++i) rule.push_back({Vec3::Constant(a) + (b - a) * Vec3::Unit(i), 1.0 / 24.0});
  return rule;
}

}  // namespace berm
