#include "bc/boundary.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "base/error.hpp"
#include "method/depth.hpp"

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

bool share_a_stage(const Stages& a, const Stages& b) {
  return a.empty() || b.empty() || std::find_first_of(a.begin(), a.end(), b.begin(), b.end()) != a.end();
}

/// Stiffness of an inclined node, in units of E t (in space E h).
constexpr double inclined_penalty = 1e6;

bool is_rigid_motion(Contact::Kind kind) { return kind == Contact::Kind::shared_nodes; }

}  // namespace

std::vector<int> fields_of_bodies(const Case& c) {
  std::vector<int> field(c.bodies.size(), 0);
  int n = 0;
  for (const Contact& contact : c.contacts)
    if (!contact.other.empty())
      for (const std::string& name : {contact.body, contact.other})
        if (int& f = field[body_index(c, name)]; f == 0) f = ++n;
  return field;
}

BoundaryConditions::BoundaryConditions(const Case& c, const Discretisation& d, const std::vector<SurfacePoint>& surface)
    : case_(c),
      comm_(d.comm()),
      dimension_(d.dimension()),
      cell_size_(d.cell_size()),
      rigid_offset_(c.bodies.size(), Vec3::Zero()) {
  read_boundaries(c, d);
  read_pressures(c, surface);
  read_absorbing(c, surface);
  read_contacts(c, d, surface);
  read_pins_and_gauges(c, d);
  boundaries_at_.clear();
  begin_stage(c.stages.empty() ? "" : c.stages.front().name);
  if (comm_.is_root()) return;
  pressures_.clear(), dashpots_.clear(), contacts_.clear(), rigid_points_.clear(), pins_.clear();
}

void BoundaryConditions::read_boundaries(const Case& c, const Discretisation& d) {
  const Mesh& mesh = d.mesh();
  double youngs = 0.0;
  for (const Material& m : c.materials)
    youngs = std::max(youngs, std::visit([](const auto& law) { return law.stiffness(); }, m.law));
  const double stiffness = inclined_penalty * youngs * (dimension_ == 3 ? d.cell_size() : 1.0);
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
      const Vec3& at = mesh.nodes[node];
      for (int i = 0; i < dimension_; ++i)
        if (spec.u[i]) prescribe(node, at, i, static_cast<int>(b));
      if (spec.normal)
        for (int field = 0; field < d.n_fields(); ++field)
          inclined_.push_back({node + field * mesh.n_nodes(), static_cast<int>(b),
                               stiffness * depth(c.space, c.thickness, at.x()), 0.0});
    }
    if (!any)
      throw InputError(fmt::format("[boundary.{}] catches no node of the {}: check where.box", spec.name,
                                   c.method == Method::mpm ? "background grid" : "body meshes"));
  }
  // Where a displacement is prescribed as a whole, nothing is left to slip.
  std::erase_if(inclined_, [&](const InclinedNode& n) {
    int prescribed = 0;
    for (int i = 0; i < dimension_; ++i)
      for (const int b : boundaries_at_[{n.node % mesh.n_nodes(), i}])
        if (share_a_stage(case_.boundaries[b].stages, case_.boundaries[n.boundary].stages)) {
          ++prescribed;
          break;
        }
    return prescribed == dimension_;
  });
}

/// The first boundary of a stage owns a displacement; another one may only repeat it.
void BoundaryConditions::prescribe(int node, const Vec3& at, int component, int boundary) {
  const NodeBoundary& spec = case_.boundaries[boundary];
  std::vector<int>& others = boundaries_at_[{node, component}];
  for (const int other : others) {
    const NodeBoundary& first = case_.boundaries[other];
    if (first.u[component] != spec.u[component] && share_a_stage(first.stages, spec.stages))
      throw InputError(
          fmt::format("[boundary.{}] and [boundary.{}] prescribe different displacements u{} of the same node: "
                      "make their regions disjoint",
                      first.name, spec.name, "xyz"[component]));
  }
  others.push_back(boundary);
  by_place_ |= spec.depends_on_place();
  conditions_.push_back({node, component, boundary, at});
}

