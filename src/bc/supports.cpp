/// Prescribed nodes and inclined supports.
#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "base/findings.hpp"
#include "bc/boundary.hpp"
#include "bc/case_lookup.hpp"
#include "method/depth.hpp"

namespace berm {
namespace {

/// Stiffness of an inclined node, in units of E t (in space E h).
constexpr double inclined_penalty = 1e6;

}  // namespace

void BoundaryConditions::read_boundary(int boundary, double stiffness, const Case& c, const Discretisation& d) {
  const NodeBoundary& spec = c.boundaries[boundary];
  const Mesh& mesh = d.mesh();
  const std::vector<Vec3>& places = d.node_places();
  const int n_places = static_cast<int>(places.size());
  const std::vector<int>* group = nullptr;
  if (spec.where.group) {
    const auto found = mesh.node_groups.find(*spec.where.group);
    if (found == mesh.node_groups.end())
      throw InputError(fmt::format("[boundary.{}]: no mesh has a physical {} named \"{}\"", spec.name,
                                   dimension_ == 3 ? "surface" : "curve", *spec.where.group));
    group = &found->second;
  }
  bool any = false;
  const int n = group ? static_cast<int>(group->size()) : n_places;
  for (int k = 0; k < n; ++k) {
    const int node = group ? (*group)[k] : k;
    if (!inside(spec.where, places[node])) continue;
    any = true;
    const Vec3& at = places[node];
    for (int i = 0; i < dimension_; ++i)
      if (spec.u[i]) prescribe(node, at, i, boundary);
    if (spec.normal)
      for (int field = 0; field < d.n_fields(); ++field)
        inclined_.push_back({node + field * n_places, boundary,
                             stiffness * depth(c.space, c.thickness, at.x()), 0.0});
  }
  if (any) return;
  // Nodes of quadratic functions lie between the lines of the grid.
  const auto deformable = std::find_if(c.bodies.begin(), c.bodies.end(), [](const Body& body) { return !body.rigid; });
  const bool grid = c.method == Method::mpm;
  throw InputError(fmt::format("[boundary.{0}] catches no node of the {1}: check where.box{2}", spec.name, grid ? "background grid" : "body meshes",
                               grid && deformable != c.bodies.end() ? fmt::format(", or hold the surface that lies there (boundary.{}.body = \"{}\")", spec.name, deformable->name) : ""));
}

void BoundaryConditions::read_boundaries(const Case& c, const Discretisation& d) {
  const int n_places = static_cast<int>(d.node_places().size());
  double youngs = 0.0;
  for (const Material& m : c.materials)
    youngs = std::max(youngs, std::visit([](const auto& law) { return law.stiffness(); }, m.law));
  const double stiffness = inclined_penalty * youngs * (dimension_ == 3 ? d.cell_size() : 1.0);
  Findings found;
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    const NodeBoundary& spec = c.boundaries[b];
    if (spec.body.empty()) found.look([&] { read_boundary(static_cast<int>(b), stiffness, c, d); });  // else read_held_surfaces
  }
  found.throw_if_any();
  // Where a displacement is prescribed as a whole, nothing is left to slip.
  std::erase_if(inclined_, [&](const InclinedNode& n) {
    int prescribed = 0;
    for (int i = 0; i < dimension_; ++i)
      for (const int b : boundaries_at_[{n.node % n_places, i}])
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

void BoundaryConditions::find_prescribed(const Discretisation& d) {
  local_conditions_.clear();
  reached_.assign(case_.boundaries.size(), 0.0);
  std::set<std::pair<int, int>> taken;
  for (std::size_t k = 0; k < conditions_.size(); ++k) {
    const NodeCondition& c = conditions_[k];
    if (!acts(case_.boundaries[c.boundary].stages)) continue;
    for (int field = 0; field < d.n_fields(); ++field) {
      const int node = d.halo.find(c.node + std::int64_t(field) * static_cast<std::int64_t>(d.node_places().size()));
      if (node < 0) continue;
      reached_[c.boundary] = 1.0;
      if (taken.insert({node, c.component}).second) local_conditions_.emplace_back(static_cast<int>(k), node);
    }
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
  return node.push + node.stiffness * (spec.normal->dot(du[local.node]) - spec.un.step(t0, t1));
}

std::vector<double> BoundaryConditions::prescribed_increment(double t0, double t1) const {
  std::vector<double> du(fixed_.size(), 0.0);
  for (const auto& [k, node] : local_conditions_) {
    const NodeCondition& c = conditions_[k];
    const TimeFunction& u = *case_.boundaries[c.boundary].u[c.component];
    du[dimension_ * node + c.component] = u.step(t0, t1, c.at);
  }
  for (std::size_t node = 0; node < moved_by_.size(); ++node) {
    if (moved_by_[node] < 0) continue;
    const Vec3 motion = rigid_step(rigid_of_contact_[moved_by_[node]], t0, t1);
    for (int i = 0; i < dimension_; ++i) du[dimension_ * node + i] = motion[i];
  }
  return du;
}

std::vector<std::string> BoundaryConditions::idle_boundaries() const {
  std::vector<double> works = reached_;
  for (const LocalInclined& local : local_inclined_) works[inclined_[local.index].boundary] += 1.0;
  for (const HeldPoint& p : held_) works[p.boundary] += 1.0;
  comm_.sum(works);
  std::vector<std::string> idle;
  for (std::size_t b = 0; b < works.size(); ++b)
    if (works[b] == 0.0 && acts(case_.boundaries[b].stages)) idle.push_back(case_.boundaries[b].name);
  return idle;
}

}  // namespace berm
