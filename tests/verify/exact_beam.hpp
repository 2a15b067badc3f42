#pragma once
/// The shear-deformable, extensible, geometrically exact beam (Reissner 1972), clamped at one end and loaded by dead
/// vertical forces: shooting on the root moment with the classical Runge-Kutta method. Without its compliances in
/// shear and tension it is Euler's elastica.

#include <cmath>
#include <functional>

namespace berm::verify {

struct ExactBeam {
  double length = 1.0;                                      ///< [m]
  double bending = 1.0;                                     ///< EI, a metre of width [N m]
  double tension_compliance = 0.0, shear_compliance = 0.0;  ///< 1/EA, 1/GA [1/N]
  std::function<double(double)> outer_force;                ///< vertical force on what lies beyond s, upwards [N]

  struct Tip {
    double down, in;  ///< [m]
  };

  Tip tip() const {
    double total = 0.0;  // bounds the root moment
    for (int k = 0; k <= steps; ++k) total = std::max(total, std::abs(outer_force(length * k / steps)));
    double low = -total * length, high = 0.0;
    for (int k = 0; k < 100; ++k) {
      const double middle = 0.5 * (low + high);
      (shoot(middle).moment > 0.0 ? high : low) = middle;
    }
    const State end = shoot(0.5 * (low + high));
    return {-end.y, length - end.x};
  }

private:
  static constexpr int steps = 400;

  struct State {
    double angle, moment, x, y;
    State plus(const State& d, double f) const {
      return {angle + f * d.angle, moment + f * d.moment, x + f * d.x, y + f * d.y};
    }
  };

  State slope(double s, const State& b) const {
    const double F = outer_force(s), n = F * std::sin(b.angle), q = F * std::cos(b.angle);
    const double stretch = 1.0 + n * tension_compliance, shear = q * shear_compliance;
    const double dx = stretch * std::cos(b.angle) - shear * std::sin(b.angle);
    const double dy = stretch * std::sin(b.angle) + shear * std::cos(b.angle);
    return {b.moment / bending, -dx * F, dx, dy};
  }

  State shoot(double root) const {
    State b{0.0, root, 0.0, 0.0};
    const double h = length / steps;
    for (int k = 0; k < steps; ++k) {
      const double s = k * h;
      const State k1 = slope(s, b), k2 = slope(s + h / 2, b.plus(k1, h / 2)), k3 = slope(s + h / 2, b.plus(k2, h / 2)),
                  k4 = slope(s + h, b.plus(k3, h));
      b = b.plus(k1, h / 6).plus(k2, h / 3).plus(k3, h / 3).plus(k4, h / 6);
    }
    return b;
  }
};

}  // namespace berm::verify
