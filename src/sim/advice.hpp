#pragma once
/// What a run that went wrong can be told to do: only what this very case accepts.

#include <string>

#include "case/case.hpp"

namespace berm {

/// Where the balance of energy is off. `at_once`: by a third already in the first step.
std::string advice_on_energy(const Case& c, bool at_once);

/// Where no equilibrium was found with the smallest step.
std::string advice_on_equilibrium(const Case& c, const Stage& stage);

/// Where bodies lie in one another; with its punctuation, empty if there is none.
std::string advice_on_overlap(const Case& c);

}  // namespace berm
