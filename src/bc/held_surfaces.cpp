/// Boundaries on the surface of a body, which move with it.
#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"

namespace berm {
namespace {

/// Of the penalty, in units of E / h. Stiffer ones bind cut cells to their neighbours; the force is carried from step to
/// step, so that softer ones give way in the last step only.
constexpr double held_penalty = 100.0;

}  // namespace

void BoundaryConditions::read_held_surfaces(const Case& c, const std::vector<SurfacePoint>& surface) {
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    const NodeBoundary& spec = c.boundaries[b];
    if (spec.body.empty()) continue;
    const int body = body_index(c, spec.body);
    for (const auto& [s, share] : caught_surface("boundary." + spec.name, spec.where, body, spec.body, surface, dimension_)) {
      HeldPoint point;
      point.anchor = anchor_at(body, s.X, s.normal);
      point.id = static_cast<int>(held_.size());
      point.boundary = static_cast<int>(b);
      point.stiffness = held_penalty * stiffness_of(c, body) / cell_size_ * share * s.area;
      point.normal = spec.normal.value_or(s.normal);
      point.slides = !spec.u[0] && !spec.u[1] && !spec.u[2];
      held_.push_back(point);
    }
  }
}

/// Prescribed part of a displacement.
Mat3 BoundaryConditions::held_directions(const HeldPoint& p) const {
  const NodeBoundary& spec = case_.boundaries[p.boundary];
  if (p.slides) return p.normal * p.normal.transpose();
  Mat3 directions = Mat3::Zero();
  for (int i = 0; i < dimension_; ++i) directions(i, i) = spec.u[i] ? 1.0 : 0.0;
  return directions;
}

Vec3 BoundaryConditions::held_step(const HeldPoint& p, double t0, double t1) const {
  const NodeBoundary& spec = case_.boundaries[p.boundary];
  const auto step = [&](const TimeFunction& u) { return u.at(t1, p.anchor.X) - u.at(t0, p.anchor.X); };
  if (p.slides) return step(spec.un) * p.normal;
  Vec3 u = Vec3::Zero();
  for (int i = 0; i < dimension_; ++i)
    if (spec.u[i]) u[i] = step(*spec.u[i]);
  return u;
}

/// Prescribed less actual displacement at t_{n+1}, since the boundary began to act [m].   [boundaries (14)]
Vec3 BoundaryConditions::still_missing(const HeldPoint& p, const NodalVector& du, double t0, double t1) const {
  return p.missing + held_step(p, t0, t1) - held_directions(p) * p.anchor.stencil->interpolate(du);
}

/// Force of the support on the body [N].   [boundaries (14)]
Vec3 BoundaryConditions::held_force(const HeldPoint& p, const NodalVector& du, double t0, double t1) const {
  if (!acts(case_.boundaries[p.boundary].stages)) return Vec3::Zero();
  return p.force + p.stiffness * still_missing(p, du, t0, t1);
}

void BoundaryConditions::commit_held_surfaces(const NodalVector& du, double t0, double t1) {
  for (HeldPoint& p : held_) {
    const bool now = acts(case_.boundaries[p.boundary].stages);
    p.force = held_force(p, du, t0, t1);
    p.missing = now ? still_missing(p, du, t0, t1) : Vec3(Vec3::Zero());
  }
}

}  // namespace berm
