#pragma once
/// Completion of the command line in a shell.

#include <string>
#include <vector>

struct CommandWords {
  std::string name;
  std::vector<std::string> options;  ///< empty: a Python tool, which is asked for them (--help)
};

/// For bash: subcommands, options, case files. `eval "$(berm completion bash)"`.
std::string bash_completion(const std::vector<CommandWords>& commands);
