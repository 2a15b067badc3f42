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

double stiffness_of(const Case& c, int body) {
  for (const Material& m : c.materials)
    if (m.name == c.bodies[body].material) return std::visit([](const auto& law) { return law.stiffness(); }, m.law);
  return 0.0;
}

/// Part of a surface piece that lies inside `where` [-]: the edges of a loaded region seldom are edges of pieces.
double share_inside(const Where& where, const SurfacePoint& s, int dimension) {
  int count = 0, all = 0;
  const auto look = [&](const Vec3& x) {
    count += inside(where, x);
    ++all;
  };
  if (dimension == 2) {
    const Vec3 along(-s.normal.y(), s.normal.x(), 0.0);
    for (int i = 0; i < 100; ++i) look(s.X + s.size * ((i + 0.5) / 100 - 0.5) * along);
    return double(count) / all;
  }
  // Equal parts of the triangle, or of the square that the quadrilateral is the image of.
  constexpr int n = 10;
  const auto& c = s.corner;
  const bool quadrilateral = s.n_corners == 4;
  const auto place = [&](double u, double v) {
    return quadrilateral ? Vec3((1.0 - u) * ((1.0 - v) * c[0] + v * c[3]) + u * ((1.0 - v) * c[1] + v * c[2]))
                         : Vec3(c[0] + u * (c[1] - c[0]) + v * (c[2] - c[0]));
  };
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      if (quadrilateral) {
        look(place((i + 0.5) / n, (j + 0.5) / n));
        continue;
      }
      if (i + j < n) look(place((i + 1.0 / 3.0) / n, (j + 1.0 / 3.0) / n));
      if (i + j < n - 1) look(place((i + 2.0 / 3.0) / n, (j + 2.0 / 3.0) / n));
    }
  return double(count) / all;
}

bool in_group(const SurfacePoint& s, const std::string& group) {
  return std::find(s.groups.begin(), s.groups.end(), group) != s.groups.end();
}

Anchor anchor_at(int body, const Vec3& x, const Vec3& normal = Vec3::Zero()) {
  Anchor a;
  a.body = body;
  a.X = a.x = x;
  a.inward = -normal;
  return a;
}

bool is_rigid_motion(Contact::Kind kind) { return kind == Contact::Kind::shared_nodes; }

}  // namespace

BoundaryConditions::BoundaryConditions(const Case& c, const Discretisation& d, const std::vector<SurfacePoint>& surface)
    : case_(c),
      comm_(d.comm()),
      dimension_(d.dimension()),
      cell_size_(d.cell_size()),
      rigid_offset_(c.bodies.size(), Vec3::Zero()) {
  read_boundaries(c, d);
  read_pressures(c, surface);
  read_contacts(c, d, surface);
  read_pins_and_gauges(c, d);
  if (comm_.is_root()) return;
  pressures_.clear(), contacts_.clear(), rigid_points_.clear(), pins_.clear();
}

void BoundaryConditions::read_boundaries(const Case& c, const Discretisation& d) {
  const Mesh& mesh = d.mesh();
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    const NodeBoundary& spec = c.boundaries[b];
    const std::vector<int>* group = nullptr;
    if (spec.where.group) {
      const auto found = mesh.node_groups.find(*spec.where.group);
      if (found == mesh.node_groups.end())
        throw InputError(fmt::format("[boundary.{}]: no mesh has a physical {} named \"{}\"", spec.name,
                                     dimension_ == 3 ? "surface" : "curve", *spec.where.group));
      group = &found->second;
    }
    bool any = false;
    const int n = group ? static_cast<int>(group->size()) : mesh.n_nodes();
    for (int k = 0; k < n; ++k) {
      const int node = group ? (*group)[k] : k;
      if (!inside(spec.where, mesh.nodes[node])) continue;
      any = true;
      for (int i = 0; i < dimension_; ++i)
        if (spec.u[i]) prescribe(node, i, static_cast<int>(b));
    }
    if (!any)
      throw InputError(fmt::format("[boundary.{}] catches no node of the {}: check where.box", spec.name,
                                   c.method == Method::mpm ? "background grid" : "body meshes"));
  }
}

