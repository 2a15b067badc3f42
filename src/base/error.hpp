#pragma once
/// The two ways in which a run can end badly.

#include <stdexcept>
#include <string>

namespace berm {

/// The user's input is wrong (exit code 2). The message names file, line, key and remedy.
struct InputError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// The run could not go on (exit code 1). The message is the last line that the user sees.
struct RunError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace berm
