#pragma once
/// Newton's method for one unknown that cannot leave an interval with a change of sign.

#include <cmath>

namespace berm {

/// Value and slope of a function.
struct Sample {
  double value, slope;
};

/// A root of f between low and high, where f has opposite signs (or is zero), from the guess x. A Newton step of 1e-10
/// is the last one: its error is the square of that.
template <class F>
double bracketed_newton(F&& f, double low, double high, double x) {
  constexpr int max_iterations = 200, newton_iterations = 40;
  const bool rising = f(low).value <= 0.0;
  for (int i = 0; i < max_iterations; ++i) {
    const Sample s = f(x);
    if (s.value == 0.0) return x;
    ((s.value < 0.0) == rising ? low : high) = x;
    double next = x - s.value / s.slope;
    if (std::abs(next - x) <= 1e-10 * std::abs(x)) return next;
    const double left = std::fmin(low, high), right = std::fmax(low, high);
    if (!(next > left && next < right) || i >= newton_iterations) next = 0.5 * (low + high);
    if (next == left || next == right) return next;
    x = next;
  }
  return x;
}

}  // namespace berm
