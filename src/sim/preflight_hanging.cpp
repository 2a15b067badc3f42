/// Bodies and the held nodes of the grid beside them.

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <map>

#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "bc/where.hpp"
#include "sim/advice.hpp"
#include "sim/preflight_parts.hpp"

namespace berm {
namespace {

/// Held nodes stay where they are in the grid: a body that is pushed or drawn away from a row of them leaves it, and is no
/// longer held by what its support was. Collective.
void warn_of_left_nodes(World& w, const MpmDiscretisation& mpm, int boundary, const std::vector<BoundaryConditions::Hold>& holds, const Mat3& own,
                        const std::map<int, Region>& regions) {
  constexpr double flat = 0.5, left = 0.1;  // cells
  constexpr int samples = 100;
  const Case& c = w.spec;
  const NodeBoundary& b = c.boundaries[boundary];
  if (!b.body.empty() || !moves_through_grid(c)) return;
  Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
  for (const auto& hold : holds)
    if (hold.boundary == boundary && hold.node >= 0) low = low.cwiseMin(hold.at), high = high.cwiseMax(hold.at);
  for (int i = 0; i < 3; ++i) low[i] = w.comm.min(low[i]), high[i] = w.comm.max(high[i]);
  for (int i = 0; i < mpm.dimension(); ++i) {
    const double thickness = high[i] - low[i];
    if (!b.u[i] || b.u[i]->depends_on_place() || !(thickness < flat * mpm.cell_size()) || !own.isIdentity(1e-12)) continue;
    // Within a body there is material to follow that which moves on.
    const Vec3 middle = 0.5 * (low + high), way = 0.6 * mpm.cell_size() * Vec3::Unit(i);
    if (std::any_of(regions.begin(), regions.end(), [&](const auto& r) { return r.second.contains(middle + way) && r.second.contains(middle - way); }))
      continue;
    double farthest = 0.0;
    for (int k = 0; k <= samples; ++k) farthest = std::max(farthest, std::abs(b.u[i]->at(c.duration() * k / samples)));
    if (farthest <= left * mpm.cell_size()) continue;
    w.warnings.push_back(
        fmt::format("[boundary.{}] moves nodes of the grid by {:.3g} m ({:.2g} cells) along {}, but they stay in their places: the body leaves them. Hold "
                    "its surface in their place (boundary.{}.body = \"NAME\"), or take [model] formulation = \"total_lagrangian\"",
                    b.name, farthest, farthest / mpm.cell_size(), "xyz"[i], b.name));
  }
}

/// From a body to the boxes of the held nodes of each cell, on this process; it need not be exact below `enough`.
double distance_to_held(const MpmDiscretisation& mpm, const Slice& slice, const std::vector<char>& held, const Mat3& own,
                        const std::vector<SurfacePoint>& surface, const std::vector<Vec3>& points, const Region* region, double enough) {
  double nearest = infinity;
  for (int node = 0; region && node < mpm.n_nodes(); ++node)
    if (held[node] && region->contains(mpm.nodes[node])) return 0.0;
  for (int block = 0; block < mpm.n_patches() && nearest > enough; ++block) {
    Vec3 low = Vec3::Constant(infinity), high = Vec3::Constant(-infinity);
    for (const int node : mpm.blocks[block])
      if (held[node]) low = low.cwiseMin(own * mpm.nodes[node]), high = high.cwiseMax(own * mpm.nodes[node]);
    if (low.x() > high.x()) continue;
    const auto look = [&](const Vec3& x) {
      const Vec3 y = own * x;
      nearest = std::min(nearest, (low - y).cwiseMax(y - high).head(mpm.dimension()).maxCoeff());
    };
    for (std::size_t k = 0; k < surface.size() && nearest > enough; ++k)
      if (surface[k].body == slice.body) look_at_piece(surface[k], look);
    for (int p = slice.begin; p < slice.end && nearest > enough; ++p) look(points[p]);
  }
  return nearest;
}

}  // namespace

void warn_of_loose_supports(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface) {
  constexpr double told = 0.1;
  const Case& c = w.spec;
  for (const NodeBoundary& b : c.boundaries) {
    if (!b.body.empty() || b.where.group) continue;
    std::vector<double> area(c.bodies.size(), 0.0), loose = area;
    std::vector<Vec3> at(c.bodies.size(), Vec3::Zero());
    for (const SurfacePoint& s : surface) {
      BasisAt shape;
      if (!inside(b.where, s.X)) continue;
      const int cell = mpm.grid().locator->locate(s.X - 1e-6 * mpm.cell_size() * s.normal, -1);
      if (cell < 0 || !mpm.basis().evaluate(cell, s.X, shape)) continue;
      double missing = 0.0;
      for (int k = 0; k < shape.n; ++k) {
        const Vec3& node = mpm.basis().places()[shape.nodes[k]];
        const Vec3 foot = node + (s.X - node).dot(s.normal) * s.normal;
        if (!inside(b.where, node) && inside(b.where, foot)) missing += shape.N[k];
      }
      if (missing > loose[s.body] / std::max(area[s.body], 1e-300)) at[s.body] = s.X;
      area[s.body] += s.area, loose[s.body] += s.area * missing;
    }
    for (std::size_t body = 0; body < area.size(); ++body)
      if (loose[body] > told * area[body])
        w.warnings.push_back(fmt::format("[boundary.{0}] holds nodes of the grid that the surface of body \"{1}\" near {2} does not lie on: {3:.0f} % of its motion there is that of "
                                         "free nodes{4}. Hold the surface itself (boundary.{0}.body = \"{1}\"), or let lines of cells lie on it",
                                         b.name, c.bodies[body].name, place_text(c, at[body]), 100.0 * loose[body] / area[body],
                                         mpm.degree() > 1 ? ", since splines have nodes beside the lines of the cells" : ""));
  }
}

void refuse_hanging_bodies(World& w, const MpmDiscretisation& mpm, const std::vector<SurfacePoint>& surface) {
  const Case& c = w.spec;
  const std::vector<std::vector<double>> share = shares_of_nodes(w);
  const double reach = (0.1 + 0.5 * (mpm.degree() - 1)) * mpm.cell_size();  // splines have nodes between the lines
  const StructuredGrid* grid = mpm.grid().structure.get();
  const Mat3 own = grid ? Mat3(Eigen::AngleAxisd(-grid->angle, Vec3::UnitZ()).toRotationMatrix()) : Mat3(Mat3::Identity());
  std::vector<std::vector<char>> held(c.boundaries.size());
  for (auto& nodes : held) nodes.assign(mpm.n_nodes(), 0);
  const std::vector<BoundaryConditions::Hold> holds = w.boundary->holds(mpm);
  for (const auto& hold : holds)
    if (hold.node >= 0 && hold.boundary >= 0) held[hold.boundary][hold.node] = 1;
  const std::vector<Vec3> points = mpm.point_positions();
  const std::map<int, Region> regions = regions_of_shapes(c, mpm.cell_size());
  for (std::size_t b = 0; b < c.boundaries.size(); ++b) {
    mpm.halo.copy_to_ghosts(held[b].data(), 1);
    warn_of_left_nodes(w, mpm, static_cast<int>(b), holds, own, regions);
    std::map<int, bool> touches;   // by body that has some of the nodes
    std::map<int, double> nearest;
    for (const Slice& slice : mpm.material.slices) {
      bool reached = false;
      for (int i = 0; i < mpm.halo.n_owned; ++i) reached |= held[b][i] && share[slice.body][i] > 0.0;
      if (!w.comm.any(reached)) continue;
      const double distance = distance_to_held(mpm, slice, held[b], own, surface, points, regions.count(slice.body) ? &regions.at(slice.body) : nullptr, reach);
      nearest[slice.body] = w.comm.min(distance);
      touches[slice.body] = nearest[slice.body] <= reach;
    }
    for (const auto& [body, by_itself] : touches) {
      // What lies between, and has the same nodes, may touch them for it.
      bool carried = by_itself;
      for (const auto& [other, other_touches] : touches) {
        bool common = false;
        for (int i = 0; i < mpm.halo.n_owned; ++i) common |= held[b][i] && share[body][i] > 0.0 && share[other][i] > 0.0;
        carried |= other_touches && w.comm.any(common);
      }
      if (carried) continue;
      const std::string text = fmt::format("[boundary.{}] holds nodes {:.4g} m beside body \"{}\", which does not touch them and would hang on them all "
                                           "the same",
                                           c.boundaries[b].name, nearest[body], c.bodies[body].name);
      const bool on_surface = std::any_of(surface.begin(), surface.end(), [&, body = body](const SurfacePoint& s) {
        const Where& where = c.boundaries[b].where;
        return s.body == body && (!where.group || in_group(s, *where.group)) && inside(where, s.X);
      });
      if (!c.allow_glued)
        throw InputError(fmt::format("{}. Move the body to them, hold its surface by [boundary.{}] body = \"{}\"{}, keep them a cell away from it, or allow it by [model] allow_glued = true",
                                     text, c.boundaries[b].name, c.bodies[body].name, on_surface ? "" : " and a where that catches it"));
      w.warnings.push_back(text);
    }
  }
}

}  // namespace berm
