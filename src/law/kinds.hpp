#pragma once
/// Kinds of laws that decide how a case is computed by default.   [docs/adr/0016]

#include "law/all.hpp"

namespace berm {

/// Grains, whose places move far past each other.
inline bool is_soil(const AnyLaw& law) {
  return std::holds_alternative<MohrCoulomb>(law) || std::holds_alternative<DruckerPrager>(law) ||
         std::holds_alternative<ModifiedCamClay>(law);
}

inline bool flows_far(const AnyLaw& law) { return is_soil(law) || std::holds_alternative<Newtonian>(law); }

}  // namespace berm
