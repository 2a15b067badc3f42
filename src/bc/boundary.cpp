#include "bc/boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace berm {
namespace {

int body_index(const Case& c, const std::string& name) {
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].name == name) return static_cast<int>(b);
  return -1;
}

double youngs_modulus(const Case& c, int body) {
  for (const Material& m : c.materials)
    if (m.name == c.bodies[body].material) return std::visit([](const auto& law) { return law.youngs_modulus; }, m.law);
  return 0.0;
}

/// Part of a surface piece that lies inside `where` [-]: the ends of a loaded arc seldom are ends of pieces.
double share_inside(const Where& where, const SurfacePoint& s) {
  constexpr int samples = 100;
  const Vec2 along = s.length * Vec2(-s.normal.y(), s.normal.x());
  int count = 0;
  for (int k = 0; k < samples; ++k) count += inside(where, s.anchor.X + ((k + 0.5) / samples - 0.5) * along);
  return double(count) / samples;
}

bool in_group(const SurfacePoint& s, const std::string& group) {
  return std::find(s.groups.begin(), s.groups.end(), group) != s.groups.end();
}

}  // namespace

BoundaryConditions::BoundaryConditions(const Case& c, const Discretisation& d, std::vector<BodySurface> surfaces,
                                       const std::map<std::string, std::vector<int>>& node_groups)
    : case_(c), thickness_(c.thickness) {
  for (BodySurface& s : surfaces) surface_.insert(surface_.end(), s.points.begin(), s.points.end());
  read_boundaries(c, d, node_groups);
  read_pressures(c);
  read_contacts(c, d);
  read_pins_and_gauges(c);
  for (const RigidContact& contact : contacts_) rigid_offset_[contact.rigid] = Vec2::Zero();

  // Only surface points that carry something have to be followed.
  std::vector<char> used(surface_.size(), 0);
  for (const PressureLoad& load : pressures_)
    for (int p : load.points) used[p] = 1;
  for (const RigidContact& contact : contacts_)
    for (const ContactPoint& p : contact.points) used[p.point] = 1;
  for (std::size_t p = 0; p < surface_.size(); ++p)
    if (used[p]) anchors_.push_back(&surface_[p].anchor);
  for (RigidContact& contact : contacts_)
    for (Anchor& a : contact.inside) anchors_.push_back(&a);
  for (PinPoint& pin : pins_) anchors_.push_back(&pin.anchor);
  for (GaugeLine& g : gauges_) {
    anchors_.push_back(&g.from);
    anchors_.push_back(&g.to);
  }
}

void BoundaryConditions::read_boundaries(const Case& c, const Discretisation& d,
                                         const std::map<std::string, std::vector<int>>& node_groups) {
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    const NodeBoundary& spec = c.boundaries[b];
    std::vector<int> candidates;
    if (spec.where.group) {
      const auto group = node_groups.find(*spec.where.group);
      if (group == node_groups.end())
        throw InputError(
            fmt::format("[boundary.{}]: no mesh has a physical curve named \"{}\"", spec.name, *spec.where.group));
      candidates = group->second;
    } else {
      for (int node = 0; node < d.n_nodes(); ++node) candidates.push_back(node);
    }
    bool any = false;
    for (int node : candidates) {
      if (!inside(spec.where, d.nodes[node])) continue;
      any = true;
      if (spec.ux) prescribe(node, 0, static_cast<int>(b), *spec.ux);
      if (spec.uy) prescribe(node, 1, static_cast<int>(b), *spec.uy);
    }
    if (!any)
      throw InputError(fmt::format("[boundary.{}] catches no node of the {}: check where.box", spec.name,
                                   c.method == Method::mpm ? "background grid" : "body meshes"));
  }
}

