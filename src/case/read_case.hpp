#pragma once
/// The only reader of case files.

#include <string>
#include <vector>

#include "case/case.hpp"

namespace berm {

/// Reads and validates a case file. Throws InputError whose message lists *all* the problems found, one a line, each
/// `file:line:column: what is wrong (remedy)`. `overrides` are "dotted.key=toml value" strings from the command line.
Case read_case(const std::string& path, const std::vector<std::string>& overrides = {});

/// The key reference as Markdown, from the table that parses.
std::string schema_markdown();
/// The same as a JSON Schema (draft 2020-12).
std::string schema_json();

}  // namespace berm
