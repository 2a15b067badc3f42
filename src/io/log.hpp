#pragma once
/// What the user sees while a run goes on: messages and one line of progress. Both go to the terminal and to log.txt. A
/// log that cannot be written any more, on a full disk, ends with a warning and is no reason to end the run; nor is a terminal
/// that has gone (`berm run ... | head -1`, a closed session).

#include <chrono>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "io/file.hpp"

namespace berm {

struct LogOptions {
  std::string file;                    ///< log.txt; empty: no file
  bool quiet = false;                  ///< only warnings reach the terminal
  std::FILE* terminal = stdout;        ///< not owned; null: none (all processes but the first)
  std::optional<bool> is_interactive;  ///< default: ask the operating system whether `terminal` is a terminal
  bool append = false;                 ///< goes on at the end of the file
};

class Log {
public:
  /// Throws RunError if the log file cannot be written.
  explicit Log(const LogOptions& options);
  ~Log();

  void info(std::string_view message);
  /// Shown even when quiet, with "warning: " in front.
  void warning(std::string_view message);
  /// To the log file only.
  void detail(std::string_view message);

  /// Replaces the line at the bottom of an interactive terminal; the next message removes it. Nothing elsewhere.
  void status(std::string_view line);

  bool interactive() const { return interactive_; }
  bool quiet() const { return quiet_; }

private:
  void to_terminal(std::string_view line);
  void write_terminal(const std::string& text);
  void to_file(std::string_view line);

  std::FILE* terminal_;
  bool quiet_, interactive_;
  bool status_shown_ = false;
  std::unique_ptr<OutputFile> file_;
};

/// Where a run is.
struct ProgressState {
  int step = 0;
  double share = 0.0;  ///< of the planned steps of all stages, that is done
  double load = 0.0;  ///< reaction [N]
  int newton_iterations = 0;
  double residual = 0.0;  ///< relative [-]
  long points = 0;
  bool may_slow = false;  ///< something may still come for which steps are cut: what is left is told as "at least"
};

/// How long a run takes, by its pace lately: that since the middle of the time that has passed. The mean from the start would
/// carry the quick steps of the beginning along when steps become small.
class Pace {
public:
  /// A share of the run is done after so many seconds; both grow.
  void add(double seconds, double share);
  /// Seconds to the end; negative: not known.
  double left() const;
  /// By the mean pace from the start.
  double left_by_mean() const;

private:
  struct Sample {
    double seconds, share;
  };
  /// By the pace since that sample.
  double left_from(std::size_t k) const;

  std::vector<Sample> samples_;
};

/// Interactive terminal: one line, renewed at most five times a second. Otherwise a plain line every 10 % of the run, and
/// every five seconds.
class Progress {
public:
  using Clock = std::chrono::steady_clock;

  explicit Progress(Log& log, Clock::time_point start = Clock::now());
  /// Call after every converged step. `now` is an argument for the tests' sake.
  void update(const ProgressState& state, Clock::time_point now = Clock::now());

private:
  Log& log_;
  Clock::time_point start_;
  std::optional<Clock::time_point> shown_;
  Clock::time_point told_;  ///< last plain line
  Pace pace_;
  int tenths_ = 0;
  double point_steps_ = 0.0;
};

/// "47 s", "3 min 20 s", "2 h 5 min".
std::string duration_text(double seconds);

}  // namespace berm
