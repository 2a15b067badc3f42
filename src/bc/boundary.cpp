#include "bc/boundary.hpp"

#include <algorithm>

#include "base/findings.hpp"
#include "bc/case_lookup.hpp"
#include "bc/travel.hpp"

namespace berm {

std::vector<int> fields_of_bodies(const Case& c) {
  std::vector<int> field(c.bodies.size(), 0);
  int n = 0;
  for (const Contact& contact : c.contacts)
    if (!contact.other.empty() && contact.kind != Contact::Kind::tie)
      for (const std::string& name : {contact.body, contact.other})
        if (int& f = field[body_index(c, name)]; f == 0) f = ++n;
  return field;
}

BoundaryConditions::BoundaryConditions(const Case& c, const Discretisation& d, const std::vector<SurfacePoint>& surface,
                                       const std::vector<Joint>& joints)
    : case_(c),
      comm_(d.comm()),
      dimension_(d.dimension()),
      cell_size_(d.cell_size()),
      rigid_offset_(c.bodies.size(), Vec3::Zero()),
      ties_(c, joints, d.cell_size(), d.comm()) {
  Findings found;
  found.look([&] { read_boundaries(c, d); });
  found.look([&] { read_pressures(c, surface); });
  found.look([&] { read_absorbing(c, surface); });
  found.look([&] { read_held_surfaces(c, surface); });
  found.look([&] { read_contacts(c, d, surface); });
  found.look([&] { read_pins_and_gauges(c, d); });
  found.throw_if_any();
  boundaries_at_.clear();
  begin_stage(c.stages.empty() ? "" : c.stages.front().name);
  if (comm_.is_root()) return;
  pressures_.clear(), dashpots_.clear(), held_.clear(), contacts_.clear(), rigid_points_.clear(), pins_.clear();
  ties_.points().clear();
}

void BoundaryConditions::begin_stage(const std::string& name) {
  std::vector<char> held;
  for (const PinPoint& p : pins_) held.push_back(acts(case_.pins[p.pin].stages));
  stage_ = name;
  connectivity_ = -1;
  for (std::size_t k = 0; k < pins_.size(); ++k)
    if (!held[k]) pins_[k].start = pins_[k].anchor.u;  // it holds its place of now
  std::vector<FieldContact> contacts;
  const std::vector<int> field = fields_of_bodies(case_);
  for (const Contact& c : case_.contacts) {
    if (c.other.empty() || c.kind == Contact::Kind::tie || !acts(c.stages)) continue;
    const int a = body_index(case_, c.body), b = body_index(case_, c.other);
    const double youngs = std::min(stiffness_of(case_, a), stiffness_of(case_, b));
    contacts.push_back(
        {std::min(field[a], field[b]), std::max(field[a], field[b]), c.friction, c.stiffness * youngs / cell_size_});
  }
  grid_contact_.set(std::move(contacts));
  ties_.begin_stage([this](const Stages& stages) { return acts(stages); });
}

bool BoundaryConditions::acts(const Stages& stages) const { return acts_in(stages, stage_); }

void BoundaryConditions::move_anchors(const Discretisation& d) {
  travel(pressures_, d);
  travel(dashpots_, d);
  travel(held_, d);
  travel(contacts_, d);
  travel(rigid_points_, d);
  travel(pins_, d);
  ties_.move(d);
  comm_.agree([&] {
    for (GaugeLine& g : gauges_) {
      g.from_here = d.locate(g.from) == comm_.rank();
      g.to_here = d.locate(g.to) == comm_.rank();
    }
  });
  anchors_.clear();
  for (PressurePoint& p : pressures_) anchors_.push_back(&p.anchor);
  for (DashpotPoint& p : dashpots_) anchors_.push_back(&p.anchor);
  for (HeldPoint& p : held_) anchors_.push_back(&p.anchor);
  for (ContactPoint& p : contacts_) anchors_.push_back(&p.anchor);
  for (RigidPoint& p : rigid_points_) anchors_.push_back(&p.anchor);
  for (PinPoint& p : pins_) anchors_.push_back(&p.anchor);
  for (Anchor& a : ties_.keepers()) anchors_.push_back(&a);
  for (GaugeLine& g : gauges_) {
    if (g.from_here) anchors_.push_back(&g.from);
    if (g.to_here) anchors_.push_back(&g.to);
  }
}

void BoundaryConditions::begin_step(const Discretisation& d) {
  n_owned_ = d.halo.n_owned;
  if (connectivity_ != d.connectivity) {
    connectivity_ = d.connectivity;
    find_prescribed(d);
    find_inclined(d);
  }
  fixed_.assign(static_cast<std::size_t>(dimension_) * d.n_nodes(), 0);
  for (const auto& [k, node] : local_conditions_) fixed_[dimension_ * node + conditions_[k].component] = 1;
  for (int node : d.scalar_nodes())
    for (int i = 1; i < dimension_; ++i) fixed_[dimension_ * node + i] = 1;
  share_nodes(d);
  for (int node = 0; node < d.n_nodes(); ++node)
    if (moved_by_[node] >= 0)
      for (int i = 0; i < dimension_; ++i) fixed_[dimension_ * node + i] = 1;
  n_free_ = comm_.sum(long(std::count(fixed_.begin(), fixed_.begin() + dimension_ * n_owned_, 0)));
  find_gaps();
}

void BoundaryConditions::add_at(const Anchor& a, const Vec3& force, const Mat3& stiffness, NodalVector& f,
                                BlockAssembler* matrix) const {
  const Stencil& s = *a.stencil;
  for (int i = 0; i < s.n; ++i) f[s.node[i]] -= s.N[i] * force;
  if (!matrix) return;
  const int d = dimension_, width = d * s.n;
  std::vector<double> K(std::size_t(width) * width);
  for (int i = 0; i < s.n; ++i)
    for (int j = 0; j < s.n; ++j)
      for (int p = 0; p < d; ++p)
        for (int q = 0; q < d; ++q) K[(d * i + p) * width + d * j + q] = s.N[i] * s.N[j] * stiffness(p, q);
  matrix->add(a.block, K.data());
}

void BoundaryConditions::add_forces(const Discretisation& discretisation, const NodalVector& du, double t0, double t1,
                                    NodalVector& f, BlockAssembler* matrix) const {
  const int d = dimension_;
  std::vector<double> K;
  for (const ContactPoint& p : contacts_) {
    const ContactForce c = contact_force(p, du, t0, t1);
    if (c.active) add_at(p.anchor, c.force, c.stiffness, f, matrix);
  }
  grid_contact_.add_forces(discretisation, du, f, matrix);
  ties_.add_forces(du, f, matrix);
  for (const PinPoint& pin : pins_) {
    if (!acts(case_.pins[pin.pin].stages)) continue;
    const Mat3 k = pin.stiffness.asDiagonal();
    add_at(pin.anchor, -k * (pin.anchor.u - pin.start + pin.anchor.stencil->interpolate(du)), k, f, matrix);
  }
  for (const HeldPoint& p : held_)
    if (acts(case_.boundaries[p.boundary].stages))
      add_at(p.anchor, held_force(p, du, t0, t1), p.stiffness * held_directions(p), f, matrix);
  for (const LocalInclined& local : local_inclined_) {
    const InclinedNode& node = inclined_[local.index];
    const Vec3& normal = *case_.boundaries[node.boundary].normal;
    f[local.node] += local.share * push_of(local, du, t0, t1) * normal;
    if (!matrix) continue;
    const int width = d * matrix->nodes_of(local.block);
    K.assign(std::size_t(width) * width, 0.0);
    for (int p = 0; p < d; ++p)
      for (int q = 0; q < d; ++q)
        K[(d * local.place + p) * width + d * local.place + q] = local.share * node.stiffness * normal[p] * normal[q];
    matrix->add(local.block, K.data());
  }
}

bool BoundaryConditions::symmetric() const {
  for (const Pressure& p : case_.pressures)
    if (follows(p) || (case_.kinematics == Kinematics::finite && p.value.depends_on_place())) return false;
  const bool at_rest = std::any_of(case_.stages.begin(), case_.stages.end(), [&](const Stage& s) { return s.name == stage_ && s.steps.analysis == Analysis::quasi_static; });
  return std::none_of(case_.contacts.begin(), case_.contacts.end(), [&](const Contact& c) {
    return c.kind == Contact::Kind::friction && (c.other.empty() || (at_rest && acts(c.stages)));  // in motion [contact (7)] is symmetric
  });
}

void BoundaryConditions::commit(const Discretisation& d, const NodalVector& du, double t0, double t1) {
  grid_contact_.commit(d, du);
  for (ContactPoint& p : contacts_) p.slip = contact_force(p, du, t0, t1).slip;
  commit_held_surfaces(du, t0, t1);
  ties_.commit(du);
  if (!inclined_.empty()) {
    std::vector<double> push(inclined_.size(), 0.0);
    for (const LocalInclined& local : local_inclined_) push[local.index] += local.share * push_of(local, du, t0, t1);
    comm_.sum(push);
    for (std::size_t k = 0; k < push.size(); ++k) inclined_[k].push = push[k];
  }
  move_rigid(t1);
}

}  // namespace berm