/// The first boundary owns a displacement; a second one may only repeat it.
void BoundaryConditions::prescribe(int node, int component, int boundary) {
  const auto [owner, is_new] = owner_.try_emplace({node, component}, conditions_.size());
  if (is_new) {
    conditions_.push_back({node, component, boundary});
    return;
  }
  const NodeCondition& first = conditions_[owner->second];
  if (case_.boundaries[first.boundary].u[component] != case_.boundaries[boundary].u[component])
    throw InputError(
        fmt::format("[boundary.{}] and [boundary.{}] prescribe different displacements u{} of the same node: "
                    "make their regions disjoint",
                    case_.boundaries[first.boundary].name, case_.boundaries[boundary].name, "xyz"[component]));
}

void BoundaryConditions::read_pressures(const Case& c, const std::vector<SurfacePoint>& surface) {
  for (std::size_t k = 0; k < c.pressures.size(); ++k) {
    const Pressure& spec = c.pressures[k];
    const int body = body_index(c, spec.body);
    bool any = false;
    for (const SurfacePoint& s : surface) {
      if (s.body != body || (spec.where.group && !in_group(s, *spec.where.group))) continue;
      const double share = share_inside(spec.where, s, dimension_);
      if (share == 0.0) continue;
      PressurePoint point;
      point.anchor = anchor_at(body, s.X, s.normal);
      point.id = static_cast<int>(pressures_.size());
      point.load = static_cast<int>(k);
      point.area = -share * s.area * s.normal;
      any = true;
      pressures_.push_back(point);
    }
    if (!any)
      throw InputError(fmt::format("[pressure.{}] catches no part of the surface of body \"{}\": check its where",
                                   spec.name, spec.body));
  }
}

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
    point.anchor = anchor_at(rigid_of_contact_[contact], x);
    point.anchor.rigid = true;
    point.id = static_cast<int>(rigid_points_.size());
    point.contact = contact;
    rigid_points_.push_back(point);
  }
}

void BoundaryConditions::read_contacts(const Case& c, const Discretisation& d,
                                       const std::vector<SurfacePoint>& surface) {
  for (std::size_t k = 0; k < c.contacts.size(); ++k) {
    const Contact& spec = c.contacts[k];
    const int rigid = body_index(c, spec.rigid), body = body_index(c, spec.body);
    rigid_of_contact_.push_back(rigid);
    const Region& region = rigid_regions_.try_emplace(rigid, *c.bodies[rigid].shape, cell_size_).first->second;
    if (is_rigid_motion(spec.kind)) {
      add_rigid_points(c, static_cast<int>(k), region, d);
      continue;
    }
    const double factor = spec.stiffness * stiffness_of(c, body) / cell_size_;
    const double touching = 1e-3 * cell_size_;
    const std::size_t before = contacts_.size();
    for (const SurfacePoint& s : surface) {
      if (s.body != body) continue;
      if (spec.kind == Contact::Kind::tie && std::abs(region.nearest(s.X).distance) > touching) continue;
      ContactPoint point;
      point.anchor = anchor_at(body, s.X, s.normal);
      point.id = static_cast<int>(contacts_.size());
      point.contact = static_cast<int>(k);
      point.stiffness = factor * s.area;
      contacts_.push_back(point);
    }
    if (contacts_.size() == before)
      throw InputError(
          fmt::format("[contact.{}]: the surfaces of \"{}\" and \"{}\" do not touch, so nothing can be tied", spec.name,
                      spec.body, spec.rigid));
  }
}

