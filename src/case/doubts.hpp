#pragma once
/// What is allowed but seldom meant.

#include "case/case.hpp"
#include "case/node.hpp"
#include "case/problems.hpp"

namespace berm {

/// Warns of numbers that look like those of another unit, and of rigid bodies that touch nothing.
void doubt_case(const Case& c, const Node& root, Problems& problems);

}  // namespace berm
