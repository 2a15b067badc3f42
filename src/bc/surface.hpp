#pragma once
/// Material points of a body's surface: they carry pressure and contact, move with the body, and work alike on the grid
/// (mpm) and on element edges (fem).   [docs/theory/boundaries.md]

#include <map>
#include <vector>

#include "bc/where.hpp"
#include "mesh/region.hpp"
#include "method/discretisation.hpp"

namespace berm {

/// A piece of a body's surface; outward normal and length of the reference state.
struct SurfacePoint {
  Anchor anchor;
  Vec2 normal = Vec2::Zero();
  double length = 0.0;
  std::vector<std::string> groups;  ///< physical curves of a body mesh
};

/// A pressure load: the surface points in its region.
struct PressureLoad {
  const Pressure* spec = nullptr;
  std::vector<int> points;
  std::vector<double> area;  ///< loaded part of each [m2]
};

/// One surface point against one rigid body.
struct ContactPoint {
  int point = 0;
  double stiffness = 0.0;      ///< penalty times area [N/m]
  Vec2 slip = Vec2::Zero();    ///< relative displacement since touch, t_n [m]
  Vec2 normal = Vec2::Zero();  ///< outward normal of the rigid body, frozen in the step
  double gap = 0.0;            ///< at t_n, frozen normal [m]
};

struct RigidContact {
  const Contact* spec = nullptr;
  int rigid = -1;  ///< index into the case's bodies
  std::vector<ContactPoint> points;
  std::vector<Anchor> inside;     ///< shared_nodes: points of the rigid body
  std::vector<int> shared_nodes;  ///< shared_nodes: nodes of the step that move with it
};

/// A held spot of a body.
struct PinPoint {
  Anchor anchor;
  bool x = false, y = false;
  double stiffness = 0.0;
};

struct GaugeLine {
  std::string name;
  Anchor from, to;
  Vec2 direction = Vec2::Zero();
  double elongation() const { return direction.dot(to.u - from.u); }
};

}  // namespace berm
