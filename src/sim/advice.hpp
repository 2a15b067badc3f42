#pragma once
/// What a run that went wrong can be told to do: only what this very case accepts.

#include <string>

#include "case/case.hpp"

namespace berm {

/// A place in the user's coordinates.
std::string place_text(const Case& c, const Vec3& x);

/// A key of [steps], or of the stage's own table: "stage.flood.count".
std::string key_of_steps(const Stage& stage, const std::string& key);
/// Of whichever stage it was.
std::string key_of_steps(const Case& c, const std::string& key);

/// When the balance of energy went off.
struct EnergyLoss {
  double first = 0.0;    ///< error of the first step [-]
  bool extrapolated = false;  ///< IMPL-EX steps that missed their tolerance
  bool pressure_lost = false; ///< of Cam-Clay, at the start
  double largest = 0.0;  ///< share of the error that came with one step [-]
  double time = 0.0;     ///< of that step [s]
};
std::string advice_on_energy(const Case& c, const EnergyLoss& loss);

/// Where a step of IMPL-EX that could not be cut was wrong by more than the tolerance [of the strength].
std::string advice_on_extrapolation(const Case& c, double error);

/// Where no equilibrium was found with the smallest step. `slips`: a contact is known to let a body go.
std::string advice_on_equilibrium(const Case& c, const Stage& stage, bool slips = false);

/// Where material is deep inside a rigid body; goes on after a comma.
std::string advice_on_penetration(const Case& c);

/// Where soil swells; with its punctuation, empty if its dilatancy ends already.
std::string advice_on_dilatancy(const AnyLaw& law);

/// Where bodies lie in one another; with its punctuation, empty if there is none.
std::string advice_on_overlap(const Case& c);

}  // namespace berm
