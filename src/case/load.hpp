#pragma once
/// Case files to one merged tree: `base`, `remove`, overrides.

#include <optional>
#include <string>
#include <vector>

#include "case/node.hpp"
#include "case/problems.hpp"

namespace berm {

/// Reads a case file and the files it is based on. Tables are merged key by key, the child wins; what `remove` names is
/// dropped from the base first; overrides come last. The keys `base` and `remove` are gone from the result. `text`: what the
/// case file holds if it is none; `path` is then its name in messages, without a folder.
Node load_case(const std::string& path, const std::vector<std::string>& overrides, const std::optional<std::string>& text,
               Problems& problems);

}  // namespace berm
