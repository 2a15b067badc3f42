#pragma once
/// A load or a motion as a function of time and place, as a case file writes it.

#include <array>
#include <memory>
#include <string>

#include "base/tensor.hpp"

namespace berm {

/// A displacement at t = 0 that is no jump but rounding [m].
inline constexpr double no_jump = 1e-12;

/// A number, reached linearly from 0 at the start and then held; or an expression of t [s] and x, y, z [m], whose value
/// is in SI units: "9.81*min(t/0.5, 1)". The language of expressions is muParser's: + - * / ^, comparisons,
/// a ? b : c, sin, cos, exp, sqrt, abs, min, max, ..., pi.
class TimeFunction {
public:
  TimeFunction(double value = 0.0) : value_(value) {}
  /// Throws std::invalid_argument with what is wrong and where in the text. `key` is how messages call it: "uy" in [boundary.top].
  explicit TimeFunction(const std::string& expression, std::string key = "an expression");

  /// At that time [s] and place [m]. Throws RunError if the expression has no finite value there.
  double at(double t, const Vec3& x = Vec3::Zero()) const;
  /// Change from t0 to t1. Everything begins with 0: what an expression is at t = 0 already comes with the first step.
  double step(double t0, double t1, const Vec3& x = Vec3::Zero()) const { return at(t1, x) - (t0 > 0.0 ? at(t0, x) : 0.0); }
  /// Places are given to at() less this one.
  void set_origin(const Vec3& x) { origin_ = x; }
  /// When a number is reached [s]; 0: it holds from the start.
  void set_end(double end) { end_ = end; }

  bool is_number() const { return !expression_; }
  /// The number; only if is_number().
  double number() const { return value_; }
  bool is_zero() const { return is_number() && value_ == 0.0; }
  bool depends_on_place() const;
  /// Of the expression; empty for a number.
  const std::string& text() const;

  friend bool operator==(const TimeFunction& a, const TimeFunction& b) {
    return a.value_ == b.value_ && a.end_ == b.end_ && a.text() == b.text();
  }

private:
  struct Expression;
  double value_ = 0.0, end_ = 1.0;
  Vec3 origin_ = Vec3::Zero();
  std::shared_ptr<const Expression> expression_;
};

/// One function a direction.
struct VectorFunction {
  std::array<TimeFunction, 3> component;

  Vec3 at(double t, const Vec3& x = Vec3::Zero()) const {
    return {component[0].at(t, x), component[1].at(t, x), component[2].at(t, x)};
  }
  Vec3 step(double t0, double t1) const {
    return {component[0].step(t0, t1), component[1].step(t0, t1), component[2].step(t0, t1)};
  }
  bool depends_on_place() const {
    return component[0].depends_on_place() || component[1].depends_on_place() || component[2].depends_on_place();
  }
  bool is_zero() const { return component[0].is_zero() && component[1].is_zero() && component[2].is_zero(); }
};

}  // namespace berm
