/// The whole case file: the tables put together, the model and the grid.

#include <fmt/format.h>

#include "case/tables.hpp"

namespace berm {
namespace {

Table<Case> model_table() {
  Table<Case> t("What kind of problem it is.");
  t.choice("plane", &Case::plane,
           std::vector<std::pair<std::string, Plane>>{{"strain", Plane::strain}, {"stress", Plane::stress}},
           "plane strain or plane stress");
  t.choice(
      "kinematics", &Case::kinematics,
      std::vector<std::pair<std::string, Kinematics>>{{"finite", Kinematics::finite}, {"small", Kinematics::small}},
      "finite (logarithmic) or small strain");
  t.choice("formulation", &Case::formulation,
           std::vector<std::pair<std::string, Formulation>>{{"updated_lagrangian", Formulation::updated_lagrangian},
                                                            {"total_lagrangian", Formulation::total_lagrangian}},
           "material points see the grid from where they are, or from where they started: no cell crossing, for bodies "
           "that crack but hardly move (method \"mpm\")");
  t.number("thickness", &Case::thickness, Unit::length, positive(), "of the plane");
  t.pair("gravity", &Case::gravity, Unit::acceleration, "at time 1, linear in time");
  return t;
}

struct GridInput {
  std::string file;
  StructuredGrid structured;
  std::optional<Vec2> size;
};

void read_cells(Scope& scope, Node::Entry& entry, GridInput& g) {
  const Node::Array* items = entry.value.array();
  if (!items || items->size() != 2) return scope.error("cells", "must be an array of two whole numbers");
  const Range range = {1.0, 100000.0};
  const auto nx = read_integer(scope, {"cells[0]", (*items)[0].place, (*items)[0]}, range);
  const auto ny = read_integer(scope, {"cells[1]", (*items)[1].place, (*items)[1]}, range);
  g.structured.nx = nx.value_or(0);
  g.structured.ny = ny.value_or(0);
}

void read_cell_size(Scope& scope, Node::Entry& entry, GridInput& g) {
  if (entry.value.array()) {
    if (const auto pair = read_pair(scope, entry, Unit::length, positive())) g.structured.cell_size = *pair;
  } else if (const auto edge = read_number(scope, entry, Unit::length, positive())) {
    g.structured.cell_size = Vec2(*edge, *edge);
  }
}

KeyInfo cells_info() {
  KeyInfo info = pair_info("cells", Unit::none, {1.0, 100000.0}, "number of cells along both sides");
  info.type = "[nx, ny]";
  info.json.set("items", integer_info("", {1.0, 100000.0}, "").json);
  return info;
}

KeyInfo cell_size_info() {
  KeyInfo info = pair_info("cell_size", Unit::length, positive(), "edge of a cell, or both edges; or give `size`");
  info.type = "number or [dx, dy] [m]";
  Node either;
  either.set("anyOf", Node(Node::Array{number_info("", Unit::length, positive(), "").json, info.json}));
  info.json = std::move(either);
  return info;
}

void check_grid(Scope& scope, GridInput& g) {
  if (scope.has("file")) return;
  scope.exactly_one({"cell_size", "size"});
  if (g.size) g.structured.cell_size = g.size->cwiseQuotient(Vec2(g.structured.nx, g.structured.ny));
}

const Table<GridInput>& grid_table() {
  static const Table<GridInput> table = [] {
    const std::vector<std::pair<std::string, GridKind>> kinds = {{"quads", GridKind::quads},
                                                                 {"triangles_right", GridKind::triangles_right},
                                                                 {"triangles_left", GridKind::triangles_left},
                                                                 {"union_jack", GridKind::union_jack}};
    Table<GridInput> t("Background grid (method \"mpm\"): regular, or a Gmsh mesh of linear cells.");
    t.file("file", &GridInput::file, "Gmsh mesh (.msh 2.2 or 4.1)");
    t.choice(
         "kind", [](GridInput & g) -> auto& { return g.structured.kind; }, kinds, "cells, or how each is halved")
        .only_without("file");
    t.pair(
         "origin", [](GridInput & g) -> auto& { return g.structured.origin; }, Unit::length,
         "lower left corner, before the rotation")
        .only_without("file");
    t.custom(cells_info(), read_cells).required().only_without("file");
    t.custom(cell_size_info(), read_cell_size).only_without("file");
    t.pair("size", &GridInput::size, Unit::length, "of the whole grid; or give `cell_size`", positive())
        .only_without("file");
    t.number(
         "angle", [](GridInput & g) -> auto& { return g.structured.angle; }, Unit::angle, {},
         "counter-clockwise rotation about the origin")
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
  t.string("title", &Case::title, "string", "one line for reports");
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
  t.named("contact", &Case::contacts, contact_table());
  t.table("control", &Case::control, control_table());
  t.table("steps", &Case::steps, steps_table());
  t.table("solver", &Case::solver, solver_table());
  t.table("output", &Case::output, output_table());
  t.named("gauge", outputs(&Output::gauges), gauge_table());
  t.named("probe", outputs(&Output::probes), probe_table());
  return t;
}

}  // namespace

const Table<Case>& case_table() {
  static const Table<Case> table = make_case_table();
  return table;
}

}  // namespace berm
