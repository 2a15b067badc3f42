/// Bodies: shape or file, material, material points, meshes.

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "base/reach.hpp"
#include "case/tables.hpp"
#include "mesh/shape_bounds.hpp"

namespace berm {
namespace {

const WordsByDimension<BodyMeshKind> mesh_kinds = {
    {{"quads", BodyMeshKind::quads}, {"triangles", BodyMeshKind::triangles}},
    {{"hexahedra", BodyMeshKind::hexahedra}, {"tetrahedra", BodyMeshKind::tetrahedra}}};
const Range mesh_order = {1.0, 2.0};
const std::string structured_doc =
    "regular rows of elements; discs, cylinders and shapes made of boxes; always with hexahedra";

/// There are hexahedra in regular rows only: `structured` need not be said of them.
void settle_structured(const Scope& scope, BodyMeshOptions& mesh) {
  if (mesh.kind != BodyMeshKind::hexahedra || mesh.structured) return;
  if (scope.has("structured")) return scope.error("structured", "must be true for hexahedra; else take tetrahedra");
  mesh.structured = true;
  scope.node.set("structured", Node(true, scope.place));
}

/// The default of `kind` depends on other keys.
void check_mesh(const Scope& scope, BodyMeshOptions& mesh) {
  if (!scope.has("kind")) {
    if (scope.dimension() == 3) mesh.kind = mesh.structured ? BodyMeshKind::hexahedra : BodyMeshKind::tetrahedra;
    for (const auto& [name, kind] : mesh_kinds.of(scope.dimension())) {
      if (kind == mesh.kind) scope.node.set("kind", Node(name, scope.place));
    }
  }
  settle_structured(scope, mesh);
}

Table<BodyMeshOptions> mesh_table() {
  Table<BodyMeshOptions> t("Finite element mesh of the body (method \"fem\").");
  t.choice("kind", &BodyMeshOptions::kind, mesh_kinds,
           "shape of the elements (default quads; in space hexahedra if `structured` is true, else tetrahedra)");
  t.no_default();
  t.number("size", &BodyMeshOptions::size, Unit::length, positive(), "edge length").required();
  t.integer("order", &BodyMeshOptions::order, mesh_order, "1: linear, 2: quadratic elements");
  t.boolean("structured", &BodyMeshOptions::structured, structured_doc);
  t.check([](Scope& s, BodyMeshOptions& mesh) { check_mesh(s, mesh); });
  return t;
}

/// Gauss rules that the program has: of one kind of element, or of all kinds of a dimension.
std::vector<int> gauss_rules(std::optional<BodyMeshKind> kind, int dimension) {
  if (!kind && dimension == 2) return {1, 3, 4, 6, 9, 12, 16};
  if (!kind) return {1, 4, 8, 27};
  switch (*kind) {
    case BodyMeshKind::quads:
      return {1, 4, 9, 16};
    case BodyMeshKind::triangles:
      return {1, 3, 6, 12};
    case BodyMeshKind::hexahedra:
      return {1, 8, 27};
    case BodyMeshKind::tetrahedra:
      break;
  }
  return {1, 4};
}

bool from_file(const Scope& points) { return points.outer && points.outer->has("file"); }

void check_points(Scope& scope, PointSeeding& p) {
  const bool has_mesh = scope.has("mesh");
  if (!has_mesh && !from_file(scope)) return;
  p.kind = PointSeeding::Kind::mesh;
  const std::vector<int> rules = gauss_rules(has_mesh ? std::optional(p.mesh.kind) : std::nullopt, scope.dimension());
  if (has_mesh) settle_structured(scope, p.mesh);
  if (has_mesh && !scope.has("per_element")) {
    p.per_element = rules[1];
    scope.node.set("per_element", Node(std::int64_t{p.per_element}, scope.place));
  }
  if (std::find(rules.begin(), rules.end(), p.per_element) != rules.end()) return;
  scope.error("per_element", fmt::format("must be one of {}, is {}", fmt::join(rules, ", "), p.per_element));
}

Table<PointSeeding> points_table() {
  const auto on_grid = [](const Scope& s, const PointSeeding&) { return !s.has("mesh") && !from_file(s); };
  const auto with_shape = [](const Scope& s, const PointSeeding&) { return !from_file(s); };
  const auto on_mesh = [](const Scope& s, const PointSeeding&) { return s.has("mesh") || from_file(s); };
  const std::string on_grid_text = "without \"mesh\", in bodies with a shape";
  const std::vector<std::pair<std::string, PointSeeding::Placement>> placements = {
      {"automatic", PointSeeding::Placement::automatic},
      {"gauss", PointSeeding::Placement::gauss}, {"uniform", PointSeeding::Placement::uniform}};
  Table<PointSeeding> t(
      "Where the material points start (method \"mpm\"): in the cells of the background grid, or at the Gauss points "
      "of a mesh of the body.");
  t.choice(
      "mesh", [](PointSeeding & p) -> auto& { return p.mesh.kind; }, mesh_kinds,
      "seed from a mesh of the body with these elements");
  t.no_default().only(with_shape, "in bodies with a shape");
  t.integer("per_direction", &PointSeeding::per_direction, {1.0, 20.0}, "points per grid cell and direction");
  t.only(on_grid, on_grid_text);
  t.choice("placement", &PointSeeding::placement, placements, "positions in grid cells that the body fills: where Gauss's rule has them, or "
           "evenly spaced; automatic: evenly spaced if points have domains (grid.shape_functions), else Gauss's");
  t.only(on_grid, on_grid_text);
  t.number(
      "size", [](PointSeeding & p) -> auto& { return p.mesh.size; }, Unit::length, positive(),
      "edge length of that mesh");
  t.required().only_with("mesh");
  t.integer(
      "order", [](PointSeeding & p) -> auto& { return p.mesh.order; }, mesh_order, "order of that mesh");
  t.only_with("mesh");
  t.boolean(
      "structured", [](PointSeeding & p) -> auto& { return p.mesh.structured; }, "that mesh has " + structured_doc);
  t.only_with("mesh");
  t.integer("per_element", &PointSeeding::per_element, {1.0, 27.0},
            "Gauss points of an element: triangles 1, 3, 6, 12 (default 3); quads 1, 4, 9, 16 (default 4); tetrahedra "
            "1, 4 (default 4); hexahedra 1, 8, 27 (default 8)");
  t.no_default().only(on_mesh, "with \"mesh\", or in bodies from a file (there it is required)");
  t.check(check_points);
  return t;
}

/// `kind`: the key that tells the kind of the elements.
void check_structured(const Scope& scope, std::string_view key, std::string_view kind, const BodyMeshOptions& mesh,
                      const Body& body) {
  Node::Entry* entry = scope.node.find(key);
  if (!entry || !mesh.structured || !body.shape || has_structured_mesh(*body.shape)) return;
  const Scope table = *scope.child(*entry);
  if (scope.dimension() == 2) {
    table.error("structured", "is for discs and shapes made of boxes");
  } else if (mesh.kind == BodyMeshKind::hexahedra) {
    table.explain(kind, "hexahedra are for cylinders and shapes made of boxes; take tetrahedra");
  } else {
    table.error("structured", "is for cylinders and shapes made of boxes");
  }
}

/// Also finds what is wrong with a plane shape, and with a surface from a file.
void check_reach(const Scope& scope, const Body& body) {
  if (!body.shape) return;
  const auto* plane = std::get_if<PlaneShape>(&*body.shape);
  try {
    const SolidBox around = bounds_of(*body.shape);  // maps have large coordinates: the size counts
    if (const double farthest = around.min.cwiseAbs().cwiseMax(around.max.cwiseAbs()).maxCoeff(); farthest > farthest_place && around.max.x() >= around.min.x())
      return scope.explain("shape", fmt::format("reaches {:.3g} m: places must lie within {:g} m of the origin", farthest, farthest_place));
    if (plane) PlaneRegion{*plane};  // throws if it is none
    const double size = (around.max - around.min).maxCoeff();
    if (size > 1000.0) scope.warn("shape", fmt::format("[{}] is {:.6g} m long: did you mean mm?", scope.path, size));
  } catch (const InputError& error) {
    if (plane) return scope.explain("shape", error.what());
    scope.child(*scope.node.find("shape"))->explain("surface", error.what());
  }
}

void check_body(Scope& scope, Body& body) {
  scope.exactly_one({"shape", "file"});
  check_structured(scope, "points", "mesh", body.points.mesh, body);
  check_structured(scope, "mesh", "kind", body.mesh, body);
  check_reach(scope, body);
}

}  // namespace

Table<Body> body_table() {
  const auto deformable = [](const Scope&, const Body& b) { return !b.rigid; };
  const auto meshed = [](const Scope& s, const Body& b) { return !b.rigid && !s.has("file"); };
  const auto rigid = [](const Scope&, const Body& b) { return b.rigid; };
  Table<Body> t("A deformable body, or a rigid one that pushes. One of `shape` and `file`.");
  t.boolean("rigid", &Body::rigid, "moves as told and never deforms");
  t.name("material", &Body::material, "name of a material", "what it is made of");
  t.required().only(deformable, "in deformable bodies");
  t.custom(shape_info(), read_shape);
  t.file("file", &Body::mesh_file, "Gmsh mesh (.msh 2.2 or 4.1) of plane cells; in space of volume cells");
  t.only(deformable, "in deformable bodies");
  t.name("group", &Body::mesh_group, "name of a physical surface (in space: volume)",
           "part of the file that is the body; else all cells");
  t.only_with("file");
  t.table("points", &Body::points, points_table()).only(deformable, "in deformable bodies");
  t.table("mesh", &Body::mesh, mesh_table());
  t.no_default().only(meshed, "in deformable bodies with a shape");
  t.vector_function("displacement", &Body::displacement, Unit::length,
                    "motion; a number is reached linearly at the end of the first stage");
  t.only(rigid, "in rigid bodies (deformable ones are moved by [boundary.NAME])");
  t.vector_function("acceleration", &Body::acceleration, Unit::acceleration,
                    "of a force on all of its mass, beside gravity, at its places x, y, z at the start; a number is reached "
                    "as gravity's are",
                    true);
  t.only(deformable, "in deformable bodies");
  t.vector_function("velocity", &Body::velocity, Unit::velocity, "of its places x, y, z at the start (dynamic)", true);
  t.only(deformable, "in deformable bodies");
  t.check(check_body);
  return t;
}

}  // namespace berm
