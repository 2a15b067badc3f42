#include "sim/run.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <ctime>
#include <utility>

#include "base/error.hpp"
#include "base/shell_word.hpp"
#include "base/system_file.hpp"
#include "bc/case_lookup.hpp"
#include "case/differences.hpp"
#include "io/log.hpp"
#include "io/output_folder.hpp"
#include "law/kinds.hpp"
#include "sim/advice.hpp"
#include "sim/checkpoint.hpp"
#include "sim/preflight.hpp"
#include "sim/recorder.hpp"
#include "sim/stage_doubts.hpp"
#include "sim/step_control.hpp"
#include "sim/watch.hpp"

namespace berm {
namespace {

/// Set by Ctrl-C, SIGTERM, SIGHUP, SIGUSR1 and SIGXCPU: the run ends after the step, with everything written. A second one ends it as it
/// is, but of SIGXCPU (ulimit -St): that comes every second. mpiexec passes SIGUSR1 on at once, SIGTERM a second before it kills.
volatile std::sig_atomic_t interrupted = 0;
void interrupt(int number) {
  interrupted = 1;
  if (number != SIGXCPU) std::signal(number, SIG_DFL);
}

constexpr const char* checkpoint_name = "checkpoint.h5";

/// Options of PETSc hold for the whole process: a run leaves none behind.
struct OptionsOfPetsc {
  explicit OptionsOfPetsc(const std::string& given) : text(given) { start_petsc(text); }
  ~OptionsOfPetsc() { take_back_options(text); }
  OptionsOfPetsc(const OptionsOfPetsc&) = delete;
  OptionsOfPetsc& operator=(const OptionsOfPetsc&) = delete;
  const std::string text;
};

class Run {
public:
  Run(std::unique_ptr<World> world, const RunOptions& options, const FolderLock& lock, const Comm& comm)
      : start_(std::chrono::steady_clock::now()),
        comm_(comm),
        folder_(options.folder),
        lock_(lock),
        origin_(options.origin),
        open_log_(open_log(options, comm)),
        log_(*open_log_),
        world_(std::move(world)),
        step_(*world_),
        recorder_(*world_, step_, options.folder),
        control_(world_->present_stage()),
        watch_(*world_, [this](const std::string& text) { log_.warning(text); }),
        progress_(log_, start_),
        saved_(start_) {
    // For checkpoints; as the files are now, whatever becomes of them during the run.
    world_->file_contents = comm_.broadcast(comm_.is_root() ? contents_of_files(world_->spec.resolved) : std::string());
    log_.info(describe(*world_));
    for (const std::string& warning : world_->warnings) log_.warning(warning);
    if (options.restart.empty()) {
      write_case();
      recorder_.start();
      return;
    }
    const std::vector<Difference> changed = load_checkpoint(options.restart, *world_, step_, recorder_, control_);
    write_case();
    watch_.resume(recorder_.watched(), step_.balance().reactions);
    log_.info(
        fmt::format("  goes on after step {}, time {:.6g}, of {}", recorder_.steps(), world_->time, options.restart));
    for (const Difference& difference : changed) {
      if (difference.of_a_motion())
        log_.warning(difference.text() + ": only what it changes by from here on moves anything, what it would have moved until now is not made up for");
      else
        log_.info("  changed since       " + difference.text());
    }
  }

  void go() {
    try {
      do {
        while (!control_.finished(world_->time)) {
          advance();
          save_if_due();
        }
      } while (next_stage());
    } catch (const InputError& error) {
      end_early(error);
      throw;
    } catch (const RunError& error) {
      end_early(error);
      throw;
    } catch (const std::exception& error) {
      if (comm_.size() == 1) end_early(error);  // else the other processes may know nothing of it: main() ends them
      throw;
    }
    watch_.look_last();
    recorder_.note(watch_.seen);
    check_folder();
    recorder_.finish("done", "", seconds(), origin_);
    report_end();
  }

private:
  static std::unique_ptr<Log> open_log(const RunOptions& options, const Comm& comm) {
    std::unique_ptr<Log> log;
    comm.agree([&] {
      LogOptions here{"", true, nullptr, false, false};
      if (comm.is_root())
        here = {(options.folder / "log.txt").string(), options.quiet, stdout, options.is_interactive,
                !options.restart.empty()};
      log = std::make_unique<Log>(here);
      log->detail(head(options.origin, comm.size()));
    });
    return log;
  }

