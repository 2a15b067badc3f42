#include "sim/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <optional>
#include <set>
#include <span>

#include "base/findings.hpp"
#include "bc/case_lookup.hpp"
#include "case/places.hpp"
#include "sim/far_origin.hpp"
#include "fem/fem.hpp"
#include "la/newton.hpp"
#include "law/kinds.hpp"
#include "mesh/gmsh_ends.hpp"
#include "mesh/gmsh.hpp"
#include "method/depth.hpp"
#include "sim/advice.hpp"
#include "sim/preflight.hpp"
#include "sim/surfaces.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

/// A mesh reduced to the cells of one physical surface or volume.
Mesh extract_group(const Mesh& mesh, const std::string& group, const std::string& file) {
  if (group.empty()) return mesh;
  const auto found = mesh.cell_groups.find(group);
  if (found == mesh.cell_groups.end()) {
    std::string names;
    for (const auto& [name, cells] : mesh.cell_groups) names += (names.empty() ? "" : ", ") + name;
    throw InputError(fmt::format("{}: no physical {} named \"{}\" (there is: {})", file,
                                 mesh.dimension() == 3 ? "volume" : "surface", group, names.empty() ? "none" : names));
  }
  Mesh out;
  std::vector<int> number(mesh.nodes.size(), -1);
  std::array<int, 20> list{};
  for (int c : found->second) {
    const int n = nodes_of(mesh.kinds[c]);
    for (int k = 0; k < n; ++k) {
      int& id = number[mesh.cell(c)[k]];
      if (id < 0) {
        id = out.n_nodes();
        out.nodes.push_back(mesh.nodes[mesh.cell(c)[k]]);
      }
      list[k] = id;
    }
    out.add_cell(mesh.kinds[c], list.data());
  }
  for (const auto& [name, nodes] : mesh.node_groups)
    for (int node : nodes)
      if (number[node] >= 0) out.node_groups[name].push_back(number[node]);
  return out;
}

/// A Gmsh file whose cells have the dimension of the model.
Mesh read_mesh(const Case& c, const std::string& file) {
  Mesh mesh = read_msh(file);
  for (Vec3& x : mesh.nodes) x -= c.origin;
  if (mesh.dimension() != c.dimension())
    throw InputError(fmt::format("{}: a mesh of {} cells, but [model] dimension = {}", file,
                                 mesh.dimension() == 3 ? "solid" : "plane", c.dimension()));
  return mesh;
}

/// Calls f; what is wrong with a shape or a mesh names its body.
template <class F>
auto of_body(const Case& c, const Body& body, F f) {
  const SayIfGmshEnds words([&] {
    return with_places(c, fmt::format("[body.{}]: Gmsh cannot mesh it: parts of its boundary are nearer to each other than Gmsh can tell apart, or it has next to no "
                                      "thickness. Close or widen what is narrow",
                                      body.name));
  });
  try {
    return f();
  } catch (const InputError& error) {
    throw InputError(fmt::format("[body.{}]: {}", body.name, error.what()));
  }
}

Region region_of(const Case& c, const Body& body, double cell_size) {
  return of_body(c, body, [&] { return Region(*body.shape, cell_size); });
}

Mesh body_mesh(const Case& c, const Body& body, const BodyMeshOptions& options) {
  if (body.mesh_file.empty()) return of_body(c, body, [&] { return mesh_shape(*body.shape, options); });
  Mesh mesh = extract_group(read_mesh(c, body.mesh_file), body.mesh_group, body.mesh_file);
  if (const auto found = overlapping_cells(mesh))
    throw InputError(fmt::format("[body.{}]: two elements of {} lie in one another near {}: what is there would count twice. Mesh the body again, or leave one of them out",
                                 body.name, body.mesh_file, place_text(c, cell_centre(mesh, found->second))));
  return mesh;
}

/// Points that are nearer to the surface of their body than this share of a cell tell where it is.
constexpr double rim_width = 0.55;

/// Name and kind; the measure too if the body is rigid, since nothing else will tell.
BodySummary summary_of(const Case& c, const Body& body, double cell_size) {
  BodySummary summary;
  summary.name = body.name;
  summary.rigid = body.rigid;
  if (body.rigid) summary.measure = region_of(c, body, cell_size).measure();
  return summary;
}

