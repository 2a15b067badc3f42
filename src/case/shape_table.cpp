/// Shapes of bodies: boxes, discs, polygons, their unions and differences.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "case/tables.hpp"

namespace berm {
namespace {

struct ShapeInput {
  std::optional<Box> box;
  std::optional<Disc> disc;
  std::vector<Vec2> polygon;
  std::vector<PlaneShape> join, difference;
};

std::optional<PlaneShape> shape_of(Scope& scope);

Table<Box> box_table() {
  Table<Box> t("Rectangle along the axes.");
  t.pair("min", &Box::min, Unit::length, "lower left corner").required();
  t.pair("max", &Box::max, Unit::length, "upper right corner").required();
  t.check([](Scope& scope, Box& box) {
    if (!(box.min.array() < box.max.array()).all()) scope.error("max", "must lie above and to the right of \"min\"");
  });
  return t;
}

Table<Disc> disc_table() {
  Table<Disc> t("Full disc.");
  t.pair("centre", &Disc::centre, Unit::length, "centre").required();
  t.number("radius", &Disc::radius, Unit::length, positive(), "radius").required();
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

void read_polygon(Scope& scope, Node::Entry& entry, ShapeInput& input) {
  const auto points = read_points(scope, entry);
  if (!points) return;
  if (points->size() < 3) {
    scope.error("polygon", fmt::format("needs at least 3 vertices, has {}", points->size()));
  } else if (polygon_area(*points) == 0.0) {
    scope.error("polygon", "has no area");
  }
  input.polygon = *points;
}

void read_parts(const Scope& scope, Node::Entry& entry, std::vector<PlaneShape>& parts) {
  Node::Array* items = entry.value.array();
  if (!items || items->size() < 2) {
    scope.error(entry.key, "must be an array of at least two shapes");
    return;
  }
  for (std::size_t i = 0; i < items->size(); ++i) {
    Node::Entry item{fmt::format("{}[{}]", entry.key, i), (*items)[i].place, std::move((*items)[i])};
    auto child = scope.child(item);
    if (child) {
      if (auto part = shape_of(*child)) parts.push_back(std::move(*part));
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

KeyInfo polygon_info() {
  KeyInfo info = plain_info("polygon", "array of [x, y] [m]", "array",
                            "vertices of a simple polygon, either way round, at least 3");
  info.json.set("items", pair_info("", Unit::length, {}, "").json);
  return info;
}

const Table<ShapeInput>& shape_table() {
  static const Table<ShapeInput> table = [] {
    Table<ShapeInput> t("Exactly one of these forms.");
    t.table("box", &ShapeInput::box, box_table());
    t.table("disc", &ShapeInput::disc, disc_table());
    t.custom(polygon_info(), read_polygon);
    t.custom(parts_info("union", "all of these shapes together"),
             [](Scope& s, Node::Entry& e, ShapeInput& in) { read_parts(s, e, in.join); });
    t.custom(parts_info("difference", "the first of these shapes without the others"),
             [](Scope& s, Node::Entry& e, ShapeInput& in) { read_parts(s, e, in.difference); });
    t.check([](Scope& s, ShapeInput&) { s.exactly_one({"box", "disc", "polygon", "union", "difference"}); });
    return t;
  }();
  return table;
}

std::optional<PlaneShape> shape_of(Scope& scope) {
  const std::size_t errors_before = scope.problems.count();
  ShapeInput in;
  shape_table().read(scope, in);
  if (scope.problems.count() != errors_before) return std::nullopt;
  if (in.box) return PlaneShape{*in.box};
  if (in.disc) return PlaneShape{*in.disc};
  if (!in.polygon.empty()) return PlaneShape{Polygon{in.polygon}};
  if (!in.join.empty()) return PlaneShape{Combination{Combination::Kind::join, in.join}};
  return PlaneShape{Combination{Combination::Kind::difference, in.difference}};
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
  if (child) body.shape = shape_of(*child);
}

double largest_coordinate(const PlaneShape& shape) {
  const auto of = [](const auto& form) {
    using Form = std::decay_t<decltype(form)>;
    double largest = 0.0;
    if constexpr (std::is_same_v<Form, Box>) {
      largest = std::max(form.min.cwiseAbs().maxCoeff(), form.max.cwiseAbs().maxCoeff());
    } else if constexpr (std::is_same_v<Form, Disc>) {
      largest = form.centre.cwiseAbs().maxCoeff() + form.radius;
    } else if constexpr (std::is_same_v<Form, Polygon>) {
      for (const Vec2& vertex : form.vertices) largest = std::max(largest, vertex.cwiseAbs().maxCoeff());
    } else {
      for (const PlaneShape& part : form.parts) largest = std::max(largest, largest_coordinate(part));
    }
    return largest;
  };
  return std::visit(of, shape.form);
}

}  // namespace berm
