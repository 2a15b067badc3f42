#pragma once
/// What a constitutive law is.
///
/// A law is a plain struct of parameters with one pure function: old state and trial strain in;
/// stress, consistent tangent, new state and a status out. Always three-dimensional, tension positive.
/// Plane strain is an embedding (zero out-of-plane strain), plane stress one wrapper (plane_stress.hpp):
/// no law knows its dimension. No virtual calls, no allocation, no exceptions in `update`.
///
/// To add a law: its own header in this folder, one line in all.hpp, its test.

#include <concepts>
#include <string_view>
#include <vector>

#include "base/parameter.hpp"
#include "base/tensor.hpp"

namespace berm {

/// How the internal variable enters the stress of the step (docs/theory/damage.md).
enum class Integration {
  implicit,  ///< internal variable of the step itself; unsymmetric consistent tangent
  impl_ex,   ///< extrapolated internal variable (Oliver 2008); symmetric, positive definite tangent
  lagged     ///< internal variable of the previous step, as the 2018 program did
};

enum class Status : unsigned char {
  ok,
  not_converged,  ///< a local iteration failed
  not_admissible  ///< the state lies outside what the law is defined for
};

struct LawInput {
  /// Small strain, or Hencky (logarithmic) strain; engineering shear [-]. Of a law that keeps its elastic strain: the
  /// trial elastic strain, that is what it becomes if no plastic flow happens in the step.
  Voigt strain = Voigt::Zero();
  double length = 0.0;  ///< crack-band length of the integration domain [m]
  double dt = 1.0;      ///< size of this step in the step control's own time, for extrapolation
  Integration integration = Integration::implicit;
  bool want_tangent = true;
};

struct LawOutput {
  Voigt stress = Voigt::Zero();       ///< Cauchy (small strain) or Kirchhoff (Hencky) stress [Pa]
  Voigt66 tangent = Voigt66::Zero();  ///< d stress / d strain, consistent with `integration` [Pa]
  double damage = 0.0;                ///< 0 sound ... 1 broken, at the end of the step [-]
  double plastic_strain = 0.0;        ///< laws of plasticity: accumulated, at the end of the step [-]
  double stored_energy = 0.0;         ///< free energy per reference volume [J/m3]
  double dissipated = 0.0;            ///< energy dissipated in this step per reference volume [J/m3]
  double extrapolation_error = 0.0;   ///< impl_ex: |damage used - damage of the step| [-]
};

/// A law must be copyable and offer:
///   static constexpr std::string_view name;        its name in the case file
///   static constexpr std::string_view doc;         one sentence for the manual, with source
///   static constexpr int n_state;                  number of doubles that a point stores
///   static std::vector<Parameter<L>> parameters(); keys, units, ranges
///   std::string check(double length) const;        "" or why the parameters cannot work with that crack-band length
///   void initial_state(double* state) const;
///   Status update(const LawInput&, const double* old_state, double* new_state, LawOutput&) const;
///   double stiffness() const;                      representative Young's modulus, scales penalties [Pa]
///
/// A law of plasticity also says `static constexpr int elastic_strain = I`: its state holds the elastic strain (Voigt,
/// engineering shear) in the six doubles from I on. It must be isotropic: trial elastic strain, elastic strain and
/// stress share their axes (docs/theory/plasticity.md). If plane
/// stress means nothing for it, or its corners keep plane_stress.hpp from converging, `no_plane_stress = true` says so.
template <class L>
concept Law = requires(const L law, const LawInput& in, const double* old_state, double* new_state, LawOutput& out,
                       double length) {
  { L::name } -> std::convertible_to<std::string_view>;
  { L::doc } -> std::convertible_to<std::string_view>;
  { L::n_state } -> std::convertible_to<int>;
  { L::parameters() } -> std::same_as<std::vector<Parameter<L>>>;
  { law.check(length) } -> std::convertible_to<std::string>;
  {law.initial_state(new_state)};
  { law.update(in, old_state, new_state, out) } -> std::same_as<Status>;
  { law.stiffness() } -> std::convertible_to<double>;
};

/// Laws whose strain is the trial elastic one.
template <class L>
inline constexpr bool keeps_elastic_strain = requires {
  L::elastic_strain;
};

}  // namespace berm
