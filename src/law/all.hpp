#pragma once
/// The list of laws. One line here and the case reader, the manual, the solvers and the law tests know the law.

#include <cstddef>
#include <optional>
#include <type_traits>
#include <utility>
#include <variant>

#include "law/drucker_prager.hpp"
#include "law/lemaitre.hpp"
#include "law/linear_elastic.hpp"
#include "law/mazars.hpp"
#include "law/modified_cam_clay.hpp"
#include "law/mohr_coulomb.hpp"
#include "law/neo_hookean.hpp"
#include "law/newtonian.hpp"
#include "law/rankine.hpp"
#include "law/simo_ju.hpp"
#include "law/von_mises.hpp"

namespace berm {

using AnyLaw = std::variant<LinearElastic, SimoJu, Rankine, Mazars, MazarsClassic, LemaitreStrain, LemaitreEnergy,
                            NeoHookean, VonMises, DruckerPrager, MohrCoulomb, ModifiedCamClay, Newtonian>;

/// Calls f with a default-constructed law of each type, in the order of the list.
template <class F>
void for_each_law(F&& f) {
  [&f]<std::size_t... I>(std::index_sequence<I...>) { (f(std::variant_alternative_t<I, AnyLaw>{}), ...); }
  (std::make_index_sequence<std::variant_size_v<AnyLaw>>{});
}

inline bool knows_plane_stress(const AnyLaw& law) {
  return std::visit(
      [](const auto& l) {
        return !requires { std::decay_t<decltype(l)>::no_plane_stress; };
      },
      law);
}

/// Elastic constants of a law with constant ones; empty for others.
inline std::optional<Lame> elastic_constants(const AnyLaw& law) {
  return std::visit(
      [](const auto& l) -> std::optional<Lame> {
        if constexpr (requires { l.lame(); })
          return l.lame();
        else
          return {};
      },
      law);
}

inline bool is_plastic(const AnyLaw& law) {
  return std::visit([](const auto& l) { return keeps_elastic_strain<std::decay_t<decltype(l)>>; }, law);
}

/// Softens by damage: brittle.
inline bool is_damage(const AnyLaw& law) {
  return std::visit([](const auto& l) { return requires { std::decay_t<decltype(l)>::n_weights; }; }, law);
}

}  // namespace berm
