#pragma once
/// Solid shapes of bodies: primitives, surfaces from files, their unions and differences. Lengths in metres.

#include <string>
#include <variant>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

struct SolidBox {
  Vec3 min, max;
};
/// Straight circular cylinder about any axis.
struct Cylinder {
  Vec3 from, to;  ///< centres of the two flat faces [m]
  double radius;
};
struct Sphere {
  Vec3 centre;
  double radius;
};
/// A polygon of the x-y plane drawn along z.
struct Extrusion {
  std::vector<Vec2> vertices;  ///< simple, either orientation
  double from, to;             ///< z of the two flat faces [m], from < to
};
/// A closed surface in an STL file.
struct SurfaceFile {
  std::string path;
  Vec3 moved = Vec3::Zero();  ///< added to its places [m]
};
struct SolidShape;
/// First shape united with / minus all the others.
struct SolidCombination {
  enum class Kind { join, difference } kind;
  std::vector<SolidShape> parts;
};
struct SolidShape {
  std::variant<SolidBox, Cylinder, Sphere, Extrusion, SurfaceFile, SolidCombination> form;
};

}  // namespace berm
