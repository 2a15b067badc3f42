#pragma once
/// A whole run: from a case to a filled output folder.

#include <filesystem>
#include <optional>

#include "case/case.hpp"

namespace berm {

struct RunOptions {
  std::filesystem::path folder;  ///< output folder; created if missing
  bool quiet = false;
  std::string restart;                 ///< checkpoint to go on from; empty: from the start
  std::optional<bool> is_interactive = std::nullopt;  ///< whether the user sees a terminal; default: ask the operating system
};

/// Runs the case on all processes. Throws InputError or RunError, the same on all; in the second case everything up to the
/// last converged step has been written.
void run_case(Case spec, const RunOptions& options);

}  // namespace berm
