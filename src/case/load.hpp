#pragma once
/// Case files to one merged tree: `base`, `remove`, overrides.

#include <string>
#include <vector>

#include "case/node.hpp"
#include "case/problems.hpp"

namespace berm {

/// Reads a case file and the files it is based on. Tables are merged key by key, the child wins; what `remove` names is
/// dropped from the base first; overrides come last. The keys `base` and `remove` are gone from the result.
Node load_case(const std::string& path, const std::vector<std::string>& overrides, Problems& problems);

}  // namespace berm
