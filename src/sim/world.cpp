#include "sim/world.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "base/error.hpp"
#include "fem/fem.hpp"
#include "mesh/gmsh.hpp"
#include "transfer/mpm.hpp"

namespace berm {
namespace {

const Material& material_of(const Case& c, const Body& body) {
  for (const Material& m : c.materials)
    if (m.name == body.material) return m;
  throw InputError("body \"" + body.name + "\" has no material");
}

/// A mesh reduced to the cells of one physical surface.
Mesh extract_group(const Mesh& mesh, const std::string& group, const std::string& file) {
  if (group.empty()) return mesh;
  const auto found = mesh.cell_groups.find(group);
  if (found == mesh.cell_groups.end()) {
    std::string names;
    for (const auto& [name, cells] : mesh.cell_groups) names += (names.empty() ? "" : ", ") + name;
    throw InputError(fmt::format("{}: no physical surface named \"{}\" (there is: {})", file, group,
                                 names.empty() ? "none" : names));
  }
  Mesh out;
  std::vector<int> number(mesh.nodes.size(), -1);
  std::array<int, 8> list{};
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

Mesh body_mesh(const Body& body, const BodyMeshOptions& options) {
  if (!body.mesh_file.empty()) return extract_group(read_msh(body.mesh_file), body.mesh_group, body.mesh_file);
  return mesh_shape(*body.shape, options);
}

SurfacePoint surface_point(int body, const Vec2& x, const Vec2& normal, double length) {
  SurfacePoint s;
  s.anchor.body = body;
  s.anchor.X = s.anchor.x = x;
  s.normal = normal;
  s.anchor.inward = -normal;
  s.length = length;
  return s;
}

/// Surface of a meshed body: every boundary edge in equal pieces no longer than `spacing`.
BodySurface surface_of_mesh(int body, const Mesh& mesh, double spacing) {
  BodySurface surface;
  surface.body = body;
  std::map<int, std::vector<std::string>> groups;
  for (const auto& [name, nodes] : mesh.node_groups)
    for (int node : nodes) groups[node].push_back(name);
  for (const Edge& e : boundary_edges(mesh)) {
    const int n = corners_of(mesh.kinds[e.cell]);
    const int a = mesh.cell(e.cell)[e.local], b = mesh.cell(e.cell)[(e.local + 1) % n];
    const Vec2 p = mesh.nodes[a], t = mesh.nodes[b] - p;
    const int pieces = std::max(2, static_cast<int>(std::ceil(t.norm() / spacing)));
    std::vector<std::string> common;
    for (const std::string& name : groups[a])
      if (std::find(groups[b].begin(), groups[b].end(), name) != groups[b].end()) common.push_back(name);
    for (int k = 0; k < pieces; ++k) {
      surface.points.push_back(
          surface_point(body, p + t * ((k + 0.5) / pieces), Vec2(t.y(), -t.x()).normalized(), t.norm() / pieces));
      surface.points.back().groups = common;
    }
  }
  return surface;
}

BodySurface surface_of_shape(int body, const Region& region, double spacing) {
  BodySurface surface;
  surface.body = body;
  for (const BoundaryPiece& piece : region.boundary(spacing))
    surface.points.push_back(surface_point(body, piece.centre, piece.normal, piece.length));
  return surface;
}

/// Surface points stand this many to a cell: enough for the ends of a loaded arc to count.
constexpr double surface_points_per_cell = 10.0;

/// Name and kind; the area too if the body is rigid, since nothing else will tell.
BodySummary summary_of(const Body& body) {
  BodySummary summary;
  summary.name = body.name;
  summary.rigid = body.rigid;
  if (body.rigid) summary.area = Region(*body.shape).area();
  return summary;
}

void build_mpm(World& w) {
  const Case& c = w.spec;
  Grid grid;
  std::map<std::string, std::vector<int>> node_groups;
  if (const auto* structured = std::get_if<StructuredGrid>(&c.grid)) {
    grid = make_structured_grid(*structured);
  } else {
    Mesh mesh = read_msh(std::get<std::string>(c.grid));
    node_groups = mesh.node_groups;
    grid = make_unstructured_grid(std::move(mesh));
  }
  auto mpm = std::make_unique<MpmDiscretisation>(std::move(grid), c.solver.ghost_penalty, c.formulation);
  const double spacing = mpm->cell_size() / surface_points_per_cell;
  std::vector<BodySurface> surfaces;
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    const Body& body = c.bodies[b];
    BodySummary summary = summary_of(body);
    if (body.rigid) {
      w.bodies.push_back(summary);
      continue;
    }
    const Material& material = material_of(c, body);
    SeededPoints points;
    if (body.points.kind == PointSeeding::Kind::mesh || !body.mesh_file.empty()) {
      const Mesh mesh = body_mesh(body, body.points.mesh);
      points = seed_from_mesh(mesh, body.points.per_element);
      if (body.shape) fit_to_cells(points, Region(*body.shape), mpm->grid());
      surfaces.push_back(body.shape ? surface_of_shape(static_cast<int>(b), Region(*body.shape), spacing)
                                    : surface_of_mesh(static_cast<int>(b), mesh, spacing));
      summary.elements = mesh.n_cells();
    } else {
      const Region region(*body.shape);
      points = seed_from_grid(region, mpm->grid(), body.points, body.name);
      surfaces.push_back(surface_of_shape(static_cast<int>(b), region, spacing));
    }
    mpm->add_body(static_cast<int>(b), body.name, material, points, c.thickness);
    for (double a : points.area) summary.area += a;
    summary.points = static_cast<int>(points.x.size());
    summary.mass = summary.area * c.thickness * material.density;
    w.bodies.push_back(summary);
  }
  w.boundary = std::make_unique<BoundaryConditions>(w.spec, *mpm, std::move(surfaces), node_groups);
  w.discretisation = std::move(mpm);
}

void build_fem(World& w) {
  const Case& c = w.spec;
  auto fem = std::make_unique<FemDiscretisation>();
  std::vector<BodySurface> surfaces;
  for (std::size_t b = 0; b < c.bodies.size(); ++b) {
    const Body& body = c.bodies[b];
    BodySummary summary = summary_of(body);
    if (body.rigid) {
      w.bodies.push_back(summary);
      continue;
    }
    const Material& material = material_of(c, body);
    const Mesh mesh = body_mesh(body, body.mesh);
    const int before = fem->material.size();
    fem->add_body(static_cast<int>(b), body.name, material, mesh, c.thickness);
    for (int e = 0; e < mesh.n_cells(); ++e) summary.area += cell_area(mesh, e);
    summary.points = fem->material.size() - before;
    summary.elements = mesh.n_cells();
    summary.mass = summary.area * c.thickness * material.density;
    surfaces.push_back(surface_of_mesh(static_cast<int>(b), mesh, fem->cell_size() / surface_points_per_cell));
    w.bodies.push_back(summary);
  }
  w.boundary = std::make_unique<BoundaryConditions>(w.spec, *fem, std::move(surfaces), fem->mesh().node_groups);
  w.discretisation = std::move(fem);
}

/// A cell whose softening is nearly vertical (l close to 2 E Gf / ft^2) gives brittle, step-dependent answers.
void collect_warnings(World& w) {
  w.warnings = w.spec.warnings;
  // No error: a body may move there later.
  if (const std::string name = w.boundary->idle_boundary(*w.discretisation); !name.empty())
    w.warnings.push_back(fmt::format("[boundary.{}] holds nothing at the start: no body touches its nodes", name));
  const MaterialState& m = w.discretisation->material;
  for (const Slice& slice : m.slices) {
    const double longest = *std::max_element(m.length.begin() + slice.begin, m.length.begin() + slice.end);
    const std::string problem = std::visit([&](const auto& law) { return law.check(4.0 * longest); }, slice.law);
    if (!problem.empty())
      w.warnings.push_back(
          fmt::format("body \"{}\": a crack-band length of {:.4g} m is more than a quarter of what the "
                      "fracture energy allows: use smaller cells",
                      w.spec.bodies[slice.body].name, longest));
  }
}

/// Pins, gauges and probes must lie in a deformable body.
void check_places(const World& w) {
  const Discretisation& d = *w.discretisation;
  const std::vector<Vec2> points = d.point_positions();
  const double reach = 1.5 * d.cell_size();
  auto check = [&](const char* kind, const std::string& name, const Vec2& x) {
    for (const Vec2& p : points)
      if ((p - x).norm() <= reach) return;
    throw InputError(fmt::format("[{}.{}]: the point ({:.6g}, {:.6g}) lies outside of every deformable body", kind,
                                 name, x.x(), x.y()));
  };
  for (const Pin& p : w.spec.pins) check("pin", p.name, p.at);
  for (const Gauge& g : w.spec.output.gauges) {
    check("gauge", g.name, g.from);
    check("gauge", g.name, g.to);
  }
  for (const Probe& p : w.spec.output.probes) check("probe", p.name, p.at);
}

}  // namespace

std::unique_ptr<World> build_world(Case spec) {
  auto w = std::make_unique<World>();
  w->spec = std::move(spec);
  if (w->spec.method == Method::mpm)
    build_mpm(*w);
  else
    build_fem(*w);
  double youngs = 0.0;
  for (const Material& m : w->spec.materials)
    youngs = std::max(youngs, std::visit([](const auto& law) { return law.youngs_modulus; }, m.law));
  w->elastic_scale = youngs * w->discretisation->cell_size() * w->spec.thickness;
  check_places(*w);
  w->discretisation->begin_step(w->boundary->anchors());
  w->boundary->begin_step(*w->discretisation);
  collect_warnings(*w);
  return w;
}

std::string describe(const World& w) {
  const Discretisation& d = *w.discretisation;
  std::string text;
  auto line = [&](const std::string& s) { text += s + "\n"; };
  line(fmt::format("{}", w.spec.title));
  line(fmt::format("  method            {}, plane {}, {} strain",
                   w.spec.method == Method::fem                          ? "fem"
                   : w.spec.formulation == Formulation::total_lagrangian ? "mpm, total Lagrangian"
                                                                         : "mpm",
                   w.spec.plane == Plane::strain ? "strain" : "stress",
                   w.spec.kinematics == Kinematics::finite ? "finite" : "small"));
  for (const BodySummary& b : w.bodies)
    line(b.rigid ? fmt::format("  body {:<12} rigid, {:.6g} m2", b.name, b.area)
                 : fmt::format("  body {:<12} {:.6g} m2, {:.6g} kg, {} points{}", b.name, b.area, b.mass, b.points,
                               b.elements ? fmt::format(", {} elements", b.elements) : ""));
  const int cells = [&] {
    if (const auto* mpm = dynamic_cast<const MpmDiscretisation*>(&d))
      return static_cast<int>(mpm->active_cells().size());
    return d.blocks.size();
  }();
  const int dofs = w.boundary->n_equations();
  line(fmt::format("  cells             {} in use, {:.2f} points each", cells, double(d.material.size()) / cells));
  line(fmt::format("  cell size         {:.6g} m", d.cell_size()));
  line(fmt::format("  unknowns          {}", dofs));
  // Two-dimensional nested dissection: about 31 n log2(n) entries in the factors (George 1973), 8 bytes each.
  const double factor = 31.0 / 2.0 * dofs * std::log2(std::max(dofs, 2)) * 8.0;
  const double points = d.material.size() * 1000.0;
  line(fmt::format("  memory, estimated {:.0f} MB", (factor + points) / 1e6 + 60.0));
  line(fmt::format("  steps             {}{}", w.spec.steps.count, w.spec.steps.adaptive ? " (adaptive)" : ""));
  for (const std::string& warning : w.warnings) line("  warning: " + warning);
  return text;
}

}  // namespace berm