void BoundaryConditions::read_pins_and_gauges(const Case& c, const Discretisation& d) {
  for (const Pin& spec : c.pins) {
    PinPoint pin;
    const int body = body_index(c, spec.body);
    pin.anchor = anchor_at(body, spec.at);
    pin.id = static_cast<int>(pins_.size());
    for (int i = 0; i < dimension_; ++i)
      if (spec.fixed[i]) pin.stiffness[i] = stiffness_of(c, body) * (is_plane(c.space) ? c.thickness : d.cell_size());
    pins_.push_back(pin);
  }
  std::map<int, Region> regions;
  for (const Gauge& spec : c.output.gauges) {
    GaugeLine g;
    g.name = spec.name;
    g.from = anchor_at(-1, spec.from);
    g.to = anchor_at(-1, spec.to);
    g.direction = (spec.to - spec.from).normalized();
    // Each end belongs to the deformable body that holds it, or else to the first one.
    for (Anchor* a : {&g.from, &g.to})
      for (std::size_t b = 0; b < c.bodies.size(); ++b) {
        if (c.bodies[b].rigid) continue;
        if (a->body < 0) a->body = static_cast<int>(b);
        if (!c.bodies[b].shape) continue;
        const int index = static_cast<int>(b);
        if (regions.try_emplace(index, *c.bodies[b].shape, cell_size_).first->second.contains(a->X)) {
          a->body = index;
          break;
        }
      }
    gauges_.push_back(g);
  }
}

template <class Point>
void BoundaryConditions::travel(std::vector<Point>& points, const Discretisation& d) {
  std::vector<int> owner;
  comm_.agree([&] {
    for (Point& p : points) owner.push_back(d.locate(p.anchor));
  });
  const bool leaving = std::any_of(owner.begin(), owner.end(), [&](int rank) { return rank != comm_.rank(); });
  if (!comm_.any(leaving)) return;
  std::vector<std::vector<Point>> to(comm_.size());
  for (std::size_t k = 0; k < points.size(); ++k) to[owner[k]].push_back(points[k]);
  points = std::move(to[comm_.rank()]);
  to[comm_.rank()].clear();
  for (const auto& from : comm_.exchange(to)) points.insert(points.end(), from.begin(), from.end());
  std::sort(points.begin(), points.end(), [](const Point& a, const Point& b) { return a.id < b.id; });
}

void BoundaryConditions::move_anchors(const Discretisation& d) {
  travel(pressures_, d);
  travel(contacts_, d);
  travel(rigid_points_, d);
  travel(pins_, d);
  comm_.agree([&] {
    for (GaugeLine& g : gauges_) {
      g.from_here = d.locate(g.from) == comm_.rank();
      g.to_here = d.locate(g.to) == comm_.rank();
    }
  });
  anchors_.clear();
  for (PressurePoint& p : pressures_) anchors_.push_back(&p.anchor);
  for (ContactPoint& p : contacts_) anchors_.push_back(&p.anchor);
  for (RigidPoint& p : rigid_points_) anchors_.push_back(&p.anchor);
  for (PinPoint& p : pins_) anchors_.push_back(&p.anchor);
  for (GaugeLine& g : gauges_) {
    if (g.from_here) anchors_.push_back(&g.from);
    if (g.to_here) anchors_.push_back(&g.to);
  }
}

/// Nodes of cells that hold points of rigid bodies with shared nodes, on all processes.
void BoundaryConditions::share_nodes(const Discretisation& d) {
  moved_by_.assign(d.n_nodes(), -1);
  for (std::size_t k = 0; k < case_.contacts.size(); ++k) {
    if (!is_rigid_motion(case_.contacts[k].kind)) continue;
    std::vector<char> shared(d.n_nodes(), 0);
    for (const RigidPoint& p : rigid_points_)
      if (p.contact == static_cast<int>(k))
        for (int i = 0; i < p.anchor.stencil.n; ++i) shared[p.anchor.stencil.node[i]] = 1;
    d.halo.add_to_owners(shared.data(), 1);
    d.halo.copy_to_ghosts(shared.data(), 1);
    for (int node = 0; node < d.n_nodes(); ++node)
      if (shared[node] && moved_by_[node] < 0) moved_by_[node] = static_cast<int>(k);
  }
}