void BoundaryConditions::begin_stage(const std::string& name) {
  stage_ = name;
  connectivity_ = -1;
  std::vector<FieldContact> contacts;
  const std::vector<int> field = fields_of_bodies(case_);
  for (const Contact& c : case_.contacts) {
    if (c.other.empty() || !acts(c.stages)) continue;
    const int a = body_index(case_, c.body), b = body_index(case_, c.other);
    const double youngs = std::min(stiffness_of(case_, a), stiffness_of(case_, b));
    contacts.push_back(
        {std::min(field[a], field[b]), std::max(field[a], field[b]), c.friction, c.stiffness * youngs / cell_size_});
  }
  grid_contact_.set(std::move(contacts));
}

bool BoundaryConditions::acts(const Stages& stages) const {
  return stages.empty() || std::find(stages.begin(), stages.end(), stage_) != stages.end();
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

void BoundaryConditions::read_absorbing(const Case& c, const std::vector<SurfacePoint>& surface) {
  for (std::size_t k = 0; k < c.absorbing.size(); ++k) {
    const Absorbing& spec = c.absorbing[k];
    const int body = body_index(c, spec.body);
    bool any = false;
    for (const SurfacePoint& s : surface) {
      if (s.body != body || (spec.where.group && !in_group(s, *spec.where.group))) continue;
      const double share = share_inside(spec.where, s, dimension_);
      if (share == 0.0) continue;
      const Mat3 nn = s.normal * s.normal.transpose();
      DashpotPoint point;
      point.anchor = anchor_at(body, s.X, s.normal);
      point.id = static_cast<int>(dashpots_.size());
      point.absorbing = static_cast<int>(k);
      point.damping = share * s.area * spec.density *
                      (spec.p_wave_speed * nn + spec.s_wave_speed * (Mat3::Identity() - nn));
      any = true;
      dashpots_.push_back(point);
    }
    if (!any)
      throw InputError(fmt::format("[absorbing.{}] catches no part of the surface of body \"{}\": check its where",
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
    point.anchor = anchor_at(body_index(c, spec.body), x);
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
    if (!spec.other.empty()) continue;  // at the nodes of the grid
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
    pin.id = pin.pin = static_cast<int>(pins_.size());
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
  travel(dashpots_, d);
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
  for (DashpotPoint& p : dashpots_) anchors_.push_back(&p.anchor);
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
    if (!is_rigid_motion(case_.contacts[k].kind) || !acts(case_.contacts[k].stages)) continue;
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

/// Inclined nodes among the local ones; each process that touches such a node adds its share.
void BoundaryConditions::find_inclined(const Discretisation& d) {
  local_inclined_.clear();
  if (inclined_.empty()) return;
  std::vector<std::pair<int, int>> block_of(d.n_nodes(), {-1, -1});
  for (int block = 0; block < d.blocks.size(); ++block)
    for (std::size_t k = 0; k < d.blocks[block].size(); ++k)
      block_of[d.blocks[block][k]] = {block, static_cast<int>(k)};
  std::vector<double> touching(d.n_nodes(), 0.0);
  for (int node = 0; node < d.n_nodes(); ++node) touching[node] = block_of[node].first >= 0 ? 1.0 : 0.0;
  d.halo.add_to_owners(touching.data(), 1);
  d.halo.copy_to_ghosts(touching.data(), 1);
  for (std::size_t k = 0; k < inclined_.size(); ++k) {
    const int node = d.halo.find(inclined_[k].node);
    if (!acts(case_.boundaries[inclined_[k].boundary].stages)) continue;
    if (node < 0 || block_of[node].first < 0) continue;
    local_inclined_.push_back(
        {static_cast<int>(k), node, block_of[node].first, block_of[node].second, 1.0 / touching[node]});
  }
}

/// Force of a node against an inclined support [N].   [boundaries (9)]
double BoundaryConditions::push_of(const LocalInclined& local, const NodalVector& du, double t0, double t1) const {
  const InclinedNode& node = inclined_[local.index];
  const NodeBoundary& spec = case_.boundaries[node.boundary];
  return node.push + node.stiffness * (spec.normal->dot(du[local.node]) - (spec.un.at(t1) - spec.un.at(t0)));
}

void BoundaryConditions::begin_step(const Discretisation& d) {
  n_owned_ = d.halo.n_owned;
  if (connectivity_ != d.connectivity) {
    connectivity_ = d.connectivity;
    local_conditions_.clear();
    std::set<std::pair<int, int>> taken;
    for (std::size_t k = 0; k < conditions_.size(); ++k) {
      const NodeCondition& c = conditions_[k];
      if (!acts(case_.boundaries[c.boundary].stages)) continue;
      for (int field = 0; field < d.n_fields(); ++field) {
        const int node = d.halo.find(c.node + std::int64_t(field) * d.mesh().n_nodes());
        if (node >= 0 && taken.insert({node, c.component}).second)
          local_conditions_.emplace_back(static_cast<int>(k), node);
      }
    }
    find_inclined(d);
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
    du[dimension_ * node + c.component] = u.at(t1, c.at) - u.at(t0, c.at);
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

/// Tie: f = -k s. Unilateral: f = -k g n while g < 0, plus -k s_t without slip, and with friction what Coulomb's cone
/// lets through of that.   [boundaries (3), (4), (10), (11)]
BoundaryConditions::ContactForce BoundaryConditions::contact_force(const ContactPoint& point, const NodalVector& du,
                                                                   double t0, double t1) const {
  const Contact& spec = case_.contacts[point.contact];
  if (!acts(spec.stages)) return {Vec3::Zero(), Mat3::Zero(), false, point.slip};
  const Vec3 rigid = rigid_step(rigid_of_contact_[point.contact], t0, t1);
  const Vec3 relative = point.anchor.stencil.interpolate(du) - rigid;
  const double k = point.stiffness;
  if (spec.kind == Contact::Kind::tie) {
    const Vec3 slip = point.slip + relative;
    return {-k * slip, k * Mat3::Identity(), true, slip};
  }
  // Surfaces that just touch count as closed, so that a body laid on another one is held from the first guess on.
  const double gap = point.gap + point.normal.dot(relative), touching = 1e-12 * cell_size_;
  if (gap >= touching) return {};
  const Mat3 nn = point.normal * point.normal.transpose(), tangential = Mat3::Identity() - nn;
  const Vec3 push = -k * gap * point.normal;
  if (spec.kind == Contact::Kind::frictionless) return {push, k * nn, true};
  const Vec3 slip = tangential * (point.slip + relative);
  const double limit = spec.friction * std::max(0.0, -gap), size = slip.norm();  // over k
  if (spec.kind == Contact::Kind::no_slip || size <= limit) return {push - k * slip, k * Mat3::Identity(), true, slip};

  const Vec3 direction = slip / size;
  const double before = spec.friction * std::max(0.0, -point.gap);
  ContactForce sliding{push - k * limit * direction, k * nn, true, limit * direction};
  sliding.stiffness += k * (limit / size) * (tangential - direction * direction.transpose());
  if (gap < 0.0) sliding.stiffness -= k * spec.friction * (direction * point.normal.transpose());
  sliding.heat = 0.5 * k * (before + limit) * (size - limit);
  return sliding;
}

void BoundaryConditions::add_at(const Anchor& a, const Vec3& force, const Mat3& stiffness, NodalVector& f,
                                BlockAssembler* matrix) const {
  const Stencil& s = a.stencil;
  for (int i = 0; i < s.n; ++i) f[s.node[i]] -= s.N[i] * force;
  if (!matrix) return;
  const int d = dimension_, width = d * s.n;
  std::array<double, 9 * 20 * 20> K;
  for (int i = 0; i < s.n; ++i)
    for (int j = 0; j < s.n; ++j)
      for (int p = 0; p < d; ++p)
        for (int q = 0; q < d; ++q) K[(d * i + p) * width + d * j + q] = s.N[i] * s.N[j] * stiffness(p, q);
  matrix->add(a.block, K.data());
}

/// t = -rho (c_p n n + c_s (1 - n n)) v   [boundaries (13)]
void BoundaryConditions::add_dashpots(const NodalVector& v, double dv_by_du, NodalVector& f,
                                      BlockAssembler* matrix) const {
  for (const DashpotPoint& p : dashpots_) {
    if (!acts(case_.absorbing[p.absorbing].stages)) continue;
    add_at(p.anchor, -p.damping * p.anchor.stencil.interpolate(v), dv_by_du * p.damping, f, matrix);
  }
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
  for (const PinPoint& pin : pins_) {
    if (!acts(case_.pins[pin.pin].stages)) continue;
    const Mat3 k = pin.stiffness.asDiagonal();
    add_at(pin.anchor, -k * (pin.anchor.u + pin.anchor.stencil.interpolate(du)), k, f, matrix);
  }
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

bool BoundaryConditions::follows(const Pressure& spec) const {
  return !spec.traction && case_.kinematics == Kinematics::finite && spec.direction == Pressure::Direction::following;
}

bool BoundaryConditions::symmetric() const {
  for (const Pressure& p : case_.pressures)
    if (follows(p) || (case_.kinematics == Kinematics::finite && p.value.depends_on_place())) return false;
  return std::none_of(case_.contacts.begin(), case_.contacts.end(), [](const Contact& c) {
    return c.kind == Contact::Kind::friction && c.other.empty();  // [contact (6)] is symmetric
  });
}

/// a = J F^-T A, Nanson's formula; the cofactors of F are polynomials and have a value for every F.   [boundaries (6)]
BoundaryConditions::PressureForce BoundaryConditions::pressure_force(const PressurePoint& point, double time,
                                                                     const NodalVector& du) const {
  const Pressure& spec = case_.pressures[point.load];
  PressureForce p{0.0, point.area, point.anchor.x};
  if (!acts(spec.stages)) return p;
  if (spec.traction) return {1.0, spec.traction->at(time, point.anchor.x) * point.area.norm(), p.place};  // [(6a)]
  if (case_.kinematics == Kinematics::finite) p.place += point.anchor.stencil.interpolate(du);
  p.value = spec.value.at(time, p.place);
  if (!follows(spec)) return p;
  const Mat3 F = point.anchor.trial_F(du);
  Mat3 cofactor;
  for (int i = 0; i < 3; ++i) cofactor.row(i) = F.row((i + 1) % 3).cross(F.row((i + 2) % 3));
  p.area = cofactor * point.area;
  return p;
}

void BoundaryConditions::add_pressure(double time, const NodalVector& du, double factor, NodalVector& f,
                                      BlockAssembler* matrix) const {
  for (const PressurePoint& point : pressures_) {
    const PressureForce p = pressure_force(point, time, du);
    const Stencil& s = point.anchor.stencil;
    for (int k = 0; k < s.n; ++k) f[s.node[k]] += factor * p.value * s.N[k] * p.area;
    if (matrix) add_pressure_matrix(point, time, du, factor, *matrix);
  }
}

/// d(p a)/d(u_J) = p (a (x) g_J - g_J (x) a) + a (x) grad p N_J   [boundaries (12)]
void BoundaryConditions::add_pressure_matrix(const PressurePoint& point, double time, const NodalVector& du,
                                             double factor, BlockAssembler& matrix) const {
  const Pressure& spec = case_.pressures[point.load];
  if (!acts(spec.stages) || spec.traction) return;
  const bool follows_face = follows(spec);
  const bool by_place = case_.kinematics == Kinematics::finite && spec.value.depends_on_place();
  if (!follows_face && !by_place) return;
  const PressureForce p = pressure_force(point, time, du);
  const Stencil& s = point.anchor.stencil;
  Vec3 slope = Vec3::Zero();
  if (by_place)
    for (int i = 0; i < dimension_; ++i) {
      const Vec3 h = 1e-4 * cell_size_ * Vec3::Unit(i);
      slope[i] = (spec.value.at(time, p.place + h) - spec.value.at(time, p.place - h)) / (2.0 * h[i]);
    }
  const Mat3 push = point.anchor.push(du);
  const int d = dimension_, width = d * s.n;
  std::vector<double> K(std::size_t(width) * width);
  for (int J = 0; J < s.n; ++J) {
    Mat3 change = p.area * slope.transpose() * s.N[J];
    if (follows_face) {
      const Vec3 g = push * s.gradient[J];
      Vec3 dilation = g;  // around an axis the ring grows too
      dilation.x() += push(2, 2) * s.hoop[J];
      change += p.value * (p.area * dilation.transpose() - g * p.area.transpose());
    }
    for (int I = 0; I < s.n; ++I)
      for (int i = 0; i < d; ++i)
        for (int j = 0; j < d; ++j) K[(d * I + i) * width + d * J + j] = -factor * s.N[I] * change(i, j);
  }
  matrix.add(point.anchor.block, K.data());
}

std::vector<Vec3> BoundaryConditions::pressure_forces(double time, const NodalVector& du) const {
  std::vector<double> sums(3 * case_.pressures.size(), 0.0);
  for (const PressurePoint& point : pressures_) {
    const PressureForce p = pressure_force(point, time, du);
    for (int i = 0; i < 3; ++i) sums[3 * point.load + i] += p.value * p.area[i];
  }
  comm_.sum(sums);
  std::vector<Vec3> forces;
  for (std::size_t k = 0; k < sums.size(); k += 3) forces.emplace_back(sums[k], sums[k + 1], sums[k + 2]);
  return forces;
}

double BoundaryConditions::friction_work(const NodalVector& du, double t0, double t1) const {
  double heat = grid_contact_.work(du);
  for (const ContactPoint& p : contacts_) heat += contact_force(p, du, t0, t1).heat;
  return comm_.sum(heat);
}

void BoundaryConditions::commit(const Discretisation& d, const NodalVector& du, double t0, double t1) {
  grid_contact_.commit(d, du);
  for (ContactPoint& p : contacts_) p.slip = contact_force(p, du, t0, t1).slip;
  if (!inclined_.empty()) {
    std::vector<double> push(inclined_.size(), 0.0);
    for (const LocalInclined& local : local_inclined_) push[local.index] += local.share * push_of(local, du, t0, t1);
    comm_.sum(push);
    for (std::size_t k = 0; k < push.size(); ++k) inclined_[k].push = push[k];
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
  for (const LocalInclined& local : local_inclined_) {
    const int boundary = inclined_[local.index].boundary;
    add(n_bodies + boundary, -local.share * push_of(local, du, t0, t1) * *case_.boundaries[boundary].normal);
  }
  comm_.sum(sums);
  const auto vector_at = [&](std::size_t index) {
    return Vec3(sums[3 * index], sums[3 * index + 1], sums[3 * index + 2]);
  };
  Reactions out;
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
  double work = 0.0;
  for (std::size_t b = 0; b < case_.boundaries.size(); ++b) {
    const NodeBoundary& spec = case_.boundaries[b];
    const Vec3 mean = 0.5 * (now.boundary[b] + before.boundary[b]);
    if (spec.normal) work += mean.dot(*spec.normal) * (spec.un.at(t1) - spec.un.at(t0));
    if (spec.depends_on_place()) continue;
    for (int i = 0; i < dimension_; ++i)
      if (const auto& u = spec.u[i]) work += mean[i] * (u->at(t1) - u->at(t0));
  }
  for (std::size_t k = 0; k < now.node.size(); ++k) {
    const NodeCondition& c = conditions_[k];
    const NodeBoundary& spec = case_.boundaries[c.boundary];
    if (!spec.depends_on_place()) continue;
    const TimeFunction& u = *spec.u[c.component];
    const double first = before.node.empty() ? 0.0 : before.node[k];
    work += 0.5 * (now.node[k] + first) * (u.at(t1, c.at) - u.at(t0, c.at));
  }
  return work;
}

std::string BoundaryConditions::idle_boundary() const {
  std::vector<double> works(case_.boundaries.size(), 0.0);
  for (const auto& [k, node] : local_conditions_) works[conditions_[k].boundary] += 1.0;
  for (const LocalInclined& local : local_inclined_) works[inclined_[local.index].boundary] += 1.0;
  comm_.sum(works);
  for (std::size_t b = 0; b < works.size(); ++b)
    if (works[b] == 0.0) return case_.boundaries[b].name;
  return "";
}

// ---- checkpoints

namespace {

void append_row(std::vector<double>& rows, int id, const Anchor& a, const Vec3& slip = Vec3::Zero()) {
  rows.push_back(id);
  for (const Vec3* v : {&a.x, &a.u}) rows.insert(rows.end(), v->data(), v->data() + 3);
  rows.insert(rows.end(), a.F.data(), a.F.data() + 9);
  rows.insert(rows.end(), slip.data(), slip.data() + 3);
}

void restore_anchor(Anchor& a, const double* row) {
  a.x = Vec3(row[1], row[2], row[3]);
  a.u = Vec3(row[4], row[5], row[6]);
  std::copy_n(row + 7, 9, a.F.data());
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
  if (kind == 4 && comm_.is_root())
    for (std::size_t k = 0; k < inclined_.size(); ++k)
      append_row(rows, static_cast<int>(k), Anchor{}, Vec3(inclined_[k].push, 0.0, 0.0));
  if (kind == 5)
    for (const DashpotPoint& p : dashpots_) append_row(rows, p.id, p.anchor);
  return rows;
}

void BoundaryConditions::restore(int kind, const std::vector<double>& rows) {
  for (std::size_t k = 0; k < rows.size(); k += row_width) {
    const double* row = rows.data() + k;
    const int id = static_cast<int>(row[0]);
    if (kind == 0)
      if (ContactPoint* p = point_of(contacts_, id)) {
        restore_anchor(p->anchor, row);
        p->slip = Vec3(row[16], row[17], row[18]);
      }
    if (kind == 1)
      if (PressurePoint* p = point_of(pressures_, id)) restore_anchor(p->anchor, row);
    if (kind == 2)
      if (PinPoint* p = point_of(pins_, id)) restore_anchor(p->anchor, row);
    if (kind == 3 && id < 2 * static_cast<int>(gauges_.size()))
      restore_anchor(id % 2 == 0 ? gauges_[id / 2].from : gauges_[id / 2].to, row);
    if (kind == 4 && id < static_cast<int>(inclined_.size())) inclined_[id].push = row[16];
    if (kind == 5)
      if (DashpotPoint* p = point_of(dashpots_, id)) restore_anchor(p->anchor, row);
  }
}

void BoundaryConditions::restore_rigid(double time) {
  for (std::size_t b = 0; b < case_.bodies.size(); ++b)
    if (case_.bodies[b].rigid) rigid_offset_[b] = case_.bodies[b].displacement.at(time);
  for (RigidPoint& p : rigid_points_) {
    p.anchor.u = rigid_offset_[rigid_of_contact_[p.contact]];
    if (case_.kinematics == Kinematics::finite) p.anchor.x = p.anchor.X + p.anchor.u;
  }
}

}  // namespace berm