/// The first boundary owns a displacement; a second one may only repeat it.
void BoundaryConditions::prescribe(int node, int component, int boundary, double value) {
  const auto [owner, is_new] = owner_.try_emplace(2 * node + component, conditions_.size());
  if (is_new) {
    conditions_.push_back({node, component, boundary, value});
    return;
  }
  const NodeCondition& first = conditions_[owner->second];
  if (first.value != value)
    throw InputError(fmt::format(
        "[boundary.{}] and [boundary.{}] prescribe different displacements u{} of the same node: "
        "make their regions disjoint",
        case_.boundaries[first.boundary].name, case_.boundaries[boundary].name, component == 0 ? 'x' : 'y'));
}

void BoundaryConditions::read_pressures(const Case& c) {
  for (const Pressure& spec : c.pressures) {
    PressureLoad load;
    load.spec = &spec;
    const int body = body_index(c, spec.body);
    for (std::size_t p = 0; p < surface_.size(); ++p)
      if (surface_[p].anchor.body == body && (!spec.where.group || in_group(surface_[p], *spec.where.group)))
        if (const double share = share_inside(spec.where, surface_[p]); share > 0.0) {
          load.points.push_back(static_cast<int>(p));
          load.area.push_back(share * surface_[p].length * thickness_);
        }
    if (load.points.empty())
      throw InputError(fmt::format("[pressure.{}] catches no part of the surface of body \"{}\": check its where",
                                   spec.name, spec.body));
    pressures_.push_back(std::move(load));
  }
}

void BoundaryConditions::read_contacts(const Case& c, const Discretisation& d) {
  const double h = d.cell_size();
  for (const Contact& spec : c.contacts) {
    RigidContact contact;
    contact.spec = &spec;
    contact.rigid = body_index(c, spec.rigid);
    const int body = body_index(c, spec.body);
    const Region& region =
        rigid_regions_.try_emplace(contact.rigid, Region(*c.bodies[contact.rigid].shape)).first->second;
    if (spec.kind == Contact::Kind::shared_nodes) {
      for (const Vec2& x : d.points_inside(region, spec.rigid)) {
        Anchor a;
        a.body = contact.rigid;
        a.X = a.x = x;
        a.rigid = true;
        contact.inside.push_back(a);
      }
      if (contact.inside.empty())
        throw InputError(
            fmt::format("[contact.{}]: kind = \"shared_nodes\" needs a background grid (method = \"mpm\"); "
                        "take \"tie\" or \"no_slip\"",
                        spec.name));
      contacts_.push_back(std::move(contact));
      continue;
    }
    const double factor = spec.stiffness * youngs_modulus(c, body) / h * thickness_;
    const double touching = 1e-3 * h;
    for (std::size_t p = 0; p < surface_.size(); ++p) {
      if (surface_[p].anchor.body != body) continue;
      if (spec.kind == Contact::Kind::tie && std::abs(region.nearest(surface_[p].anchor.X).distance) > touching)
        continue;
      ContactPoint point;
      point.point = static_cast<int>(p);
      point.stiffness = factor * surface_[p].length;
      contact.points.push_back(point);
    }
    if (contact.points.empty())
      throw InputError(
          fmt::format("[contact.{}]: the surfaces of \"{}\" and \"{}\" do not touch, so nothing can be tied", spec.name,
                      spec.body, spec.rigid));
    contacts_.push_back(std::move(contact));
  }
}

void BoundaryConditions::read_pins_and_gauges(const Case& c) {
  for (const Pin& spec : c.pins) {
    PinPoint pin;
    pin.anchor.body = body_index(c, spec.body);
    pin.anchor.X = pin.anchor.x = spec.at;
    pin.x = spec.x;
    pin.y = spec.y;
    pin.stiffness = youngs_modulus(c, pin.anchor.body) * thickness_;
    pins_.push_back(pin);
  }
  for (const Gauge& spec : c.output.gauges) {
    GaugeLine g;
    g.name = spec.name;
    g.from.body = g.to.body = -1;
    g.from.X = g.from.x = spec.from;
    g.to.X = g.to.x = spec.to;
    g.direction = (spec.to - spec.from).normalized();
    // Each end belongs to the deformable body that holds it, or else to the first one.
    for (Anchor* a : {&g.from, &g.to})
      for (std::size_t b = 0; b < c.bodies.size(); ++b) {
        if (c.bodies[b].rigid) continue;
        if (a->body < 0) a->body = static_cast<int>(b);
        if (c.bodies[b].shape && Region(*c.bodies[b].shape).contains(a->X)) {
          a->body = static_cast<int>(b);
          break;
        }
      }
    gauges_.push_back(g);
  }
}

