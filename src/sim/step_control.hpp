#pragma once
/// How large the next step is: cut on failure, grow after easy steps.

#include <algorithm>
#include <cmath>

#include "case/case.hpp"

namespace berm {

class StepControl {
public:
  explicit StepControl(const Stage& stage) : StepControl(stage.steps, stage) {}

private:
  StepControl(const Steps& s, const Stage& stage)
      : steps_(s),
        end_(stage.end()),
        time_error_(stage.steps.analysis == Analysis::dynamic ? stage.dynamics.error_tolerance : 0.0),
        nominal_(s.duration / s.count),
        dt_(nominal_),
        min_(nominal_ * (s.adaptive ? s.min_fraction : 1.0)),
        max_(nominal_ * (s.adaptive ? s.max_fraction : 1.0)) {
    dt_ = std::clamp(dt_, min_, max_);
  }

public:
  /// The next step from `time`; the last one ends exactly at the end, and none is left shorter than half a step.
  double next(double time) const {
    const double left = end_ - time;
    return left < 1.5 * dt_ ? (left > dt_ * (1.0 + 1e-9) ? 0.5 * left : left) : dt_;
  }
  bool finished(double time) const { return time >= end_ * (1.0 - 1e-12); }
  bool can_cut() const { return dt_ > min_ * (1.0 + 1e-9); }

  double size() const { return dt_; }
  /// After a restart.
  void restore(double dt) { dt_ = std::clamp(dt, min_, max_); }

  int bridge = 0;  ///< IMPL-EX steps that are left of a bridge over a snap-back

  void cut() { dt_ = std::max(min_, 0.5 * dt_); }

  /// After an implicit step. time_error: of the integration of motion, which falls with the square of the step.
  void after_implicit(int iterations, double time_error) {
    if (!steps_.adaptive) return;
    double factor = iterations < steps_.easy_iterations ? 1.5 : 1.0;
    if (time_error_ > 0.0 && time_error > 0.0)
      factor = std::min(factor, std::max(0.5, 0.9 * std::sqrt(time_error_ / time_error)));
    dt_ = std::clamp(factor * dt_, min_, max_);
  }
  /// Errors of the integration of motion are rejected beyond this many tolerances.
  static constexpr double reject_factor = 4.0;
  bool reject_time_error(double error) const {
    return steps_.adaptive && can_cut() && time_error_ > 0.0 && error > reject_factor * time_error_;
  }

  /// After an IMPL-EX step that has not been accepted: its error was beyond the tolerance.   [damage (11a)]
  bool reject_impl_ex(double error) const { return steps_.adaptive && can_cut() && error > steps_.error_tolerance; }
  void cut_impl_ex(double error) {
    dt_ = std::max(min_, std::clamp(aimed_at * steps_.error_tolerance / error, 0.1, 0.5) * dt_);
  }
  /// The error grows with the step where points begin to soften, and with its square later: what is aimed at leaves room.
  static constexpr double aimed_at = 0.7;
  void after_impl_ex(double error) {
    if (!steps_.adaptive) return;
    const double factor = error > 0.0 ? std::clamp(aimed_at * steps_.error_tolerance / error, 0.5, 1.3) : 1.3;
    dt_ = std::clamp(factor * dt_, min_, max_);
  }

private:
  Steps steps_;
  double end_, time_error_;  ///< time_error_: aimed at; 0: any
  double nominal_, dt_, min_, max_;
};

}  // namespace berm