void BoundaryConditions::begin_step(const Discretisation& d) {
  n_owned_ = d.halo.n_owned;
  if (connectivity_ != d.connectivity) {
    connectivity_ = d.connectivity;
    local_conditions_.clear();
    for (std::size_t k = 0; k < conditions_.size(); ++k)
      if (const int node = d.halo.find(conditions_[k].node); node >= 0)
        local_conditions_.emplace_back(static_cast<int>(k), node);
  }
  fixed_.assign(static_cast<std::size_t>(dimension_) * d.n_nodes(), 0);
  for (const auto& [k, node] : local_conditions_) fixed_[dimension_ * node + conditions_[k].component] = 1;
  share_nodes(d);
  for (int node = 0; node < d.n_nodes(); ++node)
    if (moved_by_[node] >= 0)
      for (int i = 0; i < dimension_; ++i) fixed_[dimension_ * node + i] = 1;
  n_free_ = comm_.sum(long(std::count(fixed_.begin(), fixed_.begin() + dimension_ * n_owned_, 0)));

  for (ContactPoint& p : contacts_) {
    if (case_.contacts[p.contact].kind == Contact::Kind::tie) continue;
    const int rigid = rigid_of_contact_[p.contact];
    const Region::Nearest nearest = rigid_regions_.at(rigid).nearest(p.anchor.X + p.anchor.u - rigid_offset_[rigid]);
    p.normal = nearest.normal;
    p.gap = nearest.distance;
  }
}

std::vector<double> BoundaryConditions::prescribed_increment(double t0, double t1) const {
  std::vector<double> du(fixed_.size(), 0.0);
  for (const auto& [k, node] : local_conditions_) {
    const NodeCondition& c = conditions_[k];
    const TimeFunction& u = *case_.boundaries[c.boundary].u[c.component];
    du[dimension_ * node + c.component] = u.at(t1) - u.at(t0);
  }
  for (std::size_t node = 0; node < moved_by_.size(); ++node) {
    if (moved_by_[node] < 0) continue;
    const Vec3 motion = rigid_step(rigid_of_contact_[moved_by_[node]], t0, t1);
    for (int i = 0; i < dimension_; ++i) du[dimension_ * node + i] = motion[i];
  }
  return du;
}

Vec3 BoundaryConditions::rigid_step(int body, double t0, double t1) const {
  const VectorFunction& motion = case_.bodies[body].displacement;
  return motion.at(t1) - motion.at(t0);
}

/// Tie: f = -k s. Unilateral: f = -k g n while g < 0, plus -k s_t without slip.   [boundaries (3), (4)]
BoundaryConditions::ContactForce BoundaryConditions::contact_force(const ContactPoint& point, const NodalVector& du,
                                                                   double t0, double t1) const {
  const Contact::Kind kind = case_.contacts[point.contact].kind;
  const Vec3 rigid = rigid_step(rigid_of_contact_[point.contact], t0, t1);
  const Vec3 relative = point.anchor.stencil.interpolate(du) - rigid;
  const double k = point.stiffness;
  if (kind == Contact::Kind::tie) return {-k * (point.slip + relative), k * Mat3::Identity(), true};

  const double gap = point.gap + point.normal.dot(relative);
  if (gap >= 0.0) return {Vec3::Zero(), Mat3::Zero(), false};
  const Mat3 nn = point.normal * point.normal.transpose();
  if (kind == Contact::Kind::frictionless) return {-k * gap * point.normal, k * nn, true};
  const Mat3 tangential = Mat3::Identity() - nn;
  return {-k * gap * point.normal - k * (tangential * (point.slip + relative)), k * Mat3::Identity(), true};
}

