#pragma once
/// How large the next step is: cut on failure, grow after easy steps.

#include <algorithm>

#include "case/case.hpp"

namespace berm {

class StepControl {
public:
  explicit StepControl(const Steps& s)
      : steps_(s),
        nominal_(s.duration / s.count),
        dt_(nominal_),
        min_(nominal_ * (s.adaptive ? s.min_fraction : 1.0)),
        max_(nominal_ * (s.adaptive ? s.max_fraction : 1.0)) {
    dt_ = std::clamp(dt_, min_, max_);
  }

  /// The next step from `time`; the last one ends exactly at the end, and none is left shorter than half a step.
  double next(double time) const {
    const double left = steps_.duration - time;
    return left < 1.5 * dt_ ? (left > dt_ * (1.0 + 1e-9) ? 0.5 * left : left) : dt_;
  }
  bool finished(double time) const { return time >= steps_.duration * (1.0 - 1e-12); }
  bool can_cut() const { return dt_ > min_ * (1.0 + 1e-9); }

  double size() const { return dt_; }
  /// After a restart.
  void restore(double dt) { dt_ = std::clamp(dt, min_, max_); }

  int bridge = 0;  ///< IMPL-EX steps that are left of a bridge over a snap-back

  void cut() { dt_ = std::max(min_, 0.5 * dt_); }

  /// After an implicit step.
  void after_implicit(int iterations) {
    if (!steps_.adaptive) return;
    if (iterations < steps_.easy_iterations) dt_ = std::min(max_, 1.5 * dt_);
  }

  /// An IMPL-EX step whose error is more than this many tolerances is tried again with half the size, if it can be.
  static constexpr double reject_factor = 4.0;
  bool reject_impl_ex(double error) const {
    return steps_.adaptive && can_cut() && error > reject_factor * steps_.error_tolerance;
  }
  void after_impl_ex(double error) {
    if (!steps_.adaptive) return;
    const double factor = error > 0.0 ? std::clamp(steps_.error_tolerance / error, 0.5, 1.3) : 1.3;
    dt_ = std::clamp(factor * dt_, min_, max_);
  }

private:
  Steps steps_;
  double nominal_, dt_, min_, max_;
};

}  // namespace berm