  void write_case() const {
    comm_.agree([&] {
      if (comm_.is_root()) replace_file((folder_ / "case.toml").string(), world_->spec.resolved);
    });
  }

  /// Who runs, where, when and with what words.
  static std::string head(const Origin& origin, int processes) {
    char date[32] = "";
    const std::time_t now = std::time(nullptr);
    std::strftime(date, sizeof date, "%Y-%m-%d %H:%M:%S", std::localtime(&now));
    std::string text = fmt::format("berm {}{} on {}, {} process{}, {}", origin.version,
                                   origin.commit.empty() ? "" : ", commit " + origin.commit, origin.host, processes,
                                   processes > 1 ? "es" : "", date);
    return origin.command.empty() ? text : text + "\ncommand: " + origin.command;
  }

  /// Nothing is written to a folder that is not the run's own.
  bool has_folder() const { return !comm_.any(!lock_.has_folder()); }
  void check_folder() const {
    if (!has_folder())
      throw RunError(fmt::format("{}: something else has the name of the output folder now (moved, removed or replaced during the run); "
                                 "what was written is where the folder is, and --restart goes on from a checkpoint in it",
                                 folder_.string()));
  }

  /// What cannot be written on a full disk must not hide why the run ends.
  void end_early(const std::exception& error) {
    log_.detail(error.what());
    tell_unused_options();
    if (!has_folder()) return;
    try {
      recorder_.finish(comm_.any(interrupted) ? "stopped" : "failed", error.what(), seconds(), origin_);
      tell_where();
    } catch (const RunError& later) {
      log_.detail(later.what());
    }
  }

  void tell_where() {
    const std::string folder = shell_word(folder_.string());
    log_.info(fmt::format("results up to time {:.6g} are in {}: berm report {} draws them, ParaView opens {}", world_->time,
                          folder, folder, shell_word((folder_ / "points.pvd").string())));
  }

  const Solver& solver() const { return world_->present_stage().solver; }

  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

  void save() {
    check_folder();
    recorder_.before_checkpoint();
    save_checkpoint((folder_ / checkpoint_name).string(), *world_, step_, recorder_, control_);
    step_.renew_solver();
    saved_ = std::chrono::steady_clock::now();
    log_.detail(fmt::format("checkpoint at time {:.9g}", world_->time));
  }

  void save_if_due() {
    const Checkpoint& c = world_->spec.checkpoint;
    const double minutes = std::chrono::duration<double>(std::chrono::steady_clock::now() - saved_).count() / 60.0;
    const bool by_steps = c.every_steps > 0 && recorder_.steps() % c.every_steps == 0;
    const bool by_time = comm_.broadcast(int(c.every_minutes > 0.0 && minutes >= c.every_minutes)) != 0;
    if (by_steps || by_time) save();
  }

  /// A signal to any process.
  [[noreturn]] void stop() {
    save();
    throw RunError(fmt::format("stopped by a signal at time {:.6g}; go on with the same command and --restart {}", world_->time,
                               shell_word((folder_ / checkpoint_name).string())));
  }

  /// False at the end of the last one.
  bool next_stage() {
    if (world_->stage + 1 == world_->spec.stages.size()) return false;
    ++world_->stage;
    log_.info(fmt::format("stage {} at time {:.6g}", world_->present_stage().name, world_->time));
    step_.begin_stage();
    if (!world_->step_begun) world_->begin_step();
    for (const std::string& doubt : doubts_of_stage(*world_)) log_.warning(doubt);
    control_ = StepControl(world_->present_stage());
    return true;
  }