void BoundaryConditions::begin_step(const Discretisation& d) {
  equation_.assign(2 * d.n_nodes(), -1);
  std::vector<char> prescribed(2 * d.n_nodes(), 0);
  for (const NodeCondition& k : conditions_) prescribed[2 * k.node + k.component] = 1;
  moved_by_rigid_.clear();
  for (RigidContact& contact : contacts_) {
    std::set<int> shared;
    for (const Anchor& a : contact.inside) shared.insert(a.stencil.node.begin(), a.stencil.node.begin() + a.stencil.n);
    std::erase_if(shared, [&](int node) { return moved_by_rigid_.contains(node); });
    contact.shared_nodes.assign(shared.begin(), shared.end());
    for (int node : contact.shared_nodes) prescribed[2 * node] = prescribed[2 * node + 1] = 1;
    moved_by_rigid_.insert(shared.begin(), shared.end());
  }
  n_equations_ = 0;
  for (int node = 0; node < d.n_nodes(); ++node)
    for (int c = 0; c < 2; ++c)
      if (d.active[node] && !prescribed[2 * node + c]) equation_[2 * node + c] = n_equations_++;

  for (RigidContact& contact : contacts_) {
    if (contact.spec->kind == Contact::Kind::tie || contact.spec->kind == Contact::Kind::shared_nodes) continue;
    const Region& region = rigid_regions_.at(contact.rigid);
    for (ContactPoint& p : contact.points) {
      const Anchor& a = surface_[p.point].anchor;
      const Region::Nearest nearest = region.nearest(a.X + a.u - rigid_offset_[contact.rigid]);
      p.normal = nearest.normal;
      p.gap = nearest.distance;
    }
  }
}

std::vector<double> BoundaryConditions::prescribed_increment(double t0, double t1) const {
  std::vector<double> du(equation_.size(), 0.0);
  for (const NodeCondition& k : conditions_) du[2 * k.node + k.component] = k.value * (t1 - t0);
  for (const RigidContact& contact : contacts_)
    for (int node : contact.shared_nodes)
      for (int c : {0, 1}) du[2 * node + c] = case_.bodies[contact.rigid].displacement[c] * (t1 - t0);
  return du;
}

/// Tie: f = -k s. Unilateral: f = -k g n while g < 0, plus -k s_t without slip.   [boundaries (3), (4)]
BoundaryConditions::ContactForce BoundaryConditions::contact_force(const RigidContact& contact,
                                                                   const ContactPoint& point, const NodalVector& du,
                                                                   double t0, double t1) const {
  const Vec2 rigid = case_.bodies[contact.rigid].displacement * (t1 - t0);
  const Vec2 relative = surface_[point.point].anchor.stencil.interpolate(du) - rigid;
  const double k = point.stiffness;
  if (contact.spec->kind == Contact::Kind::tie) return {-k * (point.slip + relative), k * Mat2::Identity(), true};

  const double gap = point.gap + point.normal.dot(relative);
  if (gap >= 0.0) return {Vec2::Zero(), Mat2::Zero(), false};
  const Mat2 nn = point.normal * point.normal.transpose();
  if (contact.spec->kind == Contact::Kind::frictionless) return {-k * gap * point.normal, k * nn, true};
  const Mat2 tangential = Mat2::Identity() - nn;
  return {-k * gap * point.normal - k * (tangential * (point.slip + relative)), k * Mat2::Identity(), true};
}

