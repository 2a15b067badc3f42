#pragma once
/// What a later stage finds otherwise than the start: bodies have moved since.

#include <string>
#include <vector>

#include "sim/world.hpp"

namespace berm {

/// Of supports and ties that begin to act in the present stage, whose first step has begun. Throws RunError where a tie would join
/// surfaces that no longer touch. Collective.
std::vector<std::string> doubts_of_stage(const World& w);

}  // namespace berm