  /// One accepted step: the step size is cut until the attempt converges.
  void advance() {
    for (;;) {
      if (comm_.any(interrupted)) stop();
      const double dt = control_.next(world_->time);
      const Integration integration = control_.bridge > 0 ? Integration::impl_ex : solver().integration;
      const StepResult result = step_.attempt(dt, integration);
      log_choice();
      log_attempt(dt, result);
      if (!result.converged) {
        fail(dt, result);
        continue;
      }
      if (is_too_inaccurate(result, integration)) {
        recorder_.count_cut();
        continue;
      }
      check_folder();
      step_.accept();
      if (result.stood_still) {
        ++n_still_;
        worst_still_ = std::max(worst_still_, result.residual);
      }
      watch(result);
      if (result.steps_a_period > 0.0) steps_a_period_.push_back(result.steps_a_period);
      recorder_.record(result, integration);
      if (integration == Integration::implicit)
        control_.after_implicit(result.iterations, result.time_error);
      else
        control_.after_impl_ex(result.extrapolation_error);
      if (control_.bridge > 0 && --control_.bridge == 0) log_.info("back to implicit steps");
      progress_.update({recorder_.steps(), planned_share(), recorder_.load(), result.iterations, result.residual, world_->n_points(),
                        cracks_may_come()});
      return;
    }
  }

  /// Then steps are cut, by how much nobody knows.
  bool cracks_may_come() const { return any_law(world_->spec, is_damage) && world_->present_stage().steps.adaptive; }

  /// Of the steps of all stages, those that are behind: stages need not have steps of the same size.
  double planned_share() const {
    double behind = 0.0, all = 0.0;
    for (const Stage& s : world_->spec.stages) {
      behind += s.steps.count * std::clamp((world_->time - s.begin) / s.steps.duration, 0.0, 1.0);
      all += s.steps.count;
    }
    return behind / all;
  }

  /// What has been found when it ends a run is in its summary too.
  void watch(const StepResult& result) {
    if (result.at_rest > told_at_rest && !std::exchange(rest_told_, true))
      log_.info(fmt::format("nothing changes at time {:.6g}: nothing moves; forces are out of balance by {:.1e} since points have moved on the grid",
                            world_->time, result.at_rest));
    try {
      watch_.look(step_, recorder_.steps() + 1);
    } catch (...) {
      recorder_.note(watch_.seen);
      throw;
    }
    recorder_.note(watch_.seen);
  }

  /// True if the step is not good enough and has been cut.
  bool is_too_inaccurate(const StepResult& result, Integration integration) {
    const bool extrapolated = integration == Integration::impl_ex;
    if (extrapolated ? !control_.reject_impl_ex(result.extrapolation_error) : !control_.reject_time_error(result.time_error))
      return false;
    extrapolated ? control_.cut_impl_ex(result.extrapolation_error) : control_.cut();
    return true;
  }

  /// A step that found no equilibrium: cut it, or bridge a snap-back, or say exactly what happened.
  void fail(double dt, const StepResult& result) {
    recorder_.count_cut();
    if (control_.can_cut()) {
      control_.cut();
      return;
    }
    if (solver().integration == Integration::implicit && control_.bridge == 0 &&
        solver().snap_back == Solver::SnapBack::impl_ex) {
      control_.bridge = bridge_steps;
      log_.warning(fmt::format("no equilibrium next to time {:.6g} with the smallest step: {} IMPL-EX steps follow",
                               world_->time, bridge_steps));
      return;
    }
    const std::string where =
        result.share > 0.0 ? fmt::format("; forces balance least at {}: {:.0f} % of it", place_text(world_->spec, result.where), 100.0 * result.share)
                           : "";
    std::vector<std::string> slipping;
    if (world_->step_begun) slipping = world_->boundary->slipping();
    throw RunError(fmt::format("no equilibrium found at time {:.9g} (step {:.3g}, the smallest allowed; residual {:.3g}, {}{}). {}{}{}",
                               world_->time, dt, result.residual, result.reason.empty() ? "no reason given" : result.reason, where,
                               fmt::join(slipping, ", and "), slipping.empty() ? "" : ". ",
                               advice_on_equilibrium(world_->spec, world_->present_stage(), !slipping.empty())));
  }