Grid make_grid(const Case& c) {
  if (const auto* structured = std::get_if<StructuredGrid>(&c.grid)) return make_structured_grid(*structured);
  const std::string& file = std::get<std::string>(c.grid);
  Mesh mesh = read_mesh(c, file);
  if (const auto found = overlapping_cells(mesh))
    throw InputError(fmt::format("{}: two cells of the grid lie in one another near {}: material there would be in both. Mesh the grid again, or leave one of them out", file,
                                 place_text(c, cell_centre(mesh, found->second))));
  return make_unstructured_grid(std::move(mesh));
}

/// The grid of quads or hexahedra that one of triangles or tetrahedra was cut from.
Grid boxes_of(StructuredGrid structure) {
  structure.kind = dimension_of(structure.kind) == 2 ? GridKind::quads : GridKind::hexahedra;
  return make_structured_grid(structure);
}

ShapeChoice shape_choice(const Case& c) {
  using Domain = ShapeChoice::Domain;
  const bool follows = moves_through_grid(c);
  switch (c.shape_functions) {
    case ShapeFunctions::linear:
      return {.at_gauss_points = c.quadrature == Quadrature::gauss};
    case ShapeFunctions::quadratic_bspline:
      return {.degree = 2};
    case ShapeFunctions::cubic_bspline:
      return {.degree = 3};
    case ShapeFunctions::ugimp:
      return {.degree = 1, .domain = Domain::box};
    case ShapeFunctions::cpgimp:
      return {.degree = 1, .domain = Domain::box, .follows = follows};
    case ShapeFunctions::b2gimp:
      return {.degree = 2, .domain = Domain::box, .follows = follows};
    default:
      return {.degree = 1, .domain = Domain::parallelepiped, .follows = follows};
  }
}

/// Domains that follow a body, or that do not fit the cells, tear off at its ends with the smaller one; soil and water that flow are held back by the larger
/// one.   [formulation, section 6]
double default_ghost_penalty(const Case& c, const ShapeChoice& functions) {
  const bool flows = any_law(c, flows_far), fills = functions.follows || (functions.domain != ShapeChoice::Domain::none && has_points_of_files(c));
  return fills && !flows ? 0.03 : 1e-3;
}

/// The same for grids from files as check_mixed of the case for those of cells.
void check_mixed_grid(const Case& c, const Mesh& grid) {
  if (c.volumetric == Volumetric::mixed && c.moves_with_finite_strain_updated() &&
      std::any_of(grid.kinds.begin(), grid.kinds.end(), is_simplex))
    throw InputError(std::string("[model] volumetric = \"mixed\" ") + mixed_on_moving_simplices);
}

/// Whether the grid's functions change alike on both sides of a surface: within a cell, and at its edges if they are smooth.
bool in_one_cell(const MpmDiscretisation& mpm, const SurfacePoint& s) {
  if (mpm.degree() > 1) return true;
  Anchor inside = anchor_at(s.body, s.X, s.normal), outside = anchor_at(s.body, s.X, -s.normal);
  mpm.locate(inside);
  mpm.locate(outside);
  return inside.cell == outside.cell;
}

/// Parts whose points are nowhere next to each other. `width`: the least that parts them.
BodyParts parts_of_points(const std::vector<Vec3>& places, const std::vector<double>& measures, double width, int dimension) {
  const double mean = std::accumulate(measures.begin(), measures.end(), 0.0) / std::max<std::size_t>(1, measures.size());
  return {places, (1.0 + 1e-6) * std::max(width, 2.0 * std::pow(mean, 1.0 / dimension))};
}