void BoundaryConditions::add_forces(const NodalVector& du, double t0, double t1, NodalVector& f,
                                    BlockAssembler* matrix) const {
  const int d = dimension_;
  std::vector<double> K;
  auto add = [&](const Anchor& a, const Vec3& force, const Mat3& stiffness) {
    const Stencil& s = a.stencil;
    for (int i = 0; i < s.n; ++i) f[s.node[i]] -= s.N[i] * force;
    if (!matrix) return;
    const int width = d * s.n;
    K.resize(std::size_t(width) * width);
    for (int i = 0; i < s.n; ++i)
      for (int j = 0; j < s.n; ++j)
        for (int p = 0; p < d; ++p)
          for (int q = 0; q < d; ++q) K[(d * i + p) * width + d * j + q] = s.N[i] * s.N[j] * stiffness(p, q);
    matrix->add(a.block, K.data());
  };
  for (const ContactPoint& p : contacts_) {
    const ContactForce c = contact_force(p, du, t0, t1);
    if (c.active) add(p.anchor, c.force, c.stiffness);
  }
  for (const PinPoint& pin : pins_) {
    const Mat3 k = pin.stiffness.asDiagonal();
    add(pin.anchor, -k * (pin.anchor.u + pin.anchor.stencil.interpolate(du)), k);
  }
}

Vec3 BoundaryConditions::force_of(const PressurePoint& point, double time) const {
  const Pressure& spec = case_.pressures[point.load];
  // [boundaries (6), (6a)]
  if (spec.traction) return spec.traction->at(time, point.anchor.x) * point.area.norm();
  return spec.value.at(time, point.anchor.x) * point.area;
}

void BoundaryConditions::add_pressure(double time, NodalVector& f) const {
  for (const PressurePoint& p : pressures_) {
    const Vec3 force = force_of(p, time);
    const Stencil& s = p.anchor.stencil;
    for (int k = 0; k < s.n; ++k) f[s.node[k]] += s.N[k] * force;
  }
}

std::vector<Vec3> BoundaryConditions::pressure_forces(double time) const {
  std::vector<double> sums(3 * case_.pressures.size(), 0.0);
  for (const PressurePoint& p : pressures_) {
    const Vec3 force = force_of(p, time);
    for (int i = 0; i < 3; ++i) sums[3 * p.load + i] += force[i];
  }
  comm_.sum(sums);
  std::vector<Vec3> forces;
  for (std::size_t k = 0; k < sums.size(); k += 3) forces.emplace_back(sums[k], sums[k + 1], sums[k + 2]);
  return forces;
}

void BoundaryConditions::commit(const NodalVector& du, double t0, double t1) {
  for (ContactPoint& p : contacts_) {
    const Vec3 rigid = rigid_step(rigid_of_contact_[p.contact], t0, t1);
    const Vec3 relative = p.anchor.stencil.interpolate(du) - rigid;
    if (case_.contacts[p.contact].kind == Contact::Kind::tie) {
      p.slip += relative;
      continue;
    }
    const bool touches = p.gap + p.normal.dot(relative) < 0.0;
    p.slip = touches ? Vec3(p.slip + relative - p.normal * p.normal.dot(relative)) : Vec3::Zero();
  }
  for (std::size_t b = 0; b < case_.bodies.size(); ++b)
    if (case_.bodies[b].rigid) rigid_offset_[b] = case_.bodies[b].displacement.at(t1);
}

void BoundaryConditions::share_gauges() {
  std::vector<double> values;
  for (const GaugeLine& g : gauges_)
    for (const auto& [anchor, here] : {std::pair(&g.from, g.from_here), std::pair(&g.to, g.to_here)})
      for (const Vec3* v : {&anchor->x, &anchor->u})
        for (int i = 0; i < 3; ++i) values.push_back(here ? (*v)[i] : 0.0);
  comm_.sum(values);
  const double* value = values.data();
  for (GaugeLine& g : gauges_)
    for (Anchor* a : {&g.from, &g.to})
      for (Vec3* v : {&a->x, &a->u}) {
        *v = Vec3(value[0], value[1], value[2]);
        value += 3;
      }
}

