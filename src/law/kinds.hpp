#pragma once
/// Kinds of laws that decide how a case is computed by default.   [docs/adr/0016]

#include "law/all.hpp"

namespace berm {

/// Soil and fluids, whose places move far past each other.
inline bool flows_far(const AnyLaw& law) {
  return std::holds_alternative<MohrCoulomb>(law) || std::holds_alternative<DruckerPrager>(law) ||
         std::holds_alternative<ModifiedCamClay>(law) || std::holds_alternative<Newtonian>(law);
}

}  // namespace berm
