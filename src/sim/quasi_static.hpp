#pragma once
/// One quasi-static step: equilibrium at t + dt by Newton, implicit or IMPL-EX. Nothing is committed before `accept`.

#include <vector>

#include "la/newton.hpp"
#include "sim/world.hpp"

namespace berm {

struct StepResult {
  bool converged = false;
  int iterations = 0;                ///< linear solves
  double residual = 0.0;             ///< norm over the norm of the forces [-]
  double extrapolation_error = 0.0;  ///< impl_ex: largest |damage used - damage| [-]
  std::vector<double> residuals;     ///< every norm, relative
  std::string reason;
};

/// Forces and energies of the state at t_n.
struct Balance {
  std::vector<Vec2> rigid_force;     ///< on the deformable bodies, by case body; zero for deformable ones [N]
  std::vector<Vec2> boundary_force;  ///< by case boundary [N]
  std::vector<Vec2> pressure_force;  ///< by case pressure [N]
  double external_work = 0.0;        ///< since the start [J]
};

/// Seconds spent since the start.
struct StepTimes {
  double connectivity = 0.0, response = 0.0, assembly = 0.0, linear = 0.0;
};

class QuasiStaticStep {
public:
  explicit QuasiStaticStep(World& world);

  /// Tries to reach time + dt. The world does not change.
  StepResult attempt(double dt, Integration integration);
  /// Commits the last successful attempt.
  void accept();

  const Balance& balance() const { return balance_; }
  StepTimes times() const;
  int unknowns() const { return n_unknowns_; }

private:
  void prepare(Integration integration);
  bool residual(const std::vector<double>& x, std::vector<double>& r, bool tangent);
  void assemble(const std::vector<double>* prescribed);
  bool linear_predictor(std::vector<double>& x);
  NewtonResult solve(std::vector<double>& x, double tolerance, bool line_search);
  void scatter(const std::vector<double>& x);
  double gauge_value() const;

  World& world_;
  NewtonSolver newton_;
  BlockAssembler assembler_;
  LawSettings settings_;

  // connectivity of the last preparation
  Blocks blocks_;
  std::vector<int> equation_;
  Border border_;
  bool symmetric_ = false;
  bool prepared_ = false;  ///< for the state at t_n

  double t0_ = 0.0, t1_ = 0.0, load_factor_ = 0.0;
  double force_scale_ = 0.0;
  int n_unknowns_ = 0;
  NodalVector du_, last_du_, force_, external_, pressure_;
  double last_dt_ = 0.0;
  std::vector<double> prescribed_;
  std::vector<double> cached_x_, cached_r_;
  int gauge_ = -1;
  double gauge_scale_ = 1.0;
  Balance balance_;
  StepTimes times_;
};

}  // namespace berm
