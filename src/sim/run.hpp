#pragma once
/// A whole run: from a case to a filled output folder.

#include <filesystem>
#include <functional>
#include <optional>

#include "case/case.hpp"
#include "io/summary.hpp"

namespace berm {

struct RunOptions {
  std::filesystem::path folder;  ///< output folder; created if missing
  bool quiet = false;
  std::string restart;                 ///< checkpoint to go on from; empty: from the start
  std::optional<bool> is_interactive = std::nullopt;  ///< whether the user sees a terminal; default: ask the operating system
  /// Results of a run that came to its end make way, as a program that calls the library expects; the command line says no
  /// unless there is --force. A restart goes on in any folder.
  bool replace_finished = true;
  Origin origin = {};  ///< for log and summary; the host is found out
  std::function<void()> listens = {};  ///< called on the first process when signals end the run in good order on all
};

/// From now on SIGINT, SIGTERM, SIGUSR1, SIGXCPU and SIGHUP (unless nohup keeps it away) end a run after its step, in good order; a second
/// one ends it as it is. run_case calls it too; a program may do so earlier.
void catch_signals();

/// Runs the case on all processes. Throws InputError or RunError, the same on all; in the second case everything up to the
/// last converged step has been written.
void run_case(Case spec, const RunOptions& options);

}  // namespace berm
