#pragma once
/// What is allowed but seldom meant, and what has no value.

#include "case/case.hpp"
#include "case/node.hpp"
#include "case/problems.hpp"

namespace berm {

/// Warns of numbers that look like those of another unit, and of rigid bodies that touch nothing; an error for a gauge that has no
/// load to scale.
void doubt_case(const Case& c, const Node& root, Problems& problems);

/// Errors for expressions of time that have no finite value in a stage in which they act; warns of those that swing between the steps.
void check_functions(const Case& c, const Node& root, Problems& problems);

/// Where a key of [kind.name] stands, else the table, else nowhere.
Place place_in(const Node& root, const std::string& kind, const std::string& name, const std::string& key);

}  // namespace berm
