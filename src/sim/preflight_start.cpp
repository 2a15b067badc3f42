/// What the first step begins with: points, jumps of supports, bodies inside of rigid ones, the shape of cells.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <map>

#include "base/error.hpp"
#include "bc/case_lookup.hpp"
#include "case/places.hpp"
#include "sim/advice.hpp"
#include "sim/preflight_parts.hpp"

namespace berm {

/// B-splines: as many strains as unknowns, or some motions of the nodes cost nothing. Collective.
void refuse_few_points(const World& w, const MpmDiscretisation& mpm, const std::vector<std::vector<double>>& share) {
  const Case& c = w.spec;
  if (c.shape_functions != ShapeFunctions::quadratic_bspline && c.shape_functions != ShapeFunctions::cubic_bspline) return;
  const int d = c.dimension(), strains = c.space == Space::solid ? 6 : c.space == Space::axisymmetric ? 4 : 3;
  for (const Slice& slice : mpm.material.slices) {
    // Bodies of a layer share nodes: the points of all strain them.
    long unknowns = 0, points = 0;
    for (int i = 0; i < mpm.halo.n_owned; ++i) {
      bool reached = false;
      for (const Slice& other : mpm.material.slices)
        reached |= w.layers[other.body] == w.layers[slice.body] && share[other.body][i] > 0.0;
      for (int k = 0; k < d && reached; ++k) unknowns += !w.boundary->fixed()[d * i + k];
    }
    for (const Slice& other : mpm.material.slices)
      if (w.layers[other.body] == w.layers[slice.body]) points += other.end - other.begin;
    unknowns = w.comm.sum(unknowns) - static_cast<long>(motions_of(c.space).size());
    points = w.comm.sum(points);
    const Body& body = c.bodies[slice.body];
    // One point a cell leaves cubic functions motions without strain, however many cells there are.
    const bool single = mpm.degree() == 3 && body.points.kind == PointSeeding::Kind::grid && body.mesh_file.empty() && body.points.per_direction == 1;
    if (strains * points >= unknowns && !single) continue;
    const double factor = std::max(single ? 2.0 : 1.0, std::pow(double(unknowns) / (strains * points), 1.0 / d));
    const bool by_mesh = body.points.kind == PointSeeding::Kind::mesh || !body.mesh_file.empty();
    const std::string more =
        by_mesh ? fmt::format("a finer mesh for them or more points.per_element")
                : fmt::format("points.per_direction = {} or more", static_cast<int>(std::ceil(factor * body.points.per_direction - 1e-9)));
    throw InputError(fmt::format(
        "body \"{}\" has {} points, too few for the {} unknowns of B-splines of degree {}: take [body.{}] {}, or smaller cells",
        body.name, points, unknowns, mpm.degree(), body.name, more));
  }
}

/// The reader has looked at motions that are the same everywhere.
void refuse_jumps(const World& w) {
  const Case& c = w.spec;
  if (c.stages.front().steps.analysis != Analysis::dynamic) return;
  w.comm.agree([&] {
    for (const auto& hold : w.boundary->holds(*w.discretisation)) {
      if (hold.boundary < 0) continue;
      const NodeBoundary& b = c.boundaries[hold.boundary];
      for (const std::optional<TimeFunction>& u : {b.u[0], b.u[1], b.u[2], std::optional(b.un)})
        if (u && u->depends_on_place() && std::abs(u->at(0.0, hold.at)) > no_jump)
          throw InputError(fmt::format("[boundary.{}]: \"{}\" is {:.4g} at {} and t = 0: where the first stage is dynamic a displacement begins "
                                       "with 0 everywhere",
                                       b.name, u->text(), u->at(0.0, hold.at), place_text(c, hold.at)));
    }
  });
}

/// What lies inside a rigid body at the start is pushed out in the first step, by the stiff springs of contact. Collective.
void warn_of_depth(World& w) {
  constexpr double told = 1e-4, meshed = 0.01;  // cells
  const Case& c = w.spec;
  const double h = w.discretisation->cell_size();
  const std::vector<BoundaryConditions::Hold> holds = w.boundary->holds(*w.discretisation);
  const bool some = std::any_of(holds.begin(), holds.end(), [&](const auto& hold) { return hold.contact >= 0 && hold.gap < -told * h; });
  if (!w.comm.any(some)) return;
  const std::map<int, Region> regions = regions_of_shapes(c, h);
  // Chords of a mesh lie inside of an arc: the place of the body's own shape counts.
  const auto depth = [&](const BoundaryConditions::Hold& hold) {
    const auto own = regions.find(hold.body), rigid = regions.find(body_index(c, c.contacts[hold.contact].rigid));
    if (own == regions.end() || rigid == regions.end()) return -hold.gap - meshed * h;
    return -rigid->second.nearest(own->second.nearest(hold.at).point).distance;
  };
  for (std::size_t k = 0; k < c.contacts.size(); ++k) {
    double deepest = 0.0;
    for (const auto& hold : holds)
      if (hold.contact == static_cast<int>(k) && hold.gap < -told * h) deepest = std::max(deepest, depth(hold));
    deepest = w.comm.max(deepest);
    if (deepest <= told * h) continue;
    w.warnings.push_back(with_places(c, fmt::format("[contact.{}]: the surface of \"{}\" starts up to {:.3g} m inside of rigid body \"{}\", and is pushed out in the first "
                                          "step: let it start where the two touch",
                                                    c.contacts[k].name, c.contacts[k].body, deepest, c.contacts[k].rigid)));
  }
}

/// The crack-band length of a point is the root of the area (volume) of its cell: cracks along the short edges dissipate too much,
/// those along the long ones too little, by that over the edge across them (Bazant and Oh 1983: the width of the band).
void warn_of_flat_cells(World& w) {
  constexpr double square = 1.25;
  std::vector<std::string> names;
  for (const Material& m : w.spec.materials)
    if (is_damage(m.law) && m.crack_band != Material::CrackBand::fixed) names.push_back(fmt::format("[material.{}]", m.name));
  if (names.empty()) return;
  const Mesh& mesh = w.discretisation->mesh();
  double longest = 0.0, shortest = 0.0, cells = 0.0;
  for (int e = 0; e < mesh.n_cells(); ++e) {
    const bool flat = corners_of(mesh.kinds[e]) == 4 && dimension_of(mesh.kinds[e]) == 2;
    if (!flat && corners_of(mesh.kinds[e]) != 8) continue;
    const int* node = mesh.cell(e);
    const auto edge = [&](int k) { return (mesh.nodes[node[k]] - mesh.nodes[node[0]]).norm(); };
    const double a = edge(1), b = edge(3), c = flat ? a : edge(4);
    longest += std::max({a, b, c}), shortest += std::min({a, b, c}), cells += 1.0;
  }
  if (cells == 0.0 || longest <= square * shortest) return;
  w.warnings.push_back(fmt::format("{}: cells are {:.3g} x {:.3g} m in the mean, and the crack band takes one length for both: a crack across the long edges dissipates too "
                                   "much, one along them too little, by up to {:.2g} times. Take square cells, or crack_band = the edge across the crack [m]",
                                   fmt::join(names, ", "), longest / cells, shortest / cells, std::sqrt(longest / shortest)));
}

}  // namespace berm
