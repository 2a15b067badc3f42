#include "case/far_origin.hpp"

#include <Eigen/Geometry>
#include <optional>

namespace berm {
namespace {

/// In cells: beyond it rounding of places would be more than 1e-11 of a cell.
constexpr double far = 1e4;

Vec3 in_space(const Vec2& x) { return {x.x(), x.y(), 0.0}; }

/// Calls f with every place of a shape.
template <class F>
void for_each_place(PlaneShape& shape, F f) {
  if (auto* box = std::get_if<Box>(&shape.form)) f(box->min), f(box->max);
  if (auto* disc = std::get_if<Disc>(&shape.form)) f(disc->centre);
  if (auto* polygon = std::get_if<Polygon>(&shape.form))
    for (Vec2& x : polygon->vertices) f(x);
  if (auto* parts = std::get_if<Combination>(&shape.form))
    for (PlaneShape& part : parts->parts) for_each_place(part, f);
}

void move(SolidShape& shape, const Vec3& by) {
  if (auto* box = std::get_if<SolidBox>(&shape.form)) box->min += by, box->max += by;
  if (auto* cylinder = std::get_if<Cylinder>(&shape.form)) cylinder->from += by, cylinder->to += by;
  if (auto* sphere = std::get_if<Sphere>(&shape.form)) sphere->centre += by;
  if (auto* extrusion = std::get_if<Extrusion>(&shape.form)) {
    for (Vec2& x : extrusion->vertices) x += by.head<2>();
    extrusion->from += by.z(), extrusion->to += by.z();
  }
  if (auto* file = std::get_if<SurfaceFile>(&shape.form)) file->moved += by;
  if (auto* parts = std::get_if<SolidCombination>(&shape.form))
    for (SolidShape& part : parts->parts) move(part, by);
}

void move(Where& where, const Vec3& by) {
  if (where.min) *where.min += by;
  if (where.max) *where.max += by;
  if (where.sector) where.sector->centre += by.head<2>();
  if (where.beyond) where.beyond->at += by;
}

/// A corner of the model and the size of its cells; {0, infinity} if the case does not say.
std::pair<Vec3, double> corner_and_size(const Case& c) {
  const auto* grid = std::get_if<StructuredGrid>(&c.grid);
  if (c.method == Method::mpm && grid)
    return {Eigen::AngleAxisd(grid->angle, Vec3::UnitZ()) * grid->origin, grid->cell_size.head(c.dimension()).minCoeff()};
  for (const Body& body : c.bodies) {
    if (body.rigid || !body.shape || body.mesh.size <= 0.0) continue;
    std::optional<Vec3> first;
    if (const auto* shape = std::get_if<PlaneShape>(&*body.shape)) {
      PlaneShape copy = *shape;
      for_each_place(copy, [&](const Vec2& x) { first = first.value_or(in_space(x)); });
    } else if (const auto* solid = std::get_if<SolidShape>(&*body.shape)) {
      if (const auto* box = std::get_if<SolidBox>(&solid->form)) first = box->min;
      if (const auto* cylinder = std::get_if<Cylinder>(&solid->form)) first = cylinder->from;
      if (const auto* sphere = std::get_if<Sphere>(&solid->form)) first = sphere->centre;
    }
    if (first) return {*first, body.mesh.size};
  }
  return {Vec3::Zero(), infinity};
}

}  // namespace

void count_from_the_grid(Case& c) {
  auto [corner, size] = corner_and_size(c);
  if (c.space == Space::axisymmetric) corner.x() = 0.0;  // the radius counts from the axis
  if (corner.cwiseAbs().maxCoeff() <= far * size) return;
  c.origin = corner;
  const Vec3 by = -corner;
  if (auto* grid = std::get_if<StructuredGrid>(&c.grid))
    grid->origin += Eigen::AngleAxisd(-grid->angle, Vec3::UnitZ()) * by;
  for (Body& body : c.bodies) {
    if (!body.shape) continue;
    if (auto* shape = std::get_if<PlaneShape>(&*body.shape)) for_each_place(*shape, [&](Vec2& x) { x += by.head<2>(); });
    if (auto* shape = std::get_if<SolidShape>(&*body.shape)) move(*shape, by);
  }
  for (NodeBoundary& b : c.boundaries) move(b.where, by);
  for (Pressure& p : c.pressures) move(p.where, by);
  for (Absorbing& a : c.absorbing) move(a.where, by);
  for (Pin& pin : c.pins) pin.at += by;
  for (Gauge& g : c.output.gauges) g.from += by, g.to += by;
  for (Probe& p : c.output.probes) p.at += by;
  const auto count_from = [&](VectorFunction& f) {
    for (TimeFunction& component : f.component) component.set_origin(corner);
  };
  for_each_motion(c, [&](TimeFunction& f) { f.set_origin(corner); });
  for (Body& body : c.bodies) count_from(body.velocity);
  for (Pressure& p : c.pressures) {
    p.value.set_origin(corner);
    if (p.traction) count_from(*p.traction);
  }
}

}  // namespace berm
