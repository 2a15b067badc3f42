#include "case/doubts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "bc/case_lookup.hpp"
#include "case/units.hpp"

namespace berm {

namespace {

/// Of bodies that a contact parts: they have nodes of their own in every stage.
void doubt_ends_of_contact(const Case& c, const Node& root, Problems& problems) {
  std::map<std::pair<int, int>, std::vector<const Contact*>> contacts_of;
  for (const Contact& k : c.contacts)
    if (!k.other.empty()) contacts_of[bodies_of(c, k)].push_back(&k);
  for (const auto& [bodies, contacts] : contacts_of) {
    const auto stage = std::find_if(c.stages.begin(), c.stages.end(), [&contacts = contacts](const Stage& s) {
      return std::none_of(contacts.begin(), contacts.end(), [&](const Contact* k) { return acts_in(k->stages, s.name); });
    });
    if (stage == c.stages.end()) continue;
    const Contact& first = *contacts.front();
    problems.warn(place_in(root, "contact", first.name, "stages"),
                  fmt::format("in [stage.{0}] no contact keeps \"{1}\" and \"{2}\" apart: where they meet they pass through each other. Add \"{0}\" to \"stages\", or "
                              "give them a second [contact.NAME] with it",
                              stage->name, first.body, first.other));
  }
}

}  // namespace

Place place_in(const Node& root, const std::string& kind, const std::string& name, const std::string& key) {
  const Node::Entry* table = root.find(kind);
  if (table && !name.empty()) table = table->value.find(name);
  if (!table) return {};
  const Node::Entry* entry = table->value.find(key);
  return entry ? entry->place : table->place;
}

void doubt_case(const Case& c, const Node& root, Problems& problems) {
  constexpr double most_gravity = 1000.0;  // a hundred times the Earth's, in a centrifuge [m/s2]
  constexpr double most_friction = 3.0;
  for (const TimeFunction& g : c.gravity.component)
    if (g.is_number() && std::abs(g.number()) > most_gravity)
      problems.warn(place_in(root, "model", "", "gravity"), fmt::format("gravity of {:.6g} m/s2: did you mean mm/s2?", g.number()));
  for (const Material& m : c.materials)
    if (spreads_freely(c, m))
      problems.warn(place_in(root, "material", m.name, "tensile_strength"),
                    fmt::format("next to no tensile strength: nothing holds free faces of \"{}\" against spreading, and points that move through the grid press them out (a "
                                "block under a pressure of twice its cohesion: no equilibrium, or up to twice the strain). Take a thousandth of the largest stresses, or "
                                "leave the key out, or formulation = \"total_lagrangian\" where the body does not move far",
                                m.name));
  for (const Pressure& p : c.pressures) {
    if (!p.value.is_number()) continue;
    const std::string doubt = unit_doubt("value", Unit::stress, p.value.number());
    if (!doubt.empty()) problems.warn(place_in(root, "pressure", p.name, "value"), doubt);
  }
  for (const Contact& k : c.contacts)
    if (k.friction > most_friction)
      problems.warn(place_in(root, "contact", k.name, "friction"),
                    fmt::format("friction = {:.6g} is a coefficient: did you mean tan({:.6g} degrees)?", k.friction, k.friction));
  if (c.gravity.is_zero() && only_weight_acts(c))
    problems.warn(place_in(root, "model", "", "gravity"),
                  "nothing acts on the bodies: no gravity ([model] gravity = [0.0, -9.81]), no load, no motion of a support or a rigid body, no velocity");
  if (const TimeFunction& radial = c.gravity.component[0]; c.space == Space::axisymmetric && !radial.is_zero() && !radial.depends_on_place())
    problems.error(place_in(root, "model", "", "gravity"),
                   "gravity along the radius is no weight: the axis of rotation is y, gravity = [0.0, -9.81]. What turns has [body.NAME] acceleration = "
                   "[\"omega^2*x\", 0.0]");
  doubt_ends_of_contact(c, root, problems);
  if (c.control.kind == Control::Kind::gauge && std::all_of(c.pressures.begin(), c.pressures.end(), is_zero))
    problems.error(place_in(root, "control", "", "kind"), "\"gauge\" scales the pressures of the case, and all are zero: give one a value");
  for (const Body& b : c.bodies)
    if (b.rigid && std::none_of(c.contacts.begin(), c.contacts.end(), [&](const Contact& k) { return k.rigid == b.name; }))
      problems.warn(place_in(root, "body", b.name, "rigid"), fmt::format("rigid body \"{}\" touches nothing: no [contact.NAME] names it", b.name));
}

}  // namespace berm