/// Pins, gauges and probes must lie in a deformable body: in its shape but for a part of a cell, or near its elements.
void check_places(const World& w, const BuiltBodies& built, Findings& found) {
  constexpr double beside = 0.1;  // cells
  if (w.spec.pins.empty() && w.spec.output.gauges.empty() && w.spec.output.probes.empty()) return;
  const double reach = 1.5 * longest_edge(w.discretisation->mesh()), h = w.discretisation->cell_size();
  std::vector<Region> shapes;
  bool all_have = true;
  for (const Body& body : w.spec.bodies) {
    if (body.rigid) continue;
    if (body.shape) shapes.emplace_back(*body.shape, h);
    all_have = all_have && body.shape;
  }
  const auto is_near = [&](const Vec3& x) {
    const auto in_box = [&](const Region& r) {  // the surface is looked for near it only: places may be anywhere
      const int d = r.dimension();
      return ((x - r.min()).head(d).array() >= -beside * h).all() && ((r.max() - x).head(d).array() >= -beside * h).all();
    };
    if (all_have) return std::any_of(shapes.begin(), shapes.end(), [&](const Region& r) { return in_box(r) && (r.contains(x) || r.nearest(x).distance <= beside * h); });
    if (std::any_of(built.surface.begin(), built.surface.end(), [&](const SurfacePoint& s) { return (closest_on_piece(x, s) - x).norm() <= beside * h; })) return true;
    for (std::size_t b = 0; b < built.places.size(); ++b)
      for (std::size_t p = 0; p < built.places[b].size(); ++p)
        if (const double away = (built.places[b][p] - x).norm(); away <= reach || std::pow(away, w.spec.dimension()) <= built.measures[b][p]) return true;
    return false;
  };
  const auto check = [&](const char* kind, const std::string& name, const Vec3& x) {
    found.look([&] {
      if (!is_near(x)) throw InputError(fmt::format("[{}.{}]: the point {} lies outside of every deformable body", kind, name, place_text(w.spec, x)));
    });
  };
  for (const Pin& p : w.spec.pins) check("pin", p.name, p.at);
  for (const Gauge& g : w.spec.output.gauges) {
    check("gauge", g.name, g.from);
    check("gauge", g.name, g.to);
  }
  for (const Probe& p : w.spec.output.probes) check("probe", p.name, p.at);
}

/// With what else is wrong, if anything is.
void add_boundary(World& w, const BuiltBodies& built, Findings& found) {
  check_places(w, built, found);
  found.look([&] { w.boundary = std::make_unique<BoundaryConditions>(w.spec, *w.discretisation, built.surface, w.neighbours.joints); });
  found.throw_if_any();
}

/// Points and surface of a body; a rigid one has neither. `boxes`: in which points are seeded that have domains, if not in the
/// cells of the grid; has_field: it may part from others.
void add_body(World& w, BuiltBodies& built, MpmDiscretisation& mpm, const std::optional<Grid>& boxes, int index, bool has_field) {
  const Case& c = w.spec;
  const Body& body = c.bodies[index];
  const double h = mpm.cell_size(), spacing = h / surface_points_per_cell(c);
  std::vector<SurfacePoint>& surface = built.surface;
  BodySummary summary = summary_of(c, body, h);
  if (body.rigid) {
    w.bodies.push_back(summary);
    return;
  }
  const Material& material = *material_of(c, index);
  const std::size_t first_piece = surface.size();
  SeededPoints points;
  double farthest = 0.0;  // points of a mesh from each other
  if (body.points.kind == PointSeeding::Kind::mesh || !body.mesh_file.empty()) {
    const Mesh mesh = body_mesh(c, body, body.points.mesh);
    points = of_body(c, body, [&] { return seed_from_mesh(mesh, body.points.per_element); });
    summary.elements = mesh.n_cells();
    farthest = longest_edge(mesh);
    if (body.shape) {
      const Region region = region_of(c, body, h);
      fit_to_cells(points, region, mpm.grid());
      add_surface_of_shape(c, index, region, spacing, surface);
    } else {
      add_surface_of_mesh(c, index, mesh, spacing, surface);
    }
  } else {
    const Region region = region_of(c, body, h);
    PointSeeding seeding = body.points;
    if (has_domains(c.shape_functions)) seeding.placement = PointSeeding::Placement::uniform;
    points = seed_from_grid(region, boxes ? *boxes : mpm.grid(), seeding, body.name);
    add_surface_of_shape(c, index, region, spacing, surface);
  }
  mpm.add_body(index, body.name, material, points, c.thickness);
  if (has_field) mpm.tell_surface(ways_to_surface(points.x, std::span(surface).subspan(first_piece), rim_width * h));
  for (std::size_t p = 0; p < points.x.size(); ++p) {
    summary.measure += points.measure[p];
    summary.mass += points.measure[p] * depth(c.space, c.thickness, points.x[p].x()) * material.density;
  }
  summary.points = static_cast<int>(points.x.size());
  w.bodies.push_back(summary);
  w.parts[index] = parts_of_points(points.x, points.measure, std::max(farthest, longest_edge(mpm.grid().mesh)), c.dimension());
  built.places[index] = std::move(points.x), built.measures[index] = std::move(points.measure);
}