void BoundaryConditions::add_gauge_functional(int gauge, NodalVector& functional) const {
  const GaugeLine& g = gauges_[gauge];
  const auto add = [&](const Stencil& s, double sign) {
    for (int k = 0; k < s.n; ++k) functional[s.node[k]] += sign * s.N[k] * g.direction;
  };
  if (g.to_here) add(g.to.stencil, 1.0);
  if (g.from_here) add(g.from.stencil, -1.0);
}

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
  comm_.sum(sums);
  const auto vector_at = [&](std::size_t index) {
    return Vec3(sums[3 * index], sums[3 * index + 1], sums[3 * index + 2]);
  };
  Reactions out;
  for (std::size_t b = 0; b < n_bodies; ++b) out.rigid.push_back(vector_at(b));
  for (std::size_t b = 0; b < n_boundaries; ++b) out.boundary.push_back(vector_at(n_bodies + b));
  return out;
}

std::string BoundaryConditions::idle_boundary() const {
  std::vector<double> works(case_.boundaries.size(), 0.0);
  for (const auto& [k, node] : local_conditions_) works[conditions_[k].boundary] += 1.0;
  comm_.sum(works);
  for (const NodeCondition& k : conditions_)
    if (works[k.boundary] == 0.0) return case_.boundaries[k.boundary].name;
  return "";
}

// ---- checkpoints

namespace {

void append_row(std::vector<double>& rows, int id, const Anchor& a, const Vec3& slip = Vec3::Zero()) {
  rows.push_back(id);
  for (const Vec3* v : {&a.x, &a.u, &slip}) rows.insert(rows.end(), v->data(), v->data() + 3);
}

void restore_anchor(Anchor& a, const double* row) {
  a.x = Vec3(row[1], row[2], row[3]);
  a.u = Vec3(row[4], row[5], row[6]);
}

/// The point of that number, or null if another process has it. Ids ascend.
template <class Point>
Point* point_of(std::vector<Point>& points, int id) {
  const auto found =
      std::lower_bound(points.begin(), points.end(), id, [](const Point& p, int number) { return p.id < number; });
  return found == points.end() || found->id != id ? nullptr : &*found;
}

}  // namespace

std::vector<double> BoundaryConditions::rows(int kind) const {
  std::vector<double> rows;
  if (kind == 0)
    for (const ContactPoint& p : contacts_) append_row(rows, p.id, p.anchor, p.slip);
  if (kind == 1)
    for (const PressurePoint& p : pressures_) append_row(rows, p.id, p.anchor);
  if (kind == 2)
    for (const PinPoint& p : pins_) append_row(rows, p.id, p.anchor);
  if (kind == 3 && comm_.is_root())
    for (std::size_t g = 0; g < gauges_.size(); ++g) {
      append_row(rows, static_cast<int>(2 * g), gauges_[g].from);
      append_row(rows, static_cast<int>(2 * g + 1), gauges_[g].to);
    }
  return rows;
}

void BoundaryConditions::restore(int kind, const std::vector<double>& rows) {
  for (std::size_t k = 0; k < rows.size(); k += row_width) {
    const double* row = rows.data() + k;
    const int id = static_cast<int>(row[0]);
    if (kind == 0)
      if (ContactPoint* p = point_of(contacts_, id)) {
        restore_anchor(p->anchor, row);
        p->slip = Vec3(row[7], row[8], row[9]);
      }
    if (kind == 1)
      if (PressurePoint* p = point_of(pressures_, id)) restore_anchor(p->anchor, row);
    if (kind == 2)
      if (PinPoint* p = point_of(pins_, id)) restore_anchor(p->anchor, row);
    if (kind == 3 && id < 2 * static_cast<int>(gauges_.size()))
      restore_anchor(id % 2 == 0 ? gauges_[id / 2].from : gauges_[id / 2].to, row);
  }
}

void BoundaryConditions::restore_rigid(double time) {
  for (std::size_t b = 0; b < case_.bodies.size(); ++b)
    if (case_.bodies[b].rigid) rigid_offset_[b] = case_.bodies[b].displacement.at(time);
  for (RigidPoint& p : rigid_points_) {
    p.anchor.u = rigid_offset_[p.anchor.body];
    if (case_.kinematics == Kinematics::finite) p.anchor.x = p.anchor.X + p.anchor.u;
  }
}

}  // namespace berm
