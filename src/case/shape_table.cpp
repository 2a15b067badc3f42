/// Shapes of bodies: plane and solid primitives, their unions and differences, surfaces from files.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"
#include "case/tables.hpp"
#include "mesh/closed_spline.hpp"

namespace berm {
namespace {

struct BoxInput {
  Vec3 min = Vec3::Zero(), max = Vec3::Zero();
};

struct ShapeInput {
  bool is_part = false;  ///< of a union or difference
  std::optional<BoxInput> box;
  std::optional<Disc> disc;
  std::vector<Vec2> polygon, spline;
  std::optional<Cylinder> cylinder;
  std::optional<Sphere> sphere;
  std::optional<Extrusion> extrusion;
  std::string surface;
  std::vector<Shape> join, difference;
};

std::optional<Shape> shape_of(Scope& scope, bool is_part);

Table<BoxInput> box_table() {
  Table<BoxInput> t("Rectangle along the axes; in space a box.");
  t.vector("min", &BoxInput::min, Unit::length, "lower left corner; in space the lowest one").required();
  t.vector("max", &BoxInput::max, Unit::length, "upper right corner; in space the highest one").required();
  t.check([](Scope& scope, BoxInput& box) {
    const int n = scope.dimension();
    if ((box.min.head(n).array() < box.max.head(n).array()).all()) return;
    scope.error("max", n == 2 ? "must lie above and to the right of \"min\""
                              : "must be larger than \"min\" in every direction");
  });
  return t;
}

Table<Disc> disc_table() {
  Table<Disc> t("Full disc.");
  t.pair("centre", &Disc::centre, Unit::length, "centre").required();
  t.number("radius", &Disc::radius, Unit::length, positive(), "radius").required();
  return t;
}

Table<Cylinder> cylinder_table() {
  Table<Cylinder> t("Full straight cylinder about any axis.");
  t.vector("from", &Cylinder::from, Unit::length, "centre of one flat face").required();
  t.vector("to", &Cylinder::to, Unit::length, "centre of the other").required();
  t.number("radius", &Cylinder::radius, Unit::length, positive(), "radius").required();
  t.check([](Scope& scope, Cylinder& c) {
    if (c.from == c.to) scope.error("to", "must differ from \"from\": the cylinder has no length");
  });
  return t;
}

Table<Sphere> sphere_table() {
  Table<Sphere> t("Full sphere.");
  t.vector("centre", &Sphere::centre, Unit::length, "centre").required();
  t.number("radius", &Sphere::radius, Unit::length, positive(), "radius").required();
  return t;
}

double polygon_area(const std::vector<Vec2>& vertices) {
  double twice = 0.0;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const Vec2 a = vertices[i] - vertices[0], b = vertices[(i + 1) % vertices.size()] - vertices[0];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return std::abs(twice) / 2;
}

void read_polygon(const Scope& scope, const Node::Entry& entry, std::vector<Vec2>& vertices) {
  const auto points = read_points(scope, entry);
  if (!points) return;
  if (points->size() < 3) {
    scope.error(entry.key, fmt::format("needs at least 3 vertices, has {}", points->size()));
  } else if (polygon_area(*points) == 0.0) {
    scope.error(entry.key, "has no area");
  }
  vertices = *points;
}

void read_spline(const Scope& scope, const Node::Entry& entry, std::vector<Vec2>& points) {
  read_polygon(scope, entry, points);
  if (points.size() < 3) return;
  double length = 0.0;
  for (std::size_t i = 1; i < points.size(); ++i) length += (points[i] - points[i - 1]).stableNorm();
  for (std::size_t i = 0; i < points.size(); ++i)
    if ((points[(i + 1) % points.size()] - points[i]).stableNorm() <= 1e-9 * length)
      return scope.error(entry.key, i + 1 < points.size() ? fmt::format("names point {} twice in a row", i + 1)
                                                          : "closes by itself: leave out the last point");
  try {
    points = closed_spline(points);
  } catch (const InputError& error) {
    scope.explain(entry.key, error.what());
  }
}

KeyInfo points_info(const std::string& key, const std::string& doc) {
  KeyInfo info = plain_info(key, "array of [x, y] [m]", "array", doc);
  info.json.set("items", pair_info("", Unit::length, {}, "").json);
  return info;
}

KeyInfo polygon_info() {
  return points_info("polygon", "vertices of a simple polygon, either way round, at least 3");
}

Table<Extrusion> extrusion_table() {
  Table<Extrusion> t("A polygon of the x-y plane drawn along z.");
  t.custom(polygon_info(), [](Scope& s, Node::Entry& e, Extrusion& x) { read_polygon(s, e, x.vertices); }).required();
  t.number("from", &Extrusion::from, Unit::length, {}, "z of the lower flat face").required();
  t.number("to", &Extrusion::to, Unit::length, {}, "z of the upper flat face").required();
  t.check([](Scope& scope, Extrusion& x) {
    if (x.to <= x.from) scope.error("to", "must be larger than \"from\"");
  });
  return t;
}

void read_surface(const Scope& scope, Node::Entry& entry, ShapeInput& input) {
  if (input.is_part) {
    scope.error("surface",
                "cannot be a part of a union or difference: an STL surface stands alone (combine the parts "
                "in the program that made it)");
  } else if (const auto path = read_file(scope, entry, true)) {
    input.surface = *path;
  }
}

void read_parts(const Scope& scope, Node::Entry& entry, std::vector<Shape>& parts) {
  Node::Array* items = entry.value.array();
  if (!items || items->size() < 2) {
    scope.error(entry.key, "must be an array of at least two shapes");
    return;
  }
  for (std::size_t i = 0; i < items->size(); ++i) {
    Node::Entry item{fmt::format("{}[{}]", entry.key, i), (*items)[i].place, std::move((*items)[i])};
    auto child = scope.child(item);
    if (child) {
      if (auto part = shape_of(*child, true)) parts.push_back(std::move(*part));
    }
    (*items)[i] = std::move(item.value);
  }
}

KeyInfo parts_info(const std::string& key, const std::string& doc) {
  KeyInfo info = plain_info(key, "array of shapes", "array", doc);
  Node reference;
  reference.set("$ref", Node(std::string("#/$defs/shape")));
  info.json.set("items", std::move(reference));
  return info;
}

void check_forms(const Scope& scope) {
  if (scope.dimension() == 2) return scope.exactly_one({"box", "disc", "polygon", "spline", "union", "difference"});
  scope.exactly_one({"box", "cylinder", "sphere", "extrusion", "surface", "union", "difference"});
}

const Table<ShapeInput>& shape_table() {
  static const Table<ShapeInput> table = [] {
    Table<ShapeInput> t("Exactly one of these forms.");
    t.table("box", &ShapeInput::box, box_table());
    t.table("disc", &ShapeInput::disc, disc_table());
    t.only_in_plane("; in space take \"cylinder\" or \"sphere\"");
    t.custom(polygon_info(), [](Scope& s, Node::Entry& e, ShapeInput& in) { read_polygon(s, e, in.polygon); });
    t.only_in_plane("; in space take \"extrusion\"");
    t.custom(points_info("spline", "at least 3 points on a smooth closed outline: a cubic B-spline goes through them, cut into 32 chords from one to "
                         "the next (a mesh has at least one edge a chord)"),
             [](Scope& s, Node::Entry& e, ShapeInput& in) { read_spline(s, e, in.spline); });
    t.only_in_plane("; in space take a mesh with \"file\"");
    t.table("cylinder", &ShapeInput::cylinder, cylinder_table());
    t.only_in_space("; in the plane take \"disc\" or \"box\"");
    t.table("sphere", &ShapeInput::sphere, sphere_table()).only_in_space("; in the plane take \"disc\"");
    t.table("extrusion", &ShapeInput::extrusion, extrusion_table());
    t.only_in_space("; in the plane take \"polygon\"");
    t.custom(plain_info("surface", "file", "string", "closed surface of triangles (STL), alone, not a part of others"),
             read_surface);
    t.only_in_space("; in the plane take \"polygon\", or a mesh with \"file\"");
    t.custom(parts_info("union", "all of these shapes together"),
             [](Scope& s, Node::Entry& e, ShapeInput& in) { read_parts(s, e, in.join); });
    t.custom(parts_info("difference", "the first of these shapes without the others"),
             [](Scope& s, Node::Entry& e, ShapeInput& in) { read_parts(s, e, in.difference); });
    t.check([](Scope& s, ShapeInput&) { check_forms(s); });
    return t;
  }();
  return table;
}

/// The parts, all of them plane or all of them solid.
template <class S>
std::vector<S> parts_as(const std::vector<Shape>& parts) {
  std::vector<S> same;
  for (const Shape& part : parts) same.push_back(std::get<S>(part));
  return same;
}

PlaneShape plane_shape(const ShapeInput& in) {
  if (in.box) return {Box{in_plane(in.box->min), in_plane(in.box->max)}};
  if (in.disc) return {*in.disc};
  if (!in.polygon.empty()) return {Polygon{in.polygon}};
  if (!in.spline.empty()) return {Polygon{in.spline}};
  if (!in.join.empty()) return {Combination{Combination::Kind::join, parts_as<PlaneShape>(in.join)}};
  return {Combination{Combination::Kind::difference, parts_as<PlaneShape>(in.difference)}};
}

SolidShape solid_shape(const ShapeInput& in) {
  using Kind = SolidCombination::Kind;
  if (in.box) return {SolidBox{in.box->min, in.box->max}};
  if (in.cylinder) return {*in.cylinder};
  if (in.sphere) return {*in.sphere};
  if (in.extrusion) return {*in.extrusion};
  if (!in.surface.empty()) return {SurfaceFile{in.surface}};
  if (!in.join.empty()) return {SolidCombination{Kind::join, parts_as<SolidShape>(in.join)}};
  return {SolidCombination{Kind::difference, parts_as<SolidShape>(in.difference)}};
}

std::optional<Shape> shape_of(Scope& scope, bool is_part) {
  const std::size_t errors_before = scope.problems.count();
  ShapeInput in;
  in.is_part = is_part;
  shape_table().read(scope, in);
  if (scope.problems.count() != errors_before) return std::nullopt;
  if (scope.dimension() == 2) return plane_shape(in);
  return solid_shape(in);
}

}  // namespace

Node shape_schema() { return object_schema(shape_table().keys()); }

KeyInfo shape_info() {
  KeyInfo info = table_info("shape", shape_table().doc(), shape_table().keys(), false);
  Node reference;
  reference.set("$ref", Node(std::string("#/$defs/shape")));
  info.json = std::move(reference);
  return info;
}

void read_shape(Scope& scope, Node::Entry& entry, Body& body) {
  auto child = scope.child(entry);
  if (child) body.shape = shape_of(*child, false);
}

}  // namespace berm
