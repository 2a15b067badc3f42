#pragma once
/// What a name in a case stands for.

#include <algorithm>

#include "case/case.hpp"

namespace berm {

/// -1 if no body has that name.
inline int body_index(const Case& c, const std::string& name) {
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].name == name) return static_cast<int>(b);
  return -1;
}

/// Stiffness of the body's law [Pa].
inline double stiffness_of(const Case& c, int body) {
  for (const Material& m : c.materials)
    if (m.name == c.bodies[body].material) return std::visit([](const auto& law) { return law.stiffness(); }, m.law);
  return 0.0;
}

inline bool share_a_stage(const Stages& a, const Stages& b) {
  return a.empty() || b.empty() || std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

}  // namespace berm
