/// What supports and rigid bodies do to the material, and their work.
#include <algorithm>

#include "bc/boundary.hpp"

namespace berm {

Reactions BoundaryConditions::reactions(const NodalVector& du, double t0, double t1,
                                        const NodalVector& residual) const {
  const std::size_t n_bodies = case_.bodies.size(), n_boundaries = case_.boundaries.size();
  std::vector<double> sums(3 * (n_bodies + n_boundaries), 0.0);
  const auto add = [&](std::size_t index, const Vec3& force) {
    for (int i = 0; i < 3; ++i) sums[3 * index + i] += force[i];
  };
  for (const ContactPoint& p : contacts_) add(rigid_of_contact_[p.contact], contact_force(p, du, t0, t1).force);
  for (int node = 0; node < n_owned_; ++node)
    if (moved_by_[node] >= 0) add(rigid_of_contact_[moved_by_[node]], residual[node]);
  for (const auto& [k, node] : local_conditions_) {
    const NodeCondition& condition = conditions_[k];
    if (node < n_owned_ && moved_by_[node] < 0)
      sums[3 * (n_bodies + condition.boundary) + condition.component] += residual[node][condition.component];
  }
  for (const LocalInclined& local : local_inclined_) {
    const int boundary = inclined_[local.index].boundary;
    add(n_bodies + boundary, -local.share * push_of(local, du, t0, t1) * *case_.boundaries[boundary].normal);
  }
  double held_work = 0.0;
  for (const HeldPoint& p : held_) {
    const Vec3 force = held_force(p, du, t0, t1);
    add(n_bodies + p.boundary, force);
    if (acts(case_.boundaries[p.boundary].stages)) held_work += 0.5 * (p.stiffness * p.missing + force).dot(held_step(p, t0, t1));
  }
  comm_.sum(sums);
  const auto vector_at = [&](std::size_t index) {
    return Vec3(sums[3 * index], sums[3 * index + 1], sums[3 * index + 2]);
  };
  Reactions out;
  out.held_work = comm_.sum(held_work);
  for (std::size_t b = 0; b < n_bodies; ++b) out.rigid.push_back(vector_at(b));
  for (std::size_t b = 0; b < n_boundaries; ++b) out.boundary.push_back(vector_at(n_bodies + b));
  if (by_place_) {
    out.node.assign(conditions_.size(), 0.0);
    for (const auto& [k, node] : local_conditions_)
      if (node < n_owned_ && moved_by_[node] < 0) out.node[k] += residual[node][conditions_[k].component];
    comm_.sum(out.node);
  }
  return out;
}

double BoundaryConditions::support_work(const Reactions& before, const Reactions& now, double t0, double t1) const {
  double work = now.held_work;
  for (std::size_t b = 0; b < case_.bodies.size(); ++b)
    if (case_.bodies[b].rigid && acts_on_something(static_cast<int>(b)))
      work += 0.5 * (now.rigid[b] + before.rigid[b]).dot(rigid_step(static_cast<int>(b), t0, t1));
  for (std::size_t b = 0; b < case_.boundaries.size(); ++b) {
    const NodeBoundary& spec = case_.boundaries[b];
    if (!acts(spec.stages) || !spec.body.empty()) continue;  // its force at t0 went with the last stage
    const Vec3 mean = 0.5 * (now.boundary[b] + before.boundary[b]);
    if (spec.normal) work += mean.dot(*spec.normal) * spec.un.step(t0, t1);
    if (spec.depends_on_place()) continue;
    for (int i = 0; i < dimension_; ++i)
      if (const auto& u = spec.u[i]) work += mean[i] * u->step(t0, t1);
  }
  for (std::size_t k = 0; k < now.node.size(); ++k) {
    const NodeCondition& c = conditions_[k];
    const NodeBoundary& spec = case_.boundaries[c.boundary];
    if (!spec.depends_on_place() || !acts(spec.stages)) continue;
    const TimeFunction& u = *spec.u[c.component];
    const double first = before.node.empty() ? 0.0 : before.node[k];
    work += 0.5 * (now.node[k] + first) * u.step(t0, t1, c.at);
  }
  return work;
}

ContactWork BoundaryConditions::contact_work(const NodalVector& du, double t0, double t1) const {
  ContactWork work = grid_contact_.work(du);
  for (const ContactPoint& p : contacts_) {
    const double heat = contact_force(p, du, t0, t1).heat;
    work.heat += std::max(0.0, heat);  // a spring that is let go while the body goes back gives some of its energy
    work.total += heat;
  }
  for (const PinPoint& p : pins_) {
    if (!acts(case_.pins[p.pin].stages)) continue;
    const Vec3 step = p.anchor.stencil->interpolate(du);
    work.total += p.stiffness.cwiseProduct(p.anchor.u - p.start + 0.5 * step).dot(step);
  }
  return {comm_.sum(work.total), comm_.sum(work.heat)};
}

}  // namespace berm
