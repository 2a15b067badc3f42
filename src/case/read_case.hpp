#pragma once
/// The only reader of case files.

#include <optional>
#include <string>
#include <vector>

#include "case/case.hpp"

namespace berm {

struct ReadOptions {
  std::optional<std::string> text;  ///< of the case; what is called its path is then a name for messages
  bool allow_petsc_files = false;   ///< solver.petsc may write files and set options of the whole process
};

/// Reads and validates a case file. Throws InputError whose message lists *all* the problems found, one a line, each
/// `file:line:column: what is wrong (remedy)`. `overrides` are "dotted.key=toml value" strings from the command line.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {}, const ReadOptions& options = {});

/// The key reference as Markdown, from the table that parses.
std::string schema_markdown();
/// The same as a JSON Schema (draft 2020-12).
std::string schema_json();

}  // namespace berm
