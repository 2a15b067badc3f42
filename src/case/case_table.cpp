/// The whole case file: the tables put together, the model and the grid.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/reach.hpp"
#include "case/tables.hpp"

namespace berm {
namespace {

KeyInfo dimension_info() {
  KeyInfo info = plain_info("dimension", "2 or 3", "integer",
                            "a plane or axisymmetric model, or one in space: how many numbers places and vectors have");
  info.json = Node();
  info.json.set("enum", Node(Node::Array{Node(std::int64_t{2}), Node(std::int64_t{3})}));
  return info;
}

Table<Case> model_table() {
  Table<Case> t("What kind of problem it is.");
  t.custom(
      dimension_info(),
      [](Scope& s, Node::Entry&, Case& c) { c.space = s.dimension() == 3 ? Space::solid : Space::plane_strain; },
      [](Case&, int) { return std::optional<Node>(Node(std::int64_t{2})); });
  t.choice(
      "plane", &Case::space,
      Words<Space>{
          {"strain", Space::plane_strain}, {"stress", Space::plane_stress}, {"axisymmetric", Space::axisymmetric}},
      "plane strain, plane stress, or turned about the y axis: x is the radius, not negative, and loads are those of "
      "the full circle");
  t.only_in_plane();
  t.choice(
      "kinematics", &Case::kinematics,
      std::vector<std::pair<std::string, Kinematics>>{{"finite", Kinematics::finite}, {"small", Kinematics::small}},
      "finite (logarithmic) or small strain");
  t.choice("formulation", &Case::formulation,
           std::vector<std::pair<std::string, Formulation>>{{"updated_lagrangian", Formulation::updated_lagrangian},
                                                            {"total_lagrangian", Formulation::total_lagrangian}},
           "material points see the grid from where they are, or from where they started: no cell crossing, for bodies "
           "that crack but hardly move (method \"mpm\"). Default: total_lagrangian where all laws are of damage, or volumetric is "
           "mixed and nothing is soil, nothing is dynamic and deformable bodies do not touch each other, else updated_lagrangian")
      .no_default();
  t.choice("volumetric", &Case::volumetric,
           Words<Volumetric>{{"standard", Volumetric::standard}, {"f_bar", Volumetric::f_bar}, {"mixed", Volumetric::mixed}},
           "volumetric strain of a material point: its own; the mean over the points of its cell (f_bar); or that of a "
           "pressure with unknowns of its own at the nodes (mixed: stabilised u-p). The latter two do not lock where the "
           "volume hardly changes: undrained soil, metal, failure loads (method \"mpm\", not plane stress; f_bar: grids "
           "of quads or hexahedra). Default: f_bar, where it can be, with laws of plasticity and Poisson ratios from 0.45 (not beside fluids), "
           "else standard")
      .no_default();
  t.choice("quadrature", &Case::quadrature, Words<Quadrature>{{"points", Quadrature::points}, {"gauss", Quadrature::gauss}},
           "forces from the stresses at the material points; or inside of the body from those at Gauss points of the "
           "cells, by a linear fit over the points of each cell (gauss): uneven points then integrate as even ones do "
           "(method \"mpm\", volumetric = \"standard\", not around an axis, linear functions; a matrix without symmetry)");
  t.number("thickness", &Case::thickness, Unit::length, positive(), "of the plane");
  t.only([](const Scope&, const Case& c) { return is_plane(c.space); },
         "in plane strain and plane stress");
  t.boolean("allow_glued", &Case::allow_glued,
            "parts of bodies, or bodies and held nodes, that lie apart but so near that the functions of the grid join them are refused; "
            "true: they may hang together (method \"mpm\")");
  t.vector_function("gravity", &Case::gravity, Unit::acceleration, "a number is reached linearly at the end of the first stage, or holds from the start if that is dynamic");
  return t;
}

struct GridInput {
  std::string file;
  StructuredGrid structured;
  std::optional<Vec3> size;
  ShapeFunctions shape_functions = ShapeFunctions::linear;
};

constexpr Range cells_range = {1.0, 100000.0};

void read_cells(Scope& scope, Node::Entry& entry, GridInput& g) {
  const Node::Array* items = read_directions(scope, entry, "whole numbers", "n");
  if (!items) return;
  const std::array<int*, 3> counts = {&g.structured.nx, &g.structured.ny, &g.structured.nz};
  for (std::size_t i = 0; i < items->size(); ++i) {
    const Node::Entry item = {fmt::format("cells[{}]", i), (*items)[i].place, (*items)[i]};
    *counts[i] = read_integer(scope, item, cells_range).value_or(0);
  }
}

void read_cell_size(Scope& scope, Node::Entry& entry, GridInput& g) {
  if (entry.value.array()) {
    if (const auto edges = read_vector(scope, entry, Unit::length, positive())) g.structured.cell_size = *edges;
  } else if (const auto edge = read_number(scope, entry, Unit::length, positive())) {
    g.structured.cell_size = Vec3(*edge, *edge, scope.dimension() == 3 ? *edge : 0.0);
  }
}

KeyInfo cells_info() {
  KeyInfo info = vector_info("cells", Unit::none, cells_range, "number of cells along the sides");
  info.type = "[nx, ny(, nz)]";
  info.json.set("items", integer_info("", cells_range, "").json);
  return info;
}

KeyInfo cell_size_info() {
  KeyInfo info = vector_info("cell_size", Unit::length, positive(), "edge of a cell, or all its edges; or give `size`");
  info.type = "number or [dx, dy(, dz)] [m]";
  Node either;
  either.set("anyOf", Node(Node::Array{number_info("", Unit::length, positive(), "").json, info.json}));
  info.json = std::move(either);
  return info;
}

void check_grid(Scope& scope, GridInput& g) {
  const StructuredGrid& s = g.structured;
  const bool on_any = g.shape_functions == ShapeFunctions::linear || g.shape_functions == ShapeFunctions::cpdi;
  const bool boxes = !scope.has("file") && (s.kind == GridKind::quads || s.kind == GridKind::hexahedra);
  if (!on_any && !boxes)
    scope.explain("shape_functions",
                  "B-splines and GIMP need a regular grid of quads or hexahedra (kind = ...); \"linear\" and \"cpdi\" "
                  "work on any grid");
  if (scope.has("file")) return;
  scope.exactly_one({"cell_size", "size"});
  if (g.size) g.structured.cell_size = g.size->cwiseQuotient(Vec3(s.nx, s.ny, std::max(s.nz, 1)));
}

const Table<GridInput>& grid_table() {
  static const Table<GridInput> table = [] {
    const WordsByDimension<GridKind> kinds = {
        {{"quads", GridKind::quads},
         {"triangles_right", GridKind::triangles_right},
         {"triangles_left", GridKind::triangles_left},
         {"union_jack", GridKind::union_jack}},
        {{"hexahedra", GridKind::hexahedra}, {"tetrahedra", GridKind::tetrahedra}}};
    Table<GridInput> t("Background grid (method \"mpm\"): regular, or a Gmsh mesh of linear cells.");
    t.file("file", &GridInput::file, "Gmsh mesh (.msh 2.2 or 4.1)");
    t.choice(
         "kind", [](GridInput & g) -> auto& { return g.structured.kind; }, kinds,
         "cells, or how each is halved; tetrahedra: six a cell")
        .only_without("file");
    t.vector(
         "origin", [](GridInput & g) -> auto& { return g.structured.origin; }, Unit::length,
         "lower left corner (in space: lowest one), before the rotation", Range{-farthest_place, farthest_place})
        .only_without("file");
    t.custom(cells_info(), read_cells).required().only_without("file");
    t.custom(cell_size_info(), read_cell_size).only_without("file");
    t.choice("shape_functions", &GridInput::shape_functions,
             Words<ShapeFunctions>{{"linear", ShapeFunctions::linear},
                                   {"quadratic_bspline", ShapeFunctions::quadratic_bspline},
                                   {"cubic_bspline", ShapeFunctions::cubic_bspline},
                                   {"ugimp", ShapeFunctions::ugimp},
                                   {"cpgimp", ShapeFunctions::cpgimp},
                                   {"b2gimp", ShapeFunctions::b2gimp},
                                   {"cpdi", ShapeFunctions::cpdi}},
             "of the displacements; B-splines (quads and hexahedra) have no jumps of the gradient, where points that cross "
             "cells lose accuracy; supports of nodes ([boundary.NAME]) then have to lie on the edges of the grid. GIMP (quads "
             "and hexahedra): means over a box about the point, of linear functions, with the edges of the start (ugimp) or "
             "following the stretch (cpgimp), or of quadratic B-splines (b2gimp). cpdi (any grid): means over a parallelogram "
             "or parallelepiped that deforms with the body. Default: linear where no point crosses a cell (small strain, total Lagrangian) and none is of a mesh file, else cpgimp, for soil (without fluids) ugimp, or cpdi on grids without quads or hexahedra in rows")
        .no_default();
    t.vector("size", &GridInput::size, Unit::length, "of the whole grid; or give `cell_size`", positive())
        .only_without("file");
    t.number(
         "angle", [](GridInput & g) -> auto& { return g.structured.angle; }, Unit::angle, {},
         "counter-clockwise rotation about the origin; in space about the z axis")
        .only_without("file");
    t.check(check_grid);
    return t;
  }();
  return table;
}

void read_grid(Scope& scope, Node::Entry& entry, Case& c) {
  auto child = scope.child(entry);
  if (!child) return;
  GridInput g;
  grid_table().read(*child, g);
  c.shape_functions = g.shape_functions;
  if (g.file.empty()) {
    c.grid = g.structured;
  } else {
    c.grid = g.file;
  }
}

/// `base` and `remove` are obeyed, and taken out, while files are loaded (load.hpp).
void add_inheritance(Table<Case>& t) {
  const auto nothing_to_read = [](Scope&, Node::Entry&, Case&) {};
  KeyInfo remove =
      plain_info("remove", "array of strings", "array",
                 "tables and keys that are dropped from the base, e.g. [\"contact.top\", \"boundary.base\"]");
  remove.json.set("items", plain_info("", "", "string", "").json);
  t.custom(
      plain_info("base", "file", "string",
                 "case file that this one extends: tables are merged key by key, this file wins; arrays are replaced"),
      nothing_to_read);
  t.custom(remove, nothing_to_read);
}

Table<Case> make_case_table() {
  Table<Case> t("");
  const auto outputs = [](auto member) {
    return [=](Case & c) -> auto& { return c.output.*member; };
  };
  t.text("title", &Case::title, "one line for reports");
  add_inheritance(t);
  t.choice("method", &Case::method,
           std::vector<std::pair<std::string, Method>>{{"mpm", Method::mpm}, {"fem", Method::fem}},
           "material point method, or the finite element reference on the bodies' own meshes");
  t.table(
      "model", [](Case& c) -> Case& { return c; }, model_table());
  t.custom(table_info("grid", grid_table().doc(), grid_table().keys(), false), read_grid);
  t.named<decltype(&Case::materials), Material>("material", &Case::materials, material_doc(), material_keys(),
                                                read_material);
  t.named("body", &Case::bodies, body_table());
  t.named("boundary", &Case::boundaries, boundary_table());
  t.named("pin", &Case::pins, pin_table());
  t.named("pressure", &Case::pressures, pressure_table());
  t.named("absorbing", &Case::absorbing, absorbing_table());
  t.named("contact", &Case::contacts, contact_table());
  t.table("control", &Case::control, control_table());
  t.custom(stage_info(), read_stages);  // before [solver] and [dynamics] have their defaults written out
  t.table("steps", &Case::steps, steps_table()).only_without("stage");
  t.table("solver", &Case::solver, solver_table());
  t.table("dynamics", &Case::dynamics, dynamics_table());
  t.table("output", &Case::output, output_table());
  t.table("checkpoint", &Case::checkpoint, checkpoint_table());
  t.table("parallel", &Case::parallel, parallel_table());
  t.named("gauge", outputs(&Output::gauges), gauge_table());
  t.named("probe", outputs(&Output::probes), probe_table());
  return t;
}

}  // namespace

void check_dimension(const Scope& root) {
  Node::Entry* model = root.node.find("model");
  const Node::Entry* entry = model ? model->value.find("dimension") : nullptr;
  if (!entry) return;
  const Scope scope = *root.child(*model);
  const auto dimension = read_integer(scope, *entry, {});
  if (dimension && *dimension != 2 && *dimension != 3)
    scope.error("dimension", fmt::format("must be 2 or 3, is {}", *dimension));
}

const Table<Case>& case_table() {
  static const Table<Case> table = make_case_table();
  return table;
}

}  // namespace berm
