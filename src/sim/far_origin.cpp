#include "sim/far_origin.hpp"

#include <Eigen/Geometry>
#include <optional>

#include "base/decimals.hpp"

namespace berm {
namespace {

/// In cells: beyond it rounding of places would be more than 1e-11 of a cell.
constexpr double far = 1e4;

Vec3 in_space(const Vec2& x) { return {x.x(), x.y(), 0.0}; }

/// Places less the corner.
class Shift {
public:
  explicit Shift(const Vec3& corner) : corner_(corner), decimals_(decimals_at(corner)) {}
  void operator()(Vec3& x) const {
    for (int i = 0; i < 3; ++i) move(x[i], i);
  }
  void operator()(Vec2& x) const {
    for (int i = 0; i < 2; ++i) move(x[i], i);
  }
  void move(double& x, int axis) const { x = difference(x, corner_[axis], decimals_); }
  const Vec3& corner() const { return corner_; }

private:
  Vec3 corner_;
  double decimals_;
};

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

void move(SolidShape& shape, const Shift& shift) {
  if (auto* box = std::get_if<SolidBox>(&shape.form)) shift(box->min), shift(box->max);
  if (auto* cylinder = std::get_if<Cylinder>(&shape.form)) shift(cylinder->from), shift(cylinder->to);
  if (auto* sphere = std::get_if<Sphere>(&shape.form)) shift(sphere->centre);
  if (auto* extrusion = std::get_if<Extrusion>(&shape.form)) {
    for (Vec2& x : extrusion->vertices) shift(x);
    shift.move(extrusion->from, 2), shift.move(extrusion->to, 2);
  }
  if (auto* file = std::get_if<SurfaceFile>(&shape.form)) file->moved -= shift.corner();
  if (auto* parts = std::get_if<SolidCombination>(&shape.form))
    for (SolidShape& part : parts->parts) move(part, shift);
}

void move(Where& where, const Shift& shift) {
  if (where.min) shift(*where.min);
  if (where.max) shift(*where.max);
  if (where.sector) shift(where.sector->centre);
  if (where.beyond) shift(where.beyond->at);
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
  const Shift shift(corner);
  if (auto* grid = std::get_if<StructuredGrid>(&c.grid)) {
    const Eigen::AngleAxisd turn(grid->angle, Vec3::UnitZ());
    Vec3 place = turn * grid->origin;
    shift(place);
    grid->origin = turn.inverse() * place;
  }
  for (Body& body : c.bodies) {
    if (!body.shape) continue;
    if (auto* shape = std::get_if<PlaneShape>(&*body.shape)) for_each_place(*shape, shift);
    if (auto* shape = std::get_if<SolidShape>(&*body.shape)) move(*shape, shift);
  }
  for (NodeBoundary& b : c.boundaries) move(b.where, shift);
  for (Pressure& p : c.pressures) move(p.where, shift);
  for (Absorbing& a : c.absorbing) move(a.where, shift);
  for (Pin& pin : c.pins) shift(pin.at);
  for (Gauge& g : c.output.gauges) shift(g.from), shift(g.to);
  for (Probe& p : c.output.probes) shift(p.at);
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
