#pragma once
/// TOML text to a Node tree.

#include <string>

#include "case/node.hpp"
#include "case/problems.hpp"

namespace berm {

/// Parses TOML text; every node gets its line and column in `file`. A syntax error goes to `problems`, the tree is then
/// empty.
Node parse_toml(const std::string& text, const std::string& file, Problems& problems);

/// Parses "dotted.key=value" of an override. A value that is not TOML is taken as a string, so that
/// `solver.integration=impl_ex` and `grid.cell_size=5 mm` need no quotes.
Node parse_override(const std::string& text, Problems& problems);

}  // namespace berm