void BoundaryConditions::add_forces(const NodalVector& du, double t0, double t1, NodalVector& f,
                                    BlockAssembler* matrix) const {
  std::array<double, 256> K;
  auto add = [&](const Anchor& a, const Vec2& force, const Mat2& stiffness) {
    const Stencil& s = a.stencil;
    for (int i = 0; i < s.n; ++i) f[s.node[i]] -= s.N[i] * force;
    if (!matrix) return;
    for (int i = 0; i < s.n; ++i)
      for (int j = 0; j < s.n; ++j)
        for (int p = 0; p < 2; ++p)
          for (int q = 0; q < 2; ++q) K[(2 * i + p) * 2 * s.n + 2 * j + q] = s.N[i] * s.N[j] * stiffness(p, q);
    matrix->add(a.block, K.data());
  };
  for (const RigidContact& contact : contacts_)
    for (const ContactPoint& p : contact.points) {
      const ContactForce c = contact_force(contact, p, du, t0, t1);
      if (c.active) add(surface_[p.point].anchor, c.force, c.stiffness);
    }
  for (const PinPoint& pin : pins_) {
    const Mat2 k = Vec2(pin.x ? pin.stiffness : 0.0, pin.y ? pin.stiffness : 0.0).asDiagonal();
    add(pin.anchor, -k * (pin.anchor.u + pin.anchor.stencil.interpolate(du)), k);
  }
}

void BoundaryConditions::add_pressure(NodalVector& f) const {
  for (const PressureLoad& load : pressures_)
    for (std::size_t i = 0; i < load.points.size(); ++i) {
      const SurfacePoint& s = surface_[load.points[i]];
      const Vec2 force = -load.spec->value * load.area[i] * s.normal;
      for (int k = 0; k < s.anchor.stencil.n; ++k) f[s.anchor.stencil.node[k]] += s.anchor.stencil.N[k] * force;
    }
}

void BoundaryConditions::commit(const NodalVector& du, double t0, double t1) {
  for (RigidContact& contact : contacts_) {
    const Vec2 rigid = case_.bodies[contact.rigid].displacement * (t1 - t0);
    const bool tie = contact.spec->kind == Contact::Kind::tie;
    for (ContactPoint& p : contact.points) {
      const Vec2 relative = surface_[p.point].anchor.stencil.interpolate(du) - rigid;
      if (tie) {
        p.slip += relative;
        continue;
      }
      const bool touches = p.gap + p.normal.dot(relative) < 0.0;
      p.slip = touches ? Vec2(p.slip + relative - p.normal * p.normal.dot(relative)) : Vec2::Zero();
    }
  }
  for (std::size_t b = 0; b < case_.bodies.size(); ++b)
    if (case_.bodies[b].rigid) rigid_offset_[static_cast<int>(b)] = case_.bodies[b].displacement * t1;
}

Vec2 BoundaryConditions::rigid_force(int body, const NodalVector& du, double t0, double t1,
                                     const NodalVector& residual) const {
  Vec2 sum = Vec2::Zero();
  for (const RigidContact& contact : contacts_) {
    if (contact.rigid != body) continue;
    for (const ContactPoint& p : contact.points) sum += contact_force(contact, p, du, t0, t1).force;
    for (int node : contact.shared_nodes) sum += residual[node];
  }
  return sum;
}

Vec2 BoundaryConditions::pressure_force(const std::string& name) const {
  Vec2 sum = Vec2::Zero();
  for (const PressureLoad& load : pressures_)
    if (load.spec->name == name)
      for (std::size_t i = 0; i < load.points.size(); ++i)
        sum -= load.spec->value * load.area[i] * surface_[load.points[i]].normal;
  return sum;
}

std::string BoundaryConditions::idle_boundary(const Discretisation& d) const {
  std::vector<char> works(case_.boundaries.size(), 0);
  for (const NodeCondition& k : conditions_)
    if (d.active[k.node]) works[k.boundary] = 1;
  for (const NodeCondition& k : conditions_)
    if (!works[k.boundary]) return case_.boundaries[k.boundary].name;
  return "";
}

Vec2 BoundaryConditions::boundary_force(int boundary, const NodalVector& residual) const {
  Vec2 sum = Vec2::Zero();
  for (const NodeCondition& k : conditions_)
    if (k.boundary == boundary && !moved_by_rigid_.contains(k.node)) sum[k.component] += residual[k.node][k.component];
  return sum;
}

}  // namespace berm