void build_mpm(World& w, BuiltBodies& built) {
  const Case& c = w.spec;
  Grid grid = make_grid(c);
  check_mixed_grid(c, grid.mesh);
  const ShapeChoice functions = shape_choice(c);
  const double ghost_penalty = c.solver.ghost_penalty.value_or(default_ghost_penalty(c, functions));
  auto mpm = std::make_unique<MpmDiscretisation>(std::move(grid), c.space, ghost_penalty, c.formulation, w.comm, c.volumetric,
                                                 functions);
  // Boxes tile a body; triangles and tetrahedra would get boxes that overlap.
  std::optional<Grid> boxes;
  if (const auto* structure = mpm->grid().structure.get();
      structure && has_domains(c.shape_functions) && is_simplex(mpm->grid().mesh.kinds[0]))
    boxes = boxes_of(*structure);
  mpm->tell_origin(c.origin);
  const double h = mpm->cell_size();
  const std::vector<SurfacePoint>& surface = built.surface;
  const std::vector<int> meets_others = fields_of_bodies(c);
  Findings found;
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    found.look([&] { add_body(w, built, *mpm, boxes, static_cast<int>(b), meets_others[b] > 0); });
  found.throw_if_any();
  found.look([&] { refuse_overlaps(c, built, h); });
  found.look([&] { w.neighbours = find_neighbours(c, surface, h); });
  w.layers = layers_of_bodies(c, w.neighbours, (mpm->degree() + 1) * h, [&](const SurfacePoint& s) { return in_one_cell(*mpm, s); });
  mpm->set_fields(w.layers, 1 + (w.layers.empty() ? 0 : *std::max_element(w.layers.begin(), w.layers.end())));
  found.look([&] { refuse_glued_gaps(w, *mpm, surface); });
  warn_of_corners(w);
  w.discretisation = std::move(mpm);
  add_boundary(w, built, found);
}

/// In MPM common nodes would join the two, which refuse_glued_gaps sees.
void tell_narrow_gaps(World& w) {
  for (const auto& [pair, gap] : w.neighbours.nearly)
    w.warnings.push_back(fmt::format("bodies \"{}\" and \"{}\" are {:.3g} m apart and not joined: what touches shall have no gap in the file",
                                           w.spec.bodies[pair.first].name, w.spec.bodies[pair.second].name, gap));
}

void build_fem(World& w, BuiltBodies& built) {
  const Case& c = w.spec;
  auto fem = std::make_unique<FemDiscretisation>(c.space, w.comm);
  std::vector<SurfacePoint>& surface = built.surface;
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    const Body& body = c.bodies[b];
    const int index = static_cast<int>(b);
    if (body.rigid) continue;
    const Material& material = *material_of(c, index);
    const Mesh mesh = body_mesh(c, body, body.mesh);
    fem->add_body(index, body.name, material, mesh, c.thickness);
    if (!body.mesh_file.empty()) tell_seams(w, body.name, mesh);
    BodySummary summary = summary_of(c, body, fem->cell_size());
    std::vector<Vec3> centres;
    std::vector<double> measures;
    for (int e = 0; e < mesh.n_cells(); ++e) {
      centres.push_back(cell_centre(mesh, e));
      measures.push_back(cell_measure(mesh, e));
      summary.measure += measures.back();
      summary.mass += measures.back() * depth(c.space, c.thickness, centres.back().x()) * material.density;
    }
    w.parts[b] = parts_of_mesh(mesh);
    built.places[b] = std::move(centres), built.measures[b] = std::move(measures);
    summary.points = fem->points_of_body(index);
    summary.elements = mesh.n_cells();
    add_surface_of_mesh(c, index, mesh, fem->cell_size() / surface_points_per_cell(c), surface);
    w.bodies.push_back(summary);
  }
  for (const Body& body : c.bodies)
    if (body.rigid) w.bodies.push_back(summary_of(c, body, fem->cell_size()));
  Findings found;
  found.look([&] { refuse_overlaps(c, built, fem->cell_size()); });
  found.look([&] { w.neighbours = find_neighbours(c, surface, fem->cell_size()); });
  tell_narrow_gaps(w);
  w.discretisation = std::move(fem);
  add_boundary(w, built, found);
}

