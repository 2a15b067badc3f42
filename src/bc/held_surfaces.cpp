/// Boundaries on the surface of a body, which move with it.
#include <fmt/format.h>

#include <cmath>
#include <span>

#include "base/findings.hpp"
#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"
#include "bc/parted_supports.hpp"

namespace berm {
namespace {

/// Of the penalty, in units of E / h: what gives way is a 500th of what a cell does. Stiffer ones bind cut cells to their
/// neighbours.
constexpr double held_penalty = 500.0;

/// Of two boundaries that act in the same stage.
bool disagree(const NodeBoundary& a, const NodeBoundary& b) {
  if (a.slides() && b.slides()) return a.normal == b.normal && a.un != b.un;
  for (int i = 0; i < 3; ++i)
    if (a.u[i] && b.u[i] && *a.u[i] != *b.u[i]) return true;
  return false;
}

}  // namespace

/// Nodes would take what the first one says; here the two would pull at each other.
void BoundaryConditions::refuse_disagreement(const NodeBoundary& spec, const NodeBoundary& first,
                                             const std::vector<SurfacePoint>& surface) const {
  if (first.body != spec.body || !share_a_stage(first.stages, spec.stages) || !disagree(first, spec)) return;
  const int body = body_index(case_, spec.body);
  const auto caught = [&](const NodeBoundary& n) {
    return caught_surface("boundary." + n.name, n.where, body, n.body, surface, dimension_);
  };
  if (overlap(caught(first), caught(spec)))
    throw InputError(fmt::format("[boundary.{}] and [boundary.{}] prescribe different displacements of the same part of the "
                                 "surface of \"{}\": make their regions disjoint",
                                 first.name, spec.name, spec.body));
}

void BoundaryConditions::read_held_surfaces(const Case& c, const std::vector<SurfacePoint>& surface) {
  Findings found;
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    const NodeBoundary& spec = c.boundaries[b];
    if (spec.body.empty()) continue;
    const int body = body_index(c, spec.body);
    std::vector<SurfacePart> parts;
    found.look([&] {
      for (const NodeBoundary& first : std::span(c.boundaries).first(b)) refuse_disagreement(spec, first, surface);
      parts = caught_surface("boundary." + spec.name, spec.where, body, spec.body, surface, dimension_);
    });
    for (const auto& [s, share] : spec.slides() ? without_strips(parts) : parts) {
      HeldPoint point;
      point.anchor = anchor_at(body, s.X, s.normal);
      point.id = static_cast<int>(held_.size());
      point.boundary = static_cast<int>(b);
      point.stiffness = held_penalty * stiffness_of(c, body) / cell_size_ * share * s.area;
      point.normal = spec.normal.value_or(s.normal);
      point.slides = spec.slides();
      held_.push_back(point);
    }
  }
  found.throw_if_any();
  const int taken = part_supports(held_, cell_size_, [&](const HeldPoint& p, const HeldPoint& q) {
    const NodeBoundary &a = c.boundaries[p.boundary], &b = c.boundaries[q.boundary];
    const bool crossing = p.slides && q.slides && std::abs(p.normal.dot(q.normal)) < 0.9;  // a corner of sliding walls
    return a.body == b.body && share_a_stage(a.stages, b.stages) && disagree(a, b) && !crossing;
  });
  if (taken > 0) warnings_.push_back(fmt::format(parted, "boundaries"));
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
  const auto step = [&](const TimeFunction& u) { return u.step(t0, t1, p.anchor.X); };
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

/// Throws if a motion has no value somewhere at that time.
void BoundaryConditions::check_held_surfaces(double time) const {
  for (const HeldPoint& p : held_)
    if (acts(case_.boundaries[p.boundary].stages)) held_step(p, time, time);
}

/// Force of the support on the body [N].   [boundaries (14)]
Vec3 BoundaryConditions::held_force(const HeldPoint& p, const NodalVector& du, double t0, double t1) const {
  if (!acts(case_.boundaries[p.boundary].stages)) return Vec3::Zero();
  return p.stiffness * still_missing(p, du, t0, t1);
}

BoundaryConditions::Lag BoundaryConditions::worst_lag(double time) const {
  Lag worst;
  for (const HeldPoint& p : held_)
    if (const double missing = p.missing.norm(); missing > worst.missing)
      worst = {p.boundary, missing, held_step(p, 0.0, time).norm(), p.anchor.X};
  return worst;
}

void BoundaryConditions::commit_held_surfaces(const NodalVector& du, double t0, double t1) {
  for (HeldPoint& p : held_) {
    const bool acts_now = acts(case_.boundaries[p.boundary].stages);
    p.missing = acts_now ? still_missing(p, du, t0, t1) : Vec3(Vec3::Zero());
  }
}

}  // namespace berm