  /// The linear solver and why, whenever another one is taken; the number of unknowns changes often.
  void log_choice() {
    const std::string kind = step_.solver_choice().substr(0, step_.solver_choice().find(" ("));
    if (kind == choice_) return;
    choice_ = kind;
    log_.info("  linear solver     " + step_.solver_choice());
  }

  void log_attempt(double dt, const StepResult& result) {
    std::string text =
        fmt::format("time {:.9g} + {:.3g}: {} after {} linear solves, residuals", world_->time, dt,
                    result.converged ? "converged" : "failed (" + result.reason + ")", result.iterations);
    for (double r : result.residuals) text += fmt::format(" {:.3e}", r);
    log_.detail(text);
  }

  void report_end() {
    const auto metrics = recorder_.metrics();
    if (!comm_.is_root()) return;
    for (const auto& [name, value] : metrics) log_.info(fmt::format("  {:<28} {:.6g}", name, value));
    warn_about(metrics);
    if (n_still_ > 0)
      log_.info(fmt::format("{} steps ended where the residual no longer fell, at most {:.1e} of the forces: states of "
                            "contact or yielding that come and go",
                            n_still_, worst_still_));
    tell_long_steps();
    if (watch_.seen.columns > 0.0)
      log_.info("cracks              of a law with a crack band: their path follows the lines of the grid. Before trusting it, turn the grid "
                "(grid.angle, mesh.size) and compare");
    const StepTimes t = step_.times();
    log_.info(
        fmt::format("{} steps in {}: connectivity {:.1f} s, laws {:.1f} s, assembly {:.1f} s, linear solver {:.1f} s",
                    recorder_.steps(), duration_text(seconds()), t.connectivity, t.response, t.assembly, t.linear));
    const LinearCount n = step_.linear_count();
    if (n.iterations > n.solves)
      log_.info(fmt::format("{} linear systems, {:.1f} iterations each, {} solved directly after all", n.solves,
                            double(n.iterations) / n.solves, n.fallbacks));
    tell_unused_options();
    tell_where();
  }

  /// A step that is long beside the period of the motion damps it or shifts its phase.   [dynamics (16)]
  void tell_long_steps() {
    constexpr std::size_t enough = 5;
    constexpr double few = 10.0, good = 20.0;  // steps a period
    if (steps_a_period_.size() < enough) return;
    const auto middle = steps_a_period_.begin() + steps_a_period_.size() / 2;
    std::nth_element(steps_a_period_.begin(), middle, steps_a_period_.end());
    const double a_period = *middle;
    if (a_period < few)
      log_.info(fmt::format("steps in motion      are long: half of them have less than {:.2g} a period of what moves, which damps it or shifts its phase. Where that "
                            "matters take {:.2g} times as many ({}), or [dynamics] error_tolerance = 0.005",
                            a_period, good / a_period, key_of_steps(world_->spec, "count")));
  }

  void tell_unused_options() {
    const std::vector<std::string> unused = take_back_options(world_->spec.solver.petsc);
    if (!unused.empty())
      log_.warning(fmt::format("{}: \"petsc\" in [solver]: nothing asked PETSc for {} (misspelt, or not for the solver that was taken)",
                               world_->spec.petsc_place, fmt::join(unused, ", ")));
  }

