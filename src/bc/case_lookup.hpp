#pragma once
/// What a name in a case stands for, and what kind of case it is.

#include <algorithm>

#include "case/case.hpp"

namespace berm {

/// -1 if no body has that name.
inline int body_index(const Case& c, const std::string& name) {
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].name == name) return static_cast<int>(b);
  return -1;
}

/// Two deformable bodies that a contact is for, the lower number first.
inline std::pair<int, int> bodies_of(const Case& c, const Contact& contact) {
  return std::minmax({body_index(c, contact.body), body_index(c, contact.other)});
}

/// Null for a rigid body.
inline const Material* material_of(const Case& c, int body) {
  const auto found = std::find_if(c.materials.begin(), c.materials.end(), [&](const Material& m) { return m.name == c.bodies[body].material; });
  return found == c.materials.end() ? nullptr : &*found;
}

/// Stiffness of the body's law; 0 for a rigid one [Pa].
inline double stiffness_of(const Case& c, int body) {
  const Material* m = material_of(c, body);
  return m ? std::visit([](const auto& law) { return law.stiffness(); }, m->law) : 0.0;
}

inline bool acts_in(const Stages& stages, const std::string& stage) {
  return stages.empty() || std::find(stages.begin(), stages.end(), stage) != stages.end();
}

/// Whether the same supports, loads and contacts act in two stages.
inline bool same_act_in(const Case& c, const std::string& a, const std::string& b) {
  const auto same = [&](const auto& items) {
    return std::all_of(items.begin(), items.end(), [&](const auto& item) { return acts_in(item.stages, a) == acts_in(item.stages, b); });
  };
  return same(c.boundaries) && same(c.pins) && same(c.pressures) && same(c.contacts);
}

/// Whether the law of some material is one.
template <class Test>
bool any_law(const Case& c, Test test) {
  return std::any_of(c.materials.begin(), c.materials.end(), [&](const Material& m) { return test(m.law); });
}

/// Points see the grid from where they are, not from where they started.
inline bool moves_through_grid(const Case& c) {
  return c.kinematics == Kinematics::finite && c.formulation == Formulation::updated_lagrangian;
}

/// Nothing holds its free faces against spreading: in finite elements they stay, but points that move through the grid press them
/// out, by the small errors of their stresses.
inline bool spreads_freely(const Case& c, const Material& m) {
  constexpr double enough = 3e-4;  // of the cohesion: with 5e-5 a block under pressure finds no equilibrium, with 5e-4 it is right
  const auto* soil = std::get_if<MohrCoulomb>(&m.law);
  return soil && c.method == Method::mpm && moves_through_grid(c) && soil->tensile_strength < enough * soil->cohesion;
}

/// By contact or a tie.
inline bool meets_deformable_bodies(const Case& c) {
  return std::any_of(c.contacts.begin(), c.contacts.end(), [](const Contact& k) { return !k.other.empty(); });
}

inline bool has_gauss_points(const Case& c) {
  return std::any_of(c.bodies.begin(), c.bodies.end(), [](const Body& b) {
    return !b.rigid && b.points.placement == PointSeeding::Placement::gauss;
  });
}

/// Points of a file's elements lie anywhere in the cells, with no shape of the body to fit them to.
inline bool has_points_of_files(const Case& c) {
  return std::any_of(c.bodies.begin(), c.bodies.end(), [](const Body& b) { return !b.rigid && !b.mesh_file.empty(); });
}

inline bool share_a_stage(const Stages& a, const Stages& b) {
  return a.empty() || b.empty() || std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

inline bool is_zero(const Pressure& p) { return p.traction ? p.traction->is_zero() : p.value.is_zero(); }

/// No load, motion or velocity in any stage; gravity, if there is any.
inline bool only_weight_acts(const Case& c) {
  const auto rests = [](const Body& b) { return b.displacement.is_zero() && b.acceleration.is_zero() && b.velocity.is_zero(); };
  const auto holds_still = [](const NodeBoundary& b) {
    return b.un.is_zero() && std::all_of(b.u.begin(), b.u.end(), [](const auto& u) { return !u || u->is_zero(); });
  };
  return std::all_of(c.bodies.begin(), c.bodies.end(), rests) && std::all_of(c.pressures.begin(), c.pressures.end(), is_zero) &&
         std::all_of(c.boundaries.begin(), c.boundaries.end(), holds_still);
}

}  // namespace berm
