#pragma once
/// What a run leaves behind: history rows, VTK frames, peak values and metrics (docs/output.md).

#include <filesystem>
#include <memory>
#include <optional>

#include "io/history.hpp"
#include "io/summary.hpp"
#include "io/vtu.hpp"
#include "sim/local_fit.hpp"
#include "sim/quasi_static.hpp"

namespace berm {

class Recorder {
public:
  Recorder(const World& world, const QuasiStaticStep& step, const std::filesystem::path& folder);

  /// After every accepted step.
  void record(const StepResult& result, Integration integration);
  void count_cut() { ++cut_steps_; }
  /// Writes the last frame and summary.json. Status as in Summary.
  void finish(const std::string& status, const std::string& reason, double wall_seconds);

  int steps() const { return steps_; }
  double load() const { return row_load_; }
  std::vector<std::pair<std::string, double>> metrics() const;

private:
  struct NamedProbe {
    Probe spec;
    LocalFit fit;
  };
  /// Nominal load and displacement of the present state.
  Vec2 nominal_force() const;
  double nominal_displacement() const;
  double probe_value(const NamedProbe& probe) const;
  double stress_noise() const;
  double energy_error() const;
  void write_row(const StepResult& result, Integration integration);
  /// The state as VTK data, taken now and written now or later.
  struct Frame {
    double time = 0.0, load = 0.0;
    VtuData points, mesh;
  };
  Frame take_frame() const;
  VtuData points_data() const;
  VtuData mesh_data() const;
  void write_frame(const Frame& frame);
  void follow_peak();
  std::vector<std::string> columns() const;

  const World& world_;
  const QuasiStaticStep& step_;
  std::filesystem::path folder_;
  std::vector<Vec2> reference_;  ///< positions of the points at the start
  std::vector<NamedProbe> probes_;
  std::unique_ptr<HistoryWriter> history_;
  PvdWriter points_pvd_, mesh_pvd_;
  int frame_ = 0;
  double next_frame_ = 0.0;
  int last_frame_step_ = -1;
  std::optional<Frame> peak_;  ///< highest state so far that has no file yet
  double highest_ = 0.0;       ///< load of the last state that was taken or written at a new maximum
  int steps_ = 0, cut_steps_ = 0;
  long newton_iterations_ = 0;
  double row_load_ = 0.0;
  struct Point {
    double displacement, load;
  };
  std::vector<Point> curve_;
  std::vector<std::pair<double, double>> noise_;  ///< load, noise
};

}  // namespace berm