/// Names of the deformable bodies of a field, for a sentence.
std::string bodies_of_field(const Case& c, const std::vector<int>& field, int wanted) {
  std::string text;
  for (std::size_t body = 0; body < field.size(); ++body)
    if (field[body] == wanted && !c.bodies[body].rigid)
      text += fmt::format("{}\"{}\"", text.empty() ? "" : ", ", c.bodies[body].name);
  return text;
}

/// Bodies that share places of the grid at the start, have nodes of their own there, and no contact: nothing will keep
/// them apart. Collective.
void warn_of_missing_contacts(World& w) {
  const Case& c = w.spec;
  if (c.method == Method::fem) return;
  const std::vector<int>& field = w.layers;
  std::set<std::pair<int, int>> kept_apart, meet;
  for (const Joint& j : w.neighbours.joints) kept_apart.insert(std::minmax(field[j.body], field[j.other]));
  for (const auto& [a, b] : w.neighbours.parted) kept_apart.insert(std::minmax(field[a], field[b]));  // by the body between them
  for (const Contact& contact : c.contacts) {
    if (contact.other.empty()) continue;
    const auto [a, b] = bodies_of(c, contact);
    kept_apart.insert(std::minmax(field[a], field[b]));
  }
  for (const Interface& at : w.discretisation->interfaces()) meet.insert({at.field_a, at.field_b});
  std::vector<std::array<int, 2>> mine;
  for (const auto& [a, b] : meet) mine.push_back({a, b});
  for (const auto& [a, b] : w.comm.all_gather(mine)) meet.insert({a, b});
  constexpr int most = 5;
  int told = 0;
  for (const auto& [a, b] : meet)
    if (kept_apart.count({a, b}) == 0 && ++told <= most)
      w.warnings.push_back(fmt::format("{} and {} lie next to each other and do not share nodes because of other "
                                       "contacts: without a [contact.NAME] they will pass through each other",
                                       bodies_of_field(c, field, a), bodies_of_field(c, field, b)));
  if (told > most) w.warnings.push_back(fmt::format("{} more pairs of bodies lie next to each other without a [contact.NAME]", told - most));
}

/// Small strain and total Lagrangian see bodies where they started: those that are apart then never have all the nodes in common on
/// which they should press, or none.
void refuse_contacts_out_of_sight(const World& w) {
  const Case& c = w.spec;
  if (moves_through_grid(c)) return;
  for (const Contact& contact : c.contacts)
    if (!contact.other.empty() && w.neighbours.apart.count(bodies_of(c, contact)))
      throw InputError(
          fmt::format("[contact.{}]: \"{}\" and \"{}\" start apart, and with {} the grid sees them where they start: they would pass through each other, or "
                      "press on nodes that are not at their surfaces. Take [model] kinematics = \"finite\" and formulation = \"updated_lagrangian\"",
                      contact.name, contact.body, contact.other, c.kinematics == Kinematics::small ? "small strain" : "total Lagrangian"));
}

/// A cell whose softening is nearly vertical (l close to 2 E Gf / ft^2) gives brittle, step-dependent answers.
void collect_warnings(World& w) {
  // No error: a body may move there later.
  for (const std::string& name : w.boundary->idle_boundaries())
    w.warnings.push_back(fmt::format("[boundary.{}] holds nothing at the start: no body touches its nodes", name));
  for (const std::string& warning : w.boundary->warnings()) w.warnings.push_back(warning);
  const auto rests = [](const NodeBoundary& b) {
    return b.un.is_zero() && std::all_of(b.u.begin(), b.u.end(), [](const auto& u) { return !u || u->is_zero(); });
  };
  if (w.boundary->n_free() == 0 && std::all_of(w.spec.boundaries.begin(), w.spec.boundaries.end(), rests))
    w.warnings.push_back("every node is held: nothing can move");
  const MaterialState& m = w.discretisation->material;
  for (const Slice& slice : m.slices) {
    double longest = 0.0;
    for (int p = slice.begin; p < slice.end; ++p) longest = std::max(longest, m.length[p]);
    longest = w.comm.max(longest);
    const std::string problem = std::visit([&](const auto& law) { return law.check(4.0 * longest); }, slice.law);
    if (!problem.empty())
      w.warnings.push_back(
          fmt::format("body \"{}\": a crack-band length of {:.4g} m is more than a quarter of what the "
                      "fracture energy allows: use smaller cells",
                      w.spec.bodies[slice.body].name, longest));
  }
  warn_of_missing_contacts(w);
  for (std::string& warning : w.warnings) warning = with_places(w.spec, warning);
  w.warnings.insert(w.warnings.begin(), w.spec.warnings.begin(), w.spec.warnings.end());  // have theirs
}

}  // namespace

