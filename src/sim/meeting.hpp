#pragma once
/// Parts of bodies that were apart and meet in the cells of one field of the grid, which joins them.

#include <optional>

#include "sim/world.hpp"

namespace berm {

struct Meeting {
  int body_a = 0, body_b = 0;  ///< of the case; the same for the sides of a slot
  Vec3 where = Vec3::Zero();
  double closer = 0.0;         ///< than what the material between has strained says [m]
};

/// The worst one of solids that neither flow nor yield, beyond a quarter of a cell. Collective.
std::optional<Meeting> find_meeting(const World& world);

}  // namespace berm
