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

Table<Where::HalfSpace> half_space_table() {
  using HalfSpace = Where::HalfSpace;
  Table<HalfSpace> t("Everything on one side of an inclined line (in space: plane).");
  t.vector("at", &HalfSpace::at, Unit::length, "a place on it; to catch what lies on it, a little before it")
      .required();
  t.vector("normal", &HalfSpace::normal, Unit::none, "points to the side that is meant").required();
  t.check([](Scope& s, HalfSpace& h) {
    if (h.normal.isZero(0.0)) s.error("normal", "must not be zero");
  });
  return t;
}

Table<Where> where_table() {
  Table<Where> t("Where it acts: inside all of these that are given.");
  t.table(
       "box", [](Where& w) -> Where& { return w; }, where_box_table())
      .no_default();
  t.name("group", &Where::group, "name of a physical curve (in space: surface)",
           "nodes of that curve of the Gmsh file of the grid or body");
  t.table("sector", &Where::sector, sector_table());
  t.table("beyond", &Where::beyond, half_space_table());
  t.check([](Scope& s, Where&) { s.at_least_one({"box", "group", "sector", "beyond"}); });
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

template <class T>
void add_stages(Table<T>& t) {
  t.names("stages", &T::stages, "array of names of stages", "in which it acts; in all without it");
}

/// The displacement along an axis.
auto component(std::size_t i) {
  return [i](NodeBoundary & b) -> auto& { return b.u[i]; };
}

}  // namespace

Table<NodeBoundary> boundary_table() {
  Table<NodeBoundary> t(
      "Prescribed displacement of grid nodes (mpm) or mesh nodes (fem), or with `body` of that body's surface, which it "
      "follows, and which need not fit the grid. At least one of `ux`, `uy` and `uz`, or a `normal` (surface: or `un`).");
  t.name("body", &NodeBoundary::body, "name of a deformable body", "whose surface is held, wherever it moves; without it, "
           "nodes");
  t.table("where", &NodeBoundary::where, where_table()).required();
  t.function("ux", component(0), Unit::length, true,
             "displacement along x; a number is reached linearly at the end of the first stage; in expressions x, y, z are the "
             "place of the node at the start; free without it");
  t.only([](const Scope& s, const NodeBoundary&) { return !s.has("normal"); }, "without \"normal\"");
  t.function("uy", component(1), Unit::length, true,
             "displacement along y; a number is reached linearly at the end of the first stage; in expressions x, y, z are the "
             "place of the node at the start; free without it");
  t.only([](const Scope& s, const NodeBoundary&) { return !s.has("normal"); }, "without \"normal\"");
  t.function("uz", component(2), Unit::length, true,
             "displacement along z; a number is reached linearly at the end of the first stage; in expressions x, y, z are the "
             "place of the node at the start; free without it");
  t.only_in_space();
  t.vector("normal", &NodeBoundary::normal, Unit::none,
           "for nodes on an inclined line or plane: they move along it freely and by `un` in this direction");
  t.function("un", &NodeBoundary::un, Unit::length, false,
             "displacement along the normal; a number is reached linearly at the end of the first stage");
  t.only([](const Scope& s, const NodeBoundary&) { return s.has("normal") || (s.has("body") && !s.has("ux") && !s.has("uy") && !s.has("uz")); },
         "with \"normal\", or on the surface of a \"body\", along whose own normal it then is");
  t.check([](Scope& s, NodeBoundary& b) {
    if (s.has("body"))
      s.at_least_one({"ux", "uy", "uz", "normal", "un"});
    else if (s.dimension() == 2)
      s.at_least_one({"ux", "uy", "normal"});
    else
      s.at_least_one({"ux", "uy", "uz", "normal"});
    if (b.normal && b.u[2]) s.error("uz", "is only allowed without \"normal\"");
    if (b.normal) make_unit(s, "normal", *b.normal);
  });
  add_stages(t);
  return t;
}

Table<Pin> pin_table() {
  Table<Pin> t("Holds a material point inside a body, to stop rigid motion where no boundary does.");
  t.name("body", &Pin::body, "name of a deformable body", "whose point").required();
  t.vector("at", &Pin::at, Unit::length, "reference position").required();
  t.choice("fix", &Pin::fixed, held_directions, "held directions").required();
  add_stages(t);
  return t;
}

