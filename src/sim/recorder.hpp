#pragma once
/// What a run leaves behind: history rows, VTK frames, peak values and metrics (docs/output.md).
///
/// Every process has one. History, lists of frames and the summary come from process 0; every process writes its piece of
/// a frame. All functions but those marked const are collective, and so is metrics().

#include <filesystem>
#include <memory>
#include <optional>

#include "io/history.hpp"
#include "io/summary.hpp"
#include "io/vtu.hpp"
#include "sim/implicit_step.hpp"
#include "sim/advice.hpp"
#include "sim/local_fit.hpp"
#include "sim/watch.hpp"

namespace berm {

/// What has to outlive the process for a run to go on.
struct RecorderState {
  std::vector<double> rows;  ///< of the history so far
  int columns = 0, steps = 0, cut_steps = 0, frame = 0;
  long newton_iterations = 0;
  double next_frame = 0.0, highest = 0.0, gap_scatter = 0.0;
  bool peak_pending = false;
  std::vector<double> watched;                              ///< Watched
  std::vector<double> quality;                              ///< load, noise, error, load, ...
  std::vector<std::pair<double, std::string>> frames;  ///< entries of points.pvd
};

class Recorder {
public:
  /// Writes nothing yet.
  Recorder(const World& world, const ImplicitStep& step, const std::filesystem::path& folder);

  /// The unloaded state: first row, first frame.
  void start();
  /// In place of start(): goes on after a saved state, which world and step already have.
  void resume(const RecorderState& state);
  RecorderState state() const;
  /// A state kept for the frame of the peak would be lost with the process: it is written, unless it is the present one.
  void before_checkpoint();

  /// After every accepted step.
  void record(const StepResult& result, Integration integration);
  void count_cut() { ++cut_steps_; }
  /// What has been seen beside the equations, for the metrics.
  void note(const Watched& watched) { watched_ = watched; }
  const Watched& watched() const { return watched_; }
  /// Writes the last frame and summary.json. Status as in Summary.
  void finish(const std::string& status, const std::string& reason, double wall_seconds, const Origin& origin);

  int steps() const { return steps_; }
  double load() const { return row_load_; }
  std::vector<std::pair<std::string, double>> metrics() const;
  EnergyLoss energy_loss() const;

private:
  /// Positions in the standard columns of the history (io/history.cpp).
  static constexpr int displacement_column = 2, load_column = 3, work_column = 8, energy_error_column = 11,
                       error_column = 14;

  struct NamedProbe {
    Probe spec;
    std::vector<std::pair<std::int64_t, double>> weight_of_point;  ///< by point id
  };
  void fit_probes();
  /// Nominal load and displacement of the present state.
  Vec3 nominal_force() const;
  double nominal_displacement() const;
  std::vector<double> probe_values();
  double stress_noise() const;
  double stored_energy() const;
  double dissipated_energy() const;
  double energy_now(double stored, double dissipated) const;
  double energy_error(double stored, double dissipated) const;
  bool energy_is_rounding() const;  ///< then its error means nothing. Collective.
  void write_row(const StepResult& result, Integration integration);
  void open_history();
  std::string history_text() const;
  void append(const std::vector<double>& row);
  std::vector<std::pair<std::string, double>> load_metrics() const;
  /// How good the stresses were at a load.
  struct Quality {
    double load, noise, error;  ///< noise: on process 0
  };
  void look_at_stress();
  /// A value of the one looked at nearest to a load, NaN if there is none.
  double largest_extrapolation_error() const;
  double quality_at(double load, double Quality::*value) const;
  /// The state as VTK data, taken now and written now or later.
  struct Frame {
    double time = 0.0;
    VtuData points, mesh;
  };
  Frame take_frame() const;
  VtuData points_data() const;
  VtuData mesh_data() const;
  void write_frame(const Frame& frame);
  std::string write_pieces(const std::string& kind, const VtuData& data) const;
  void write_surfaces(Summary& summary) const;
  void follow_peak();
  void restore_frames(std::vector<std::pair<double, std::string>> frames);
  std::vector<std::string> columns() const;
  std::vector<std::string> probe_columns() const;
  const char* axes() const { return dimension_ == 3 ? "xyz" : "xy"; }

  const World& world_;
  const ImplicitStep& step_;
  std::filesystem::path folder_;
  int dimension_;
  std::vector<NamedProbe> probes_;
  long fitted_points_ = -1;  ///< points made when the probes were fitted
  std::unique_ptr<HistoryWriter> history_;
  PvdWriter points_pvd_, mesh_pvd_;
  int frame_ = 0;
  double next_frame_ = 0.0;
  int last_frame_step_ = -1;
  double largest_energy_ = 0.0;  ///< so far [J]
  std::optional<Frame> peak_;  ///< highest state so far that has no file yet
  double highest_ = 0.0;       ///< load of the last state that was taken or written at a new maximum
  int steps_ = 0, cut_steps_ = 0;
  long newton_iterations_ = 0;
  double row_load_ = 0.0;
  int n_columns_ = 0;
  std::vector<double> rows_;  ///< all rows of the history
  std::vector<Quality> quality_;
  Watched watched_;
  double gap_scatter_ = 0.0;  ///< largest at which bodies have touched [m]
};

}  // namespace berm
