#include "mesh/shape_bounds.hpp"

#include <type_traits>

#include "base/parameter.hpp"
#include "mesh/surface.hpp"

namespace berm {
namespace {

SolidBox bounds(const PlaneShape& shape);
SolidBox bounds(const SolidShape& shape);

const SolidBox nothing = {Vec3::Constant(infinity), Vec3::Constant(-infinity)};
SolidBox around(const Vec3& centre, const Vec3& half) { return {centre - half, centre + half}; }
SolidBox both(const SolidBox& a, const SolidBox& b) { return {a.min.cwiseMin(b.min), a.max.cwiseMax(b.max)}; }
Vec3 in_space(const Vec2& x, double z = 0.0) { return {x.x(), x.y(), z}; }

SolidBox bounds(const Box& box) { return {in_space(box.min), in_space(box.max)}; }
SolidBox bounds(const Disc& disc) { return around(in_space(disc.centre), {disc.radius, disc.radius, 0.0}); }
SolidBox bounds(const Polygon& polygon) {
  SolidBox all = nothing;
  for (const Vec2& vertex : polygon.vertices) all = both(all, around(in_space(vertex), Vec3::Zero()));
  return all;
}
SolidBox bounds(const SolidBox& box) { return box; }
SolidBox bounds(const Cylinder& cylinder) {
  const Vec3 axis = (cylinder.to - cylinder.from).normalized();
  const Vec3 across = cylinder.radius * (1.0 - axis.array().square()).max(0.0).sqrt().matrix();
  return both(around(cylinder.from, across), around(cylinder.to, across));
}
SolidBox bounds(const Sphere& sphere) { return around(sphere.centre, Vec3::Constant(sphere.radius)); }
SolidBox bounds(const Extrusion& extrusion) {
  SolidBox all = bounds(Polygon{extrusion.vertices});
  all.min.z() = extrusion.from, all.max.z() = extrusion.to;
  return all;
}
SolidBox bounds(const SurfaceFile& file) {
  const TriangleSurface surface = read_stl(file);
  return {low_corner(surface), high_corner(surface)};
}
template <class C>
requires std::is_same_v<C, Combination> || std::is_same_v<C, SolidCombination>
SolidBox bounds(const C& combination) {
  if (combination.kind == C::Kind::difference && !combination.parts.empty()) return bounds(combination.parts.front());
  SolidBox all = nothing;
  for (const auto& part : combination.parts) all = both(all, bounds(part));
  return all;
}
SolidBox bounds(const PlaneShape& shape) {
  return std::visit([](const auto& form) { return bounds(form); }, shape.form);
}
SolidBox bounds(const SolidShape& shape) {
  return std::visit([](const auto& form) { return bounds(form); }, shape.form);
}

}  // namespace

SolidBox bounds_of(const Shape& shape) {
  return std::visit([](const auto& form) { return bounds(form); }, shape);
}

}  // namespace berm