double grid_bytes(const Case& c) {
  constexpr double bytes_per_cell = 120.0;  // nodes, neighbours, numbers
  const auto* s = std::get_if<StructuredGrid>(&c.grid);
  return c.method == Method::mpm && s ? bytes_per_cell * s->nx * s->ny * std::max(1, s->nz) : 0.0;
}

double longest_edge(const Mesh& mesh) {
  double longest = 0.0;
  for (int cell = 0; cell < mesh.n_cells(); ++cell)
    for (int k = 1; k < corners_of(mesh.kinds[cell]); ++k)
      longest = std::max(longest, (mesh.nodes[mesh.cell(cell)[k]] - mesh.nodes[mesh.cell(cell)[k - 1]]).norm());
  return longest;
}

void World::begin_step() {
  discretisation->move_points(spec.parallel.rebalance);
  boundary->move_anchors(*discretisation);
  discretisation->set_pairs(boundary->pairs());
  discretisation->begin_step(boundary->anchors());
  boundary->begin_step(*discretisation);
  if (!boundary->grid_contact().empty()) discretisation->look_at_interfaces(boundary->fixed());
  step_begun = true;
}

namespace {

/// Everything but the memory that it takes may be wrong.
void build(World& w) {
  w.parts.resize(w.spec.bodies.size());
  BuiltBodies built{{}, std::vector<std::vector<Vec3>>(w.spec.bodies.size()), std::vector<std::vector<double>>(w.spec.bodies.size())};
  if (w.spec.method == Method::mpm)
    build_mpm(w, built);
  else
    build_fem(w, built);
  double youngs = 0.0;
  for (const Material& m : w.spec.materials)
    youngs = std::max(youngs, std::visit([](const auto& law) { return law.stiffness(); }, m.law));
  const double h = w.discretisation->cell_size();
  w.elastic_scale = youngs * h * (is_plane(w.spec.space) ? w.spec.thickness : h);
  w.discretisation->move_points(w.spec.parallel.rebalance);
  w.begin_step();
  w.discretisation->start_motion([&](int body, const Vec3& X) { return w.spec.bodies[body].velocity.at(0.0, X); });
  Findings found;
  found.look([&] { refuse_contacts_out_of_sight(w); });
  const auto* mpm = dynamic_cast<const MpmDiscretisation*>(w.discretisation.get());
  if (mpm) found.look([&] { refuse_hanging_bodies(w, *mpm, built.surface); });
  found.throw_if_any();
  if (mpm) warn_of_loose_supports(w, *mpm, built.surface);
  note_thin_parts(w, built.surface);
  warn_of_proportions(w, built);
  warn_of_loaded_joints(w, built.surface);
  warn_of_flat_cells(w);
  warn_of_strangers(w);
  collect_warnings(w);
}

}  // namespace

std::unique_ptr<World> build_world(Case spec, const Comm& comm) {
  auto w = std::make_unique<World>();
  w->spec = std::move(spec);
  w->comm = comm;
  count_from_the_grid(w->spec);
  try {
    tell_places(w->spec, [&] { build(*w); });
  } catch (const std::bad_alloc&) {
    const double grid = grid_bytes(w->spec);
    throw InputError("not enough memory to build the model: " +
                     (grid > 0.0 ? fmt::format("the cells of [grid] alone need about {:.2g} GB, used or not: make the grid smaller around the bodies, "
                                               "or its cells larger",
                                               grid / 1e9)
                                 : "take larger cells"));
  }
  return w;
}

}  // namespace berm
