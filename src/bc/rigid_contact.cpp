/// Contact with rigid bodies, which move as the case says: at points of surfaces, or by nodes that they take along.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "base/error.hpp"
#include "base/findings.hpp"
#include "base/reach.hpp"
#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"
#include "bc/parted_supports.hpp"

namespace berm {
namespace {

const std::array<TimeFunction, 3>& motion_of_rigid(const Case& c, const Contact& contact) {
  return c.bodies[body_index(c, contact.rigid)].displacement.component;
}

}  // namespace

void BoundaryConditions::add_rigid_points(const Case& c, int contact, const Region& region, const Discretisation& d) {
  const Contact& spec = c.contacts[contact];
  const std::vector<Vec3> places = d.points_inside(region, spec.rigid);
  if (places.empty())
    throw InputError(
        fmt::format("[contact.{}]: kind = \"shared_nodes\" needs a background grid (method = \"mpm\"); "
                    "take \"tie\" or \"no_slip\"",
                    spec.name));
  for (const Vec3& x : places) {
    RigidPoint point;
    point.anchor = anchor_at(body_index(c, spec.body), x);
    point.anchor.rigid = true;
    point.id = static_cast<int>(rigid_points_.size());
    point.contact = contact;
    rigid_points_.push_back(point);
  }
}

void BoundaryConditions::read_contact(int contact, const Case& c, const Discretisation& d, const std::vector<SurfacePoint>& surface) {
  const Contact& spec = c.contacts[contact];
  const int rigid = body_index(c, spec.rigid), body = body_index(c, spec.body);
  const Region& region = rigid_regions_.try_emplace(rigid, *c.bodies[rigid].shape, cell_size_).first->second;
  if (spec.kind == Contact::Kind::shared_nodes) {
    add_rigid_points(c, contact, region, d);
    return;
  }
  const double factor = spec.stiffness * stiffness_of(c, body) / cell_size_;
  const double touching = 1e-3 * cell_size_;
  const std::size_t before = contacts_.size();
  // Chords of a mesh lie beside the shape that was meshed: the place that they stand for counts.
  std::optional<Region> meshed;
  if (c.method == Method::fem && c.bodies[body].shape) meshed.emplace(*c.bodies[body].shape, cell_size_);
  for (const SurfacePoint& s : surface) {
    if (s.body != body) continue;
    const Vec3 x = meshed ? meshed->nearest(s.X).point : s.X;
    if (spec.kind == Contact::Kind::tie && std::abs(region.nearest(x).distance) > touching) continue;
    ContactPoint point;
    point.anchor = anchor_at(body, s.X, s.normal);
    point.id = static_cast<int>(contacts_.size());
    point.contact = contact;
    point.stiffness = factor * s.area;
    point.beside = x - s.X;
    contacts_.push_back(point);
  }
  if (contacts_.size() == before)
    throw InputError(
        fmt::format("[contact.{}]: the surfaces of \"{}\" and \"{}\" do not touch, so nothing can be tied", spec.name,
                    spec.body, spec.rigid));
}

void BoundaryConditions::read_contacts(const Case& c, const Discretisation& d,
                                       const std::vector<SurfacePoint>& surface) {
  Findings found;
  for (std::size_t k = 0; k < c.contacts.size(); ++k) {
    rigid_of_contact_.push_back(body_index(c, c.contacts[k].rigid));
    if (c.contacts[k].other.empty()) found.look([&] { read_contact(static_cast<int>(k), c, d, surface); });  // else at the nodes of the grid
  }
  found.throw_if_any();
  const int taken = part_supports(contacts_, cell_size_, [&](const ContactPoint& p, const ContactPoint& q) {
    const Contact &a = c.contacts[p.contact], &b = c.contacts[q.contact];
    return a.kind == Contact::Kind::tie && b.kind == Contact::Kind::tie && a.body == b.body &&
           share_a_stage(a.stages, b.stages) && motion_of_rigid(c, a) != motion_of_rigid(c, b);
  });
  if (taken > 0) warnings_.push_back(fmt::format(parted, "rigid bodies to which a surface is tied"));
}

/// Nodes of cells that hold points of rigid bodies with shared nodes, on all processes.
void BoundaryConditions::share_nodes(const Discretisation& d) {
  moved_by_.assign(d.n_nodes(), -1);
  for (std::size_t k = 0; k < case_.contacts.size(); ++k) {
    if (case_.contacts[k].kind != Contact::Kind::shared_nodes || !acts(case_.contacts[k].stages)) continue;
    std::vector<char> shared(d.n_nodes(), 0);
    for (const RigidPoint& p : rigid_points_)
      if (p.contact == static_cast<int>(k))
        for (int i = 0; i < p.anchor.stencil->n; ++i) shared[p.anchor.stencil->node[i]] = 1;
    d.halo.add_to_owners(shared.data(), 1);
    d.halo.copy_to_ghosts(shared.data(), 1);
    for (int node = 0; node < d.n_nodes(); ++node)
      if (shared[node] && moved_by_[node] < 0) moved_by_[node] = static_cast<int>(k);
  }
}

void BoundaryConditions::find_gaps() {
  for (ContactPoint& p : contacts_) {
    if (case_.contacts[p.contact].kind == Contact::Kind::tie) continue;
    const int rigid = rigid_of_contact_[p.contact];
    const Region::Nearest nearest = rigid_regions_.at(rigid).nearest(p.anchor.X + p.anchor.u + p.anchor.F * p.beside - rigid_offset_[rigid]);
    p.normal = nearest.normal;
    p.gap = nearest.distance;
  }
}

Vec3 BoundaryConditions::rigid_step(int body, double t0, double t1) const {
  return case_.bodies[body].displacement.step(t0, t1);
}

bool BoundaryConditions::acts_on_something(int rigid_body) const {
  for (std::size_t k = 0; k < case_.contacts.size(); ++k)
    if (rigid_of_contact_[k] == rigid_body && acts(case_.contacts[k].stages)) return true;
  return false;
}

/// Tie: f = -k s. Unilateral: f = -k g n while g < 0, plus -k s_t without slip, and with friction what Coulomb's cone
/// lets through of that.   [boundaries (3), (4), (10), (11)]
BoundaryConditions::ContactForce BoundaryConditions::contact_force(const ContactPoint& point, const NodalVector& du,
                                                                   double t0, double t1) const {
  const Contact& spec = case_.contacts[point.contact];
  if (!acts(spec.stages)) return {};  // its slip begins anew
  const Vec3 rigid = rigid_step(rigid_of_contact_[point.contact], t0, t1);
  const Vec3 relative = point.anchor.stencil->interpolate(du) - rigid;
  const double k = point.stiffness;
  if (spec.kind == Contact::Kind::tie) {
    const Vec3 slip = point.slip + relative;
    return {-k * slip, k * Mat3::Identity(), true, slip};
  }
  // Surfaces that just touch count as closed, so that a body laid on another one is held from the first guess on.
  const double gap = point.gap + point.normal.dot(relative), touching = just_touching * cell_size_;
  const Mat3 nn = point.normal * point.normal.transpose(), tangential = Mat3::Identity() - nn;
  if (gap >= touching && !(point.gap < kept_closed_)) {
    ContactForce open{};
    if (spec.kind == Contact::Kind::friction)  // the shear at t_n works over half of the step, and its spring is let go
      open.heat = 0.5 * k * point.slip.dot(tangential * (point.slip + relative));
    return open;
  }
  const Vec3 push = -k * gap * point.normal;
  if (spec.kind == Contact::Kind::frictionless) return {push, k * nn, true};
  const Vec3 slip = tangential * (point.slip + relative);
  const double limit = spec.friction * std::max(0.0, -gap), size = slip.norm();  // over k
  if (spec.kind == Contact::Kind::no_slip || size <= limit) return {push - k * slip, k * Mat3::Identity(), true, slip};

  const Vec3 direction = slip / size;
  const double before = spec.friction * std::max(0.0, -point.gap);
  ContactForce sliding{push - k * limit * direction, k * nn, true, limit * direction};
  sliding.stiffness += k * (limit / size) * (tangential - direction * direction.transpose());
  sliding.stiffness += sliding_spring_ * k * direction * direction.transpose();
  if (gap < 0.0) sliding.stiffness -= k * spec.friction * (direction * point.normal.transpose());
  sliding.heat = 0.5 * k * (before + limit) * (size - limit);
  return sliding;
}

void BoundaryConditions::move_rigid(double time) {
  for (std::size_t b = 0; b < case_.bodies.size(); ++b) {
    if (!case_.bodies[b].rigid) continue;
    rigid_offset_[b] = case_.bodies[b].displacement.at(time);
    if (const double far = rigid_offset_[b].norm(); far > farthest_place)
      throw RunError(fmt::format("[body.{}] has moved by {:.3g} m at t = {:.6g} s: places must lie within {:g} m of the origin", case_.bodies[b].name, far, time, farthest_place));
  }
}

void BoundaryConditions::restore_rigid(double time) {
  move_rigid(time);
  for (RigidPoint& p : rigid_points_) {
    p.anchor.u = rigid_offset_[rigid_of_contact_[p.contact]];
    if (case_.kinematics == Kinematics::finite) p.anchor.x = p.anchor.X + p.anchor.u;
  }
}

}  // namespace berm
