#include "sim/advice.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "base/error.hpp"
#include "base/place_text.hpp"
#include "bc/case_lookup.hpp"

namespace berm {

std::string place_text(const Case& c, const Vec3& x) { return place_text(c.origin + x, c.dimension()); }

std::string key_of_steps(const Stage& stage, const std::string& key) {
  return stage.name.empty() ? fmt::format("steps.{}", key) : fmt::format("stage.{}.{}", stage.name, key);
}

std::string key_of_steps(const Case& c, const std::string& key) { return c.stages.size() == 1 ? key_of_steps(c.stages.front(), key) : key + " of its stage"; }

namespace {

/// Loads that vary from place to place may be there in a part of a body only: a few places stand for it.
bool loads_from_the_start(const Case& c) {
  const auto acts = [](const TimeFunction& f) {
    const auto is_there = [&](double x) {
      try {
        return f.at(0.0, Vec3(x, 0.7 * x, 0.3 * x)) != 0.0;
      } catch (const RunError&) {
        return false;  // it has no value there
      }
    };
    return !f.is_number() && (is_there(0.0) || (f.depends_on_place() && (is_there(1.0) || is_there(-1.0) || is_there(0.1))));
  };
  const auto any_acts = [&](const VectorFunction& f) { return std::any_of(f.component.begin(), f.component.end(), acts); };
  return any_acts(c.gravity) || std::any_of(c.bodies.begin(), c.bodies.end(), [&](const Body& b) { return any_acts(b.acceleration); }) ||
         std::any_of(c.pressures.begin(), c.pressures.end(), [&](const Pressure& p) { return acts(p.value) || (p.traction && any_acts(*p.traction)); });
}

/// Whether a gauge can drive the run, and does not.
bool scales_loads(const Case& c) {
  return c.stages.size() == 1 && !c.is_dynamic() && !c.pressures.empty() && c.volumetric != Volumetric::mixed && c.control.kind != Control::Kind::gauge;
}

bool can_be_dynamic(const Case& c) { return c.control.kind != Control::Kind::gauge && c.volumetric != Volumetric::mixed; }

}  // namespace

std::string advice_on_energy(const Case& c, const EnergyLoss& loss) {
  constexpr double at_once = 0.3, jump = 0.5;
  if (loss.extrapolated)
    return "stresses that IMPL-EX extrapolates wrongly do work that nothing stores: keep its error below " + key_of_steps(c, "error_tolerance") +
           " (see the warning on it), or take integration = \"implicit\"";
  for (std::size_t k = 1; k < c.stages.size(); ++k) {
    const Stage& stage = c.stages[k];
    const bool first = loss.time > stage.begin && loss.time <= stage.begin + 1.01 * stage.steps.duration / stage.steps.count;
    if (first && loss.largest > jump && !same_act_in(c, c.stages[k - 1].name, stage.name))
      return fmt::format("most of it went in the first step of stage \"{}\", in which supports or loads came or went at once: what they do "
                         "on the way goes nowhere in equilibrium. Let loads grow and go with the time t, or let the stage be dynamic",
                         stage.name);
  }
  if (loss.largest > jump && any_law(c, is_damage) && !c.is_dynamic() && can_be_dynamic(c)) {
    return fmt::format("most of it went in the step to time {:.6g}, where the structure snaps back: what it lets go of is in no equation of "
                       "equilibrium. Follow the motion with analysis = \"dynamic\"{}",
                       loss.time, scales_loads(c) ? ", or drive the run with [control] kind = \"gauge\"" : "");
  }
  if (const Steps& steps = c.stages.front().steps; loss.pressure_lost && loss.largest > jump && loss.time <= 1.01 * steps.duration / steps.count)
    return "most of it went in the first step, from the reference_pressure that nothing holds (see the warning on it)";
  if (loss.first > at_once && !c.is_dynamic() && loads_from_the_start(c))
    return "loads that are there from the start do work that nothing stores: let them grow with the time t, as in \"1e5*t\"";
  std::string advice = "take smaller steps, or smaller cells";
  if (c.method != Method::mpm || !moves_through_grid(c) || c.shape_functions != ShapeFunctions::linear) return advice;
  if (c.volumetric != Volumetric::mixed && c.quadrature == Quadrature::points && !has_gauss_points(c))
    return advice + "; points that cross cells lose stress and energy with grid.shape_functions = \"linear\": leave the key out";
  if (!meets_deformable_bodies(c)) advice += "; points that cross cells lose stress: formulation = \"total_lagrangian\", if the body does not move far";
  return advice;
}

std::string advice_on_extrapolation(const Case& c, double error) {
  constexpr double unstable = 0.1;  // of the strength, in the smallest step
  const std::string smaller = "make " + key_of_steps(c, "min_fraction") + " smaller, with adaptive steps";
  if (c.is_dynamic() || !can_be_dynamic(c) || error < unstable) return smaller;
  return "where the structure snaps back no step is small enough: follow the motion with analysis = \"dynamic\"" +
         std::string(scales_loads(c) ? ", or drive the run with [control] kind = \"gauge\"" : "") + "; else " + smaller;
}

std::string advice_on_equilibrium(const Case& c, const Stage& stage, bool slips) {
  std::vector<std::string> ways;
  for (const Material& m : c.materials)
    if (spreads_freely(c, m)) ways.push_back(fmt::format("give [material.{}] a tensile_strength of a thousandth of the largest stresses", m.name));
  const bool damage = any_law(c, is_damage), plastic = any_law(c, is_plastic);
  if (damage && !plastic && !slips && stage.solver.integration == Integration::implicit) {
    ways.emplace_back("take [solver] integration = \"impl_ex\"");
    if (stage.solver.snap_back != Solver::SnapBack::impl_ex) ways.back() += " or snap_back = \"impl_ex\"";
  }
  if (scales_loads(c)) ways.emplace_back("drive the run with [control] kind = \"gauge\"");
  if (stage.steps.analysis == Analysis::quasi_static && can_be_dynamic(c))
    ways.emplace_back("follow the motion with analysis = \"dynamic\"");
  if (!slips || ways.empty()) ways.emplace_back(fmt::format("allow smaller steps ({}, {})", key_of_steps(stage, "count"), key_of_steps(stage, "min_fraction")));
  const char* what = slips  ? "It would have to be held by something else"
                     : damage ? "The structure snaps back or collapses here"
                     : plastic ? "The load is more than can be borne, or contact or supports let go"
                               : "Supports or contact let a body go, or it buckles";
  std::vector<std::string> rubbing;
  for (const Contact& k : c.contacts)
    if (k.kind == Contact::Kind::friction && acts_in(k.stages, stage.name)) rubbing.push_back("[contact." + k.name + "]");
  const std::string friction = slips || rubbing.empty() ? "" : fmt::format(" (perhaps the friction of {} cannot hold it, or it tips)", fmt::join(rubbing, ", "));
  const char* petsc = c.solver.petsc.empty() ? "" : "First without \"petsc\" in [solver]. ";
  return fmt::format("{}{}{}: {}", petsc, what, friction, fmt::join(ways, ", or "));
}

std::string advice_on_penetration(const Case& c) {
  return c.method == Method::mpm ? "or take the material along with the rigid body by kind = \"shared_nodes\" (no slip, no gap)"
                                 : "or make its steps smaller";
}

std::string advice_on_dilatancy(const AnyLaw& law) {
  if (const auto* soil = std::get_if<MohrCoulomb>(&law))
    return soil->residual_dilatancy_angle < 0.0 ? ": give it residual_dilatancy_angle = 0 from a plastic strain softening_end on" : "";
  return ": take dilatancy_angle = 0, or law = \"mohr_coulomb\" with a residual_dilatancy_angle";
}

std::string advice_on_overlap(const Case& c) {
  const bool meet = std::any_of(c.contacts.begin(), c.contacts.end(), [](const Contact& k) {
    return !k.other.empty() && k.kind != Contact::Kind::tie;
  });
  if (!meet) return ": nothing keeps them apart where no [contact.NAME] is";
  if (moves_through_grid(c)) return "";
  return ". In small strain and total Lagrangian contact acts where bodies face each other at the start: take [model] "
         "kinematics = \"finite\" and formulation = \"updated_lagrangian\"";
}

}  // namespace berm
