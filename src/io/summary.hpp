#pragma once
/// summary.json: what a run was and what came out of it (docs/output.md).

#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "base/reference_curve.hpp"
#include "base/tensor.hpp"

namespace berm {

/// Who made the results, with what words.
struct Origin {
  std::string version, commit;  ///< of the program; empty where it does not say
  std::string host;
  std::string command;  ///< as typed, in words that a shell reads; empty where the library was called
};

struct Summary {
  std::string title;
  std::string method;     ///< "mpm" or "fem"
  std::string case_file;  ///< as the user named it
  std::string status;     ///< "running", "done", "stopped" (ended early on purpose) or "failed"
  std::string reason;     ///< why it stopped or failed, empty otherwise
  long dofs = 0;
  long points = 0;
  long steps = 0;
  long cut_steps = 0;
  long newton_iterations = 0;
  double wall_seconds = 0.0;
  double thickness = 1.0;  ///< of the plane model [m]
  int dimension = 2;
  bool axisymmetric = false;
  int processes = 1;
  Origin origin;
  std::map<std::string, std::vector<std::vector<Vec2>>>
      body_rings;  ///< in the plane: outer rings and holes by body, at the start [m]
  std::map<std::string, std::string> body_surfaces;     ///< in space: files of the surfaces by body, at the start
  /// Of rigid bodies: time [s] and displacement [m] at every frame.
  std::map<std::string, std::vector<std::array<double, 4>>> rigid_motion;
  std::vector<ReferenceCurve> references;               ///< for the report
  std::vector<std::pair<std::string, double>> metrics;  ///< "peak_load [N]" and so on; NaN: not defined
};

/// The JSON text. Numbers that JSON cannot hold (NaN, infinity) become null.
std::string summary_json(const Summary& summary);
/// Replaces the file as a whole. Throws RunError naming the file.
void write_summary(const std::string& path, const Summary& summary);

}  // namespace berm