Table<Pressure> pressure_table() {
  Table<Pressure> t(
      "Pressure or traction on the surface of a body: one of `value` and `traction`. The loaded points move with the "
      "material.");
  t.name("body", &Pressure::body, "name of a deformable body", "on which body").required();
  t.table("where", &Pressure::where, where_table()).required();
  t.function("value", &Pressure::value, Unit::stress, true,
             "positive pushes into the body; a number is reached linearly at the end of the first stage, or holds from "
             "the start if that is dynamic")
      .no_default();
  t.vector_function("traction", &Pressure::traction, Unit::stress,
                    "force per area of the reference state along the axes, e.g. shear; a number is reached as in `value`",
                    true);
  using Direction = Pressure::Direction;
  t.choice("direction", &Pressure::direction,
           Words<Direction>{{"following", Direction::following}, {"dead", Direction::dead}},
           "following: stays normal to the deforming face and acts on its present area (finite kinematics; in small "
           "strain there is no difference); dead: direction and area of the reference state");
  t.only_with("value");
  add_stages(t);
  t.check([](Scope& s, Pressure&) { s.exactly_one({"value", "traction"}); });
  return t;
}

Table<Absorbing> absorbing_table() {
  Table<Absorbing> t(
      "Dashpots on the surface of a body that let waves out into the ground beyond (Lysmer and Kuhlemeyer 1969); they act in "
      "dynamic stages.");
  t.name("body", &Absorbing::body, "name of a deformable body", "on which body").required();
  t.table("where", &Absorbing::where, where_table()).required();
  t.number("p_wave_speed", &Absorbing::p_wave_speed, Unit::velocity, positive(),
           "of the ground beyond, sqrt(E (1 - nu) / ((1 + nu) (1 - 2 nu) density)) if elastic")
      .required();
  t.number("s_wave_speed", &Absorbing::s_wave_speed, Unit::velocity, non_negative(),
           "of the ground beyond, sqrt(E / (2 (1 + nu) density)) if elastic")
      .required();
  t.number("density", &Absorbing::density, Unit::density, positive(), "of the ground beyond").required();
  add_stages(t);
  return t;
}

Table<Contact> contact_table() {
  using Kind = Contact::Kind;
  Table<Contact> t(
      "A deformable body's surface against a rigid body, or against another deformable one: tied to it, or (mpm) able to "
      "part from it. One of `rigid` and `other`. Deformable bodies that touch at the start and have no contact stay together.");
  t.name("body", &Contact::body, "name of a deformable body", "the body").required();
  t.name("rigid", &Contact::rigid, "name of a rigid body", "what it touches");
  t.name("other", &Contact::other, "name of a deformable body", "what it touches, with kind tie, friction or frictionless");
  t.choice("kind", &Contact::kind,
           std::vector<std::pair<std::string, Kind>>{{"tie", Kind::tie},
                                                     {"no_slip", Kind::no_slip},
                                                     {"frictionless", Kind::frictionless},
                                                     {"friction", Kind::friction},
                                                     {"shared_nodes", Kind::shared_nodes}},
           "tie: surfaces that touch at the start move together; no_slip: can open, no sliding; frictionless: can open "
           "and slide; friction: can open, slides where the shear reaches `friction` times the pressure; shared_nodes "
           "(mpm): "
           "the grid nodes around the rigid body's points move with it");
  t.number("friction", &Contact::friction, Unit::none, positive(),
           "Coulomb's coefficient of friction, the tangent of the friction angle")
      .required();
  t.only([](const Scope&, const Contact& c) { return c.kind == Kind::friction; }, "with kind = \"friction\"");
  t.number("stiffness", &Contact::stiffness, Unit::none, positive(),
           "penalty in units of Young's modulus over cell size (default: tie 1000, what can open 100: what gives way is a "
           "hundredth of what a cell does; between deformable bodies that of the softer one, 500 for a tie, else 10, and 1 in runs "
           "with dynamic stages: the force is carried from step to step, so that it need not be stiff)")
      .no_default();
  add_stages(t);
  t.check([](Scope& s, Contact& c) {
    s.exactly_one({"rigid", "other"});
    const bool tied = c.kind == Kind::tie;
    if (!s.has("stiffness") && (tied || c.other.empty())) {  // else: choose_defaults
      c.stiffness = !tied ? 100.0 : c.other.empty() ? 1000.0 : 500.0;
      s.node.set("stiffness", Node(c.stiffness, s.place));
    }
    if (!c.other.empty() && (c.kind == Kind::no_slip || c.kind == Kind::shared_nodes))
      s.error("kind", "must be \"tie\", \"friction\" or \"frictionless\" between two deformable bodies");
    if (c.other == c.body) s.error("other", "must not be the body itself");
  });
  return t;
}

}  // namespace berm
