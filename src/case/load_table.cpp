/// Supports and loads: boundaries, pins, pressures, contacts.

#include <array>
#include <numbers>

#include "case/tables.hpp"

namespace berm {
namespace {

Table<Where> where_box_table() {
  Table<Where> t("Everything inside this rectangle (in space: box); a missing corner does not limit.");
  t.vector("min", &Where::min, Unit::length, "lower left corner; in space the lowest one");
  t.vector("max", &Where::max, Unit::length, "upper right corner; in space the highest one");
  t.check([](Scope& s, Where& w) {
    s.at_least_one({"min", "max"});
    if (!w.min || !w.max || (w.min->array() <= w.max->array()).all()) return;
    s.error("max", s.dimension() == 2 ? "must lie above and to the right of \"min\""
                                      : "must not be smaller than \"min\" in any direction");
  });
  return t;
}

Table<Where::Sector> sector_table() {
  using Sector = Where::Sector;
  Table<Sector> t("Everything between two directions seen from a centre; in space seen against the z axis, at any z.");
  t.pair("centre", &Sector::centre, Unit::length, "from where the angles are seen").required();
  t.number("from", &Sector::from, Unit::angle, {}, "first direction, counter-clockwise from the x axis").required();
  t.number("to", &Sector::to, Unit::angle, {}, "last direction, larger than `from`, by 360 degrees at most").required();
  t.check([](Scope& s, Sector& sector) {
    const double span = sector.to - sector.from;
    if (span <= 0.0 || span > 2.0 * std::numbers::pi * (1.0 + 1e-12)) {
      s.error("to", "must be larger than \"from\", by 360 deg at most (add 360 to pass the x axis)");
    }
  });
  return t;
}

Table<Where> where_table() {
  Table<Where> t("Where it acts: inside all of these that are given.");
  t.table(
       "box", [](Where& w) -> Where& { return w; }, where_box_table())
      .no_default();
  t.string("group", &Where::group, "name of a physical curve (in space: surface)",
           "nodes of that curve of the Gmsh file of the grid or body");
  t.table("sector", &Where::sector, sector_table());
  t.check([](Scope& s, Where&) { s.at_least_one({"box", "group", "sector"}); });
  return t;
}

using Fixed = std::array<bool, 3>;
const WordsByDimension<Fixed> held_directions = {{{"x", {true, false, false}},  //
                                                  {"y", {false, true, false}},
                                                  {"xy", {true, true, false}}},
                                                 {{"x", {true, false, false}},
                                                  {"y", {false, true, false}},
                                                  {"xy", {true, true, false}},
                                                  {"z", {false, false, true}},
                                                  {"xz", {true, false, true}},
                                                  {"yz", {false, true, true}},
                                                  {"xyz", {true, true, true}}}};

/// The displacement along an axis.
auto component(std::size_t i) {
  return [i](NodeBoundary & b) -> auto& { return b.u[i]; };
}

}  // namespace

Table<NodeBoundary> boundary_table() {
  Table<NodeBoundary> t(
      "Prescribed displacement of grid nodes (mpm) or mesh nodes (fem). At least one of `ux`, `uy` and `uz`.");
  t.table("where", &NodeBoundary::where, where_table()).required();
  t.function("ux", component(0), Unit::length, false,
             "displacement along x; a number is reached linearly at the end of the run; free without it");
  t.function("uy", component(1), Unit::length, false,
             "displacement along y; a number is reached linearly at the end of the run; free without it");
  t.function("uz", component(2), Unit::length, false,
             "displacement along z; a number is reached linearly at the end of the run; free without it");
  t.only_in_space();
  t.check([](Scope& s, NodeBoundary&) {
    if (s.dimension() == 2) return s.at_least_one({"ux", "uy"});
    s.at_least_one({"ux", "uy", "uz"});
  });
  return t;
}

Table<Pin> pin_table() {
  Table<Pin> t("Holds a material point inside a body, to stop rigid motion where no boundary does.");
  t.string("body", &Pin::body, "name of a deformable body", "whose point").required();
  t.vector("at", &Pin::at, Unit::length, "reference position").required();
  t.choice("fix", &Pin::fixed, held_directions, "held directions").required();
  return t;
}

Table<Pressure> pressure_table() {
  Table<Pressure> t(
      "Pressure or traction on the surface of a body: one of `value` and `traction`. The loaded points move with the "
      "material; direction and area are those of the reference state.");
  t.string("body", &Pressure::body, "name of a deformable body", "on which body").required();
  t.table("where", &Pressure::where, where_table()).required();
  t.function("value", &Pressure::value, Unit::stress, true,
             "positive pushes into the body; a number is reached linearly at the end of the run")
      .no_default();
  t.vector_function("traction", &Pressure::traction, Unit::stress,
                    "force per area along the axes, e.g. shear; a number is reached linearly at the end of the run",
                    true);
  t.check([](Scope& s, Pressure&) { s.exactly_one({"value", "traction"}); });
  return t;
}

Table<Contact> contact_table() {
  using Kind = Contact::Kind;
  Table<Contact> t("A deformable body's surface against a rigid body.");
  t.string("body", &Contact::body, "name of a deformable body", "the body").required();
  t.string("rigid", &Contact::rigid, "name of a rigid body", "what it touches").required();
  t.choice("kind", &Contact::kind,
           std::vector<std::pair<std::string, Kind>>{{"tie", Kind::tie},
                                                     {"no_slip", Kind::no_slip},
                                                     {"frictionless", Kind::frictionless},
                                                     {"shared_nodes", Kind::shared_nodes}},
           "tie: surfaces that touch at the start move together; no_slip: can open, no sliding; frictionless: can open "
           "and slide; shared_nodes (mpm): the grid nodes around the rigid body's points move with it");
  t.number("stiffness", &Contact::stiffness, Unit::none, positive(),
           "penalty in units of Young's modulus over cell size");
  return t;
}

}  // namespace berm