  void warn_about(const std::vector<std::pair<std::string, double>>& metrics) {
    constexpr double balanced = 0.05, coarse_gap = 0.1;
    double tolerance = 0.0;
    for (const Stage& stage : world_->spec.stages) tolerance = std::max(tolerance, stage.steps.error_tolerance);
    EnergyLoss loss = recorder_.energy_loss();
    loss.pressure_lost = watch_.has_told("pressure");
    for (const auto& [name, value] : metrics) loss.extrapolated |= name == "extrapolation_error [-]" && value > tolerance;
    for (const auto& [name, value] : metrics) {
      if (name == "energy_error [-]" && value > balanced)
        log_.warning(fmt::format("the energy balance is off by {:.2g} % of the largest energy: {}", 100.0 * value,
                                 advice_on_energy(world_->spec, loss)));
      if (name == "extrapolation_error [-]" && value > tolerance)
        log_.warning(
            fmt::format("IMPL-EX: a stress was wrong by {:.2g} of the strength in a step, where {} is "
                        "{:.2g}, and the step could not be cut: {}",
                        value, key_of_steps(world_->spec, "error_tolerance"), tolerance, advice_on_extrapolation(world_->spec, value)));
      if (const double share = value / world_->discretisation->cell_size();
          name == "contact_gap_scatter [m]" && share > coarse_gap)
        log_.warning(
            fmt::format("contact between deformable bodies: the gap at a node was a mean of places that differ by {:.2g} of "
                        "a cell, so bodies touched that much early or late: make the cells smaller",
                        share));
      if (name == "peak_load [N]" && value <= 0.0 && !world_->spec.output.nominal.load.empty())
        log_.warning("the nominal load never becomes positive: check output.nominal.direction");
    }
  }

  /// Length of an IMPL-EX bridge over a snap-back, in steps, before implicit steps are tried again.
  static constexpr int bridge_steps = 50;
  static constexpr double told_at_rest = 1e-6;

  std::chrono::steady_clock::time_point start_;
  Comm comm_;
  std::filesystem::path folder_;
  const FolderLock& lock_;
  Origin origin_;
  std::unique_ptr<Log> open_log_;
  Log& log_;
  std::unique_ptr<World> world_;
  ImplicitStep step_;
  Recorder recorder_;
  StepControl control_;
  Watch watch_;
  Progress progress_;
  std::chrono::steady_clock::time_point saved_;  ///< last checkpoint
  int n_still_ = 0;                              ///< steps that stood still
  double worst_still_ = 0.0;                     ///< their largest residual
  std::vector<double> steps_a_period_;           ///< in motion
  bool rest_told_ = false;
  std::string choice_;                           ///< of the linear solver, as last logged
};

/// Whether the results in the output folder are those of the run that goes on.
bool goes_on_there(const RunOptions& options) {
  std::error_code error;
  return !options.restart.empty() && std::filesystem::equivalent(std::filesystem::absolute(options.restart).parent_path(), options.folder, error);
}

}  // namespace

/// A session that ends takes its runs along (SIGHUP), unless nohup said otherwise.
void catch_signals() {
  for (const int number : {SIGINT, SIGTERM, SIGUSR1, SIGHUP, SIGXCPU})
    if (std::signal(number, interrupt) == SIG_IGN && number == SIGHUP) std::signal(number, SIG_IGN);
}

void run_case(Case spec, const RunOptions& given) {
  const OptionsOfPetsc petsc(spec.solver.petsc);
  if (!interrupted) catch_signals();
  const Comm comm = Comm::world();
  comm.barrier();
  if (given.listens && comm.is_root()) given.listens();
  RunOptions options = given;
  options.origin.host = host_name();
  FolderLock lock;
  comm.agree([&] {
    if (!comm.is_root()) return;
    std::error_code error;
    std::filesystem::create_directories(options.folder, error);
    if (error)
      throw InputError(
          fmt::format("{}: cannot create the output folder: {}", options.folder.string(), error.message()));
    lock = FolderLock(options.folder);
    refuse_foreign(options.folder);
    for (const ReferenceCurve& curve : spec.output.references)
      if (std::filesystem::equivalent(curve.file, options.folder / "history.csv", error))
        throw InputError(fmt::format("{}: holds the reference curve {}, which the run would replace: choose another folder with --out",
                                     options.folder.string(), curve.file));
    if (!options.replace_finished && !goes_on_there(options)) refuse_finished(options.folder);
  });
  // What is there is replaced by a case that is right.
  std::unique_ptr<World> world = build_world(std::move(spec), comm);
  refuse_free_bodies(*world);
  comm.agree([&] {
    if (comm.is_root() && options.restart.empty()) remove_old_results(options.folder);
  });
  Run run(std::move(world), options, lock, comm);
  run.go();
}

}  // namespace berm
