#pragma once
/// One step: equilibrium or motion at t + dt by Newton, implicit or IMPL-EX. Nothing is committed before `accept`.

#include <memory>
#include <optional>
#include <vector>

#include "la/newton.hpp"
#include "sim/newmark.hpp"
#include "sim/world.hpp"

namespace berm {

struct StepResult {
  bool converged = false;
  bool stood_still = false;          ///< taken with a residual above the tolerance that no longer fell
  int iterations = 0;                ///< linear solves
  double residual = 0.0;             ///< norm over the norm of the forces [-]
  double extrapolation_error = 0.0;  ///< impl_ex: largest error of a stress over the strength [-]
  double time_error = 0.0;           ///< dynamic: of the time integration [-]
  double steps_a_period = 0.0;       ///< dynamic: 0 if nothing swings [-]
  double at_rest = 0.0;              ///< nothing changed, so nothing was solved: residual that was there [-]
  std::vector<double> residuals;     ///< every norm, relative
  Vec3 where = Vec3::Zero();         ///< not converged: the node at which forces balance least
  double share = 0.0;                ///< not converged: of the norm of the residual that is there [-]
  std::string reason;
};

/// Forces and energies of the state at t_n, of all processes.
struct Balance {
  Reactions reactions;
  std::vector<Vec3> pressure_force;              ///< by case pressure [N]
  double external_work = 0.0;                    ///< since the start [J]
  double damped = 0.0;                           ///< taken by damping forces since the start [J]
  double transferred = 0.0;                      ///< lost between points and grid since the start [J]   [dynamics (17)]
  double kinetic = 0.0, kinetic_at_start = 0.0;  ///< energy of the motion [J]
  double contact_work = 0.0;                     ///< taken by contact and pins since the start: heat, and what springs keep [J]
  double friction_work = 0.0;                    ///< heat of sliding contact, a part of it [J]
};

/// Seconds spent since the start.
struct StepTimes {
  double connectivity = 0.0, response = 0.0, assembly = 0.0, linear = 0.0;
};

/// A number that is equal for equal local nodes and blocks of this process.
std::int64_t pattern_of(const Discretisation& d);

class ImplicitStep {
public:
  explicit ImplicitStep(World& world);

  /// Tries to reach time + dt. The world does not change. Collective.
  StepResult attempt(double dt, Integration integration);
  /// Commits the last successful attempt.
  void accept();
  /// The world has come to its next stage. Collective.
  void begin_stage();
  /// After a restart: only what the stage itself says.
  void set_up_stage();

  const Balance& balance() const { return balance_; }
  /// Whether the state is one of equilibrium, found to the tolerance of an implicit step.
  bool in_equilibrium() const { return in_equilibrium_; }
  /// After a restart: the balance of the saved state, and whether it was one of equilibrium in the stage of that name.
  void restore(const Balance& balance, bool in_equilibrium, const std::string& stage);
  /// The increment of the last step, from which the next one is guessed.
  struct Guess {
    double dt = 0.0;                ///< 0: there is none
    std::vector<double> increment;  ///< three for each node that this process owns
  };
  Guess guess() const;
  /// The guess of a step whose nodes were those of the step that has begun (pattern_of).
  void restore(const Guess& guess);
  /// What the linear solver has kept of earlier steps is left behind: a run that goes on from here knows nothing of it either.
  void renew_solver();
  StepTimes times() const;
  LinearCount linear_count() const;
  /// How linear systems are solved and why; empty before the first step.
  const std::string& solver_choice() const { return newton_->choice(); }
  long unknowns() const { return n_unknowns_; }

private:
  void prepare(Integration integration);
  void lay_out(bool symmetric);
  bool residual(const std::vector<double>& x, std::vector<double>& r);
  void check_motions() const;
  void begin_motion(double dt);
  void accept_motion();
  void prescribe_motion(double dt);
  void forces_at_start(bool begins);
  void start_acceleration();
  void weigh_forces();
  NodalVector internal_force() const;
  std::vector<double> velocity_of_prescribed(double t0, double t1) const;
  void keep_guess();
  bool first_guess(std::vector<double>& x, int& iterations, Integration integration);
  std::vector<double> unknowns_of(const NodalVector& du) const;
  NodalVector no_motion() const;
  NodalVector pressure_at(double time, const NodalVector& du) const;
  /// Pressures count at this time, times this factor.
  double load_time() const { return gauge_ >= 0 ? world_.spec.duration() : t1_; }
  double pressure_factor() const { return gauge_ >= 0 ? load_factor_ : 1.0; }
  NodalVector weight_at(double time) const;
  bool has_weight() const;
  void sum_forces();
  void assemble(const std::vector<double>* prescribed);
  bool linear_predictor(std::vector<double>& x);
  struct Attempt {
    StepLength length;
    int most;               ///< iterations
    double spring = 0.0;    ///< along the slip of what slides, share of the stiffness of contact [-]
  };
  std::vector<Attempt> attempts(const Solver& s) const;
  bool is_fair() const;
  double prescribed_motion() const;
  bool flies_away() const;
  std::string reason_of_flight() const;
  bool nothing_changes() const;
  void find_worst_node(StepResult& result) const;
  NewtonResult find_equilibrium(const std::vector<double>& guess, std::vector<double>& x, double tolerance, double scale, StepResult& result);
  void forget_contact();
  bool take_still(NewtonResult& newton, double bound, std::vector<double>& x);
  NewtonResult solve(std::vector<double>& x, double tolerance, const Attempt& how);
  void scatter(const std::vector<double>& x);
  double gauge_value() const;
  double norm(const NodalVector& f) const;
  double norm(const std::vector<double>& r) const;  ///< of a residual
  double dot(const NodalVector& a, const NodalVector& b) const;
  bool owns_border() const { return gauge_ >= 0 && world_.comm.rank() + 1 == world_.comm.size(); }
  int n_mine() const;

  World& world_;
  int dimension_;
  std::unique_ptr<NewtonSolver> newton_;  ///< of the stage
  LinearCount linear_count_;              ///< of the stages before
  BlockAssembler assembler_;
  LawSettings settings_;

  // connectivity of the last preparation
  long connectivity_ = -1;
  Border border_;
  bool symmetric_ = false;
  bool prepared_ = false;  ///< for the state at t_n

  double t0_ = 0.0, t1_ = 0.0, load_factor_ = 0.0;
  double force_scale_ = 0.0, inertia_scale_ = 0.0;
  long n_unknowns_ = 0;
  NodalVector du_, last_du_, force_, external_, pressure_, weight_, functional_;
  double last_dt_ = 0.0;
  long guess_connectivity_ = -1;             ///< whose nodes last_du_ has
  std::int64_t guess_pattern_ = 0;           ///< of these nodes
  std::string last_stage_;                   ///< of the last step
  bool in_equilibrium_ = false, reaches_equilibrium_ = false;  ///< the state at t_n; that of the last attempt
  std::vector<double> prescribed_;
  std::vector<double> cached_x_, cached_r_;
  std::optional<Newmark> motion_;            ///< of the step; dynamic analyses only
  NodalVector old_internal_, old_external_;  ///< forces at t_n, where the equation of motion asks for them
  bool motion_ready_ = false;                ///< motion_ knows the nodes of the state at t_n
  int gauge_ = -1;
  double gauge_scale_ = 1.0;
  Balance balance_;
  StepTimes times_;
};

}  // namespace berm
