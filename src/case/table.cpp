#include "case/table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>

#include "case/units.hpp"

namespace berm {
namespace {

Node words(const std::vector<std::string>& items) {
  Node::Array array;
  for (const std::string& item : items) array.emplace_back(item);
  return Node(std::move(array));
}

Node typed(const std::string& json_type) {
  Node node;
  node.set("type", Node(json_type));
  return node;
}

void set_bounds(Node& json, const Range& range, Unit unit) {
  if (std::isfinite(range.min))
    json.set(range.min_open ? "exclusiveMinimum" : "minimum", Node(range.min / file_factor(unit)));
  if (std::isfinite(range.max))
    json.set(range.max_open ? "exclusiveMaximum" : "maximum", Node(range.max / file_factor(unit)));
}

Node number_schema(Unit unit, const Range& range) {
  Node number = typed("number");
  set_bounds(number, range, unit);
  if (unit == Unit::none) return number;
  Node text = typed("string");
  text.set("description", Node("number with a unit: " + unit_list(unit)));
  return either_schema(std::move(number), std::move(text));
}

/// A number, a number with a unit, or an expression.
Node function_schema(Unit unit, bool of_place) {
  Node text = typed("string");
  const char* variables = of_place ? "t, x, y and z" : "t";
  text.set("description",
           Node(fmt::format("number with a unit ({}), or an expression of {}", unit_list(unit), variables)));
  return either_schema(typed("number"), std::move(text));
}

std::string bracketed(Unit unit) { return unit == Unit::none ? "" : fmt::format(" [{}]", file_unit(unit)); }

KeyInfo make_info(const std::string& key, const std::string& type, Node json, const std::string& doc) {
  KeyInfo info;
  info.key = key;
  info.type = type;
  info.doc = doc;
  info.json = std::move(json);
  return info;
}

/// An array of two numbers, or of up to `most`.
KeyInfo array_info(const std::string& key, const std::string& form, int most, Unit unit, const Range& range,
                   const std::string& doc) {
  Node json = typed("array");
  json.set("items", number_schema(unit, range));
  json.set("minItems", Node(std::int64_t{2}));
  json.set("maxItems", Node(std::int64_t{most}));
  KeyInfo info = make_info(key, form + bracketed(unit), std::move(json), doc);
  info.range = range_text(range, unit);
  return info;
}

std::string quoted_list(const std::vector<std::string>& names) {
  return fmt::format("\"{}\"", fmt::join(names, "\", \""));
}

}  // namespace

KeyInfo number_info(const std::string& key, Unit unit, const Range& range, const std::string& doc) {
  KeyInfo info = make_info(key, "number" + bracketed(unit), number_schema(unit, range), doc);
  info.range = range_text(range, unit);
  return info;
}

KeyInfo integer_info(const std::string& key, const Range& range, const std::string& doc) {
  KeyInfo info = make_info(key, "whole number", typed("integer"), doc);
  set_bounds(info.json, range, Unit::none);
  info.range = range_text(range, Unit::none);
  return info;
}

KeyInfo pair_info(const std::string& key, Unit unit, const Range& range, const std::string& doc) {
  return array_info(key, "[x, y]", 2, unit, range, doc);
}

KeyInfo vector_info(const std::string& key, Unit unit, const Range& range, const std::string& doc) {
  return array_info(key, "[x, y(, z)]", 3, unit, range, doc);
}

KeyInfo function_info(const std::string& key, Unit unit, bool of_place, const std::string& doc) {
  const std::string type = of_place ? "number or expression of t, x, y, z" : "number or expression of t";
  return make_info(key, type + bracketed(unit), function_schema(unit, of_place), doc);
}

KeyInfo vector_function_info(const std::string& key, Unit unit, bool of_place, const std::string& doc) {
  KeyInfo info = array_info(key, "[x, y(, z)]", 3, unit, {}, doc);
  info.type = std::string("[x, y(, z)], numbers or expressions of t") + (of_place ? ", x, y, z" : "") + bracketed(unit);
  info.json.set("items", function_schema(unit, of_place));
  return info;
}

KeyInfo choice_info(const std::string& key, const std::vector<std::string>& names, const std::string& doc) {
  Node json;
  json.set("enum", words(names));
  return make_info(key, quoted_list(names), std::move(json), doc);
}

KeyInfo choice_info(const std::string& key, const std::vector<std::string>& plane,
                    const std::vector<std::string>& solid, const std::string& doc) {
  const auto in_plane = [&](const std::string& name) {
    return std::find(plane.begin(), plane.end(), name) != plane.end();
  };
  std::vector<std::string> all = plane, more;
  std::copy_if(solid.begin(), solid.end(), std::back_inserter(more), std::not_fn(in_plane));
  all.insert(all.end(), more.begin(), more.end());
  KeyInfo info = choice_info(key, all, doc);
  info.type = fmt::format("{}; in space {}{}", quoted_list(plane), more.size() < solid.size() ? "also " : "",
                          quoted_list(more));
  return info;
}

KeyInfo plain_info(const std::string& key, const std::string& type, const std::string& json_type,
                   const std::string& doc) {
  return make_info(key, type, typed(json_type), doc);
}

KeyInfo table_info(const std::string& key, const std::string& doc, std::vector<KeyInfo> children, bool named) {
  Node json = object_schema(children);
  if (named) {
    Node outer = typed("object");
    Node names;
    names.set("pattern", Node(std::string("^[A-Za-z0-9_-]+$")));
    outer.set("propertyNames", std::move(names));
    outer.set("additionalProperties", std::move(json));
    json = std::move(outer);
  }
  KeyInfo info = make_info(key, "table", std::move(json), doc);
  info.children = std::move(children);
  info.named = named;
  return info;
}

Node either_schema(Node one, Node other) {
  Node either;
  either.set("anyOf", Node(Node::Array{std::move(one), std::move(other)}));
  return either;
}

Node array_schema(Node items) {
  Node json = typed("array");
  json.set("items", std::move(items));
  return json;
}

Node object_schema(const std::vector<KeyInfo>& keys) {
  Node properties;
  for (const KeyInfo& info : keys) {
    Node json = info.json;
    json.set("description", Node(info.condition.empty() ? info.doc : info.doc + " (only " + info.condition + ")"));
    if (Node::Entry* twin = properties.find(info.key))  // the same key of two laws
      json = either_schema(std::move(twin->value), std::move(json));
    properties.set(info.key, std::move(json));
  }
  Node json = typed("object");
  json.set("additionalProperties", Node(false));
  json.set("properties", std::move(properties));
  return json;
}

std::optional<Node> number_node(double value, Unit unit) { return Node(value / file_factor(unit)); }

std::optional<Node> number_node(const std::optional<double>& value, Unit unit) {
  return value ? number_node(*value, unit) : std::nullopt;
}

std::optional<Node> vector_node(const Vec2& value, Unit unit, int) {
  return pair_node(value.x() / file_factor(unit), value.y() / file_factor(unit));
}

std::optional<Node> vector_node(const Vec3& value, Unit unit, int dimension) {
  Node::Array items;
  for (int i = 0; i < dimension; ++i) items.emplace_back(value[i] / file_factor(unit));
  return Node(std::move(items));
}

std::optional<Node> vector_node(const std::optional<Vec3>& value, Unit unit, int dimension) {
  return value ? vector_node(*value, unit, dimension) : std::nullopt;
}

std::optional<Node> function_node(const TimeFunction& value, Unit unit) {
  return value.is_number() ? number_node(value.number(), unit) : Node(value.text());
}

std::optional<Node> function_node(const std::optional<TimeFunction>& value, Unit unit) {
  return value ? function_node(*value, unit) : std::nullopt;
}

std::optional<Node> function_node(const VectorFunction& value, Unit unit, int dimension) {
  Node::Array items;
  for (int i = 0; i < dimension; ++i) items.push_back(*function_node(value.component[i], unit));
  return Node(std::move(items));
}

std::optional<Node> function_node(const std::optional<VectorFunction>& value, Unit unit, int dimension) {
  return value ? function_node(*value, unit, dimension) : std::nullopt;
}

std::string default_text(const std::optional<Node>& plane, const std::optional<Node>& solid) {
  const auto text_of = [](const std::optional<Node>& node) -> std::string {
    if (!node) return "";
    Node wrapped;
    wrapped.set("x", *node);
    const std::string text = write_toml(wrapped);  // "x = ...\n"
    return "`" + text.substr(4, text.size() - 5) + "`";
  };
  const std::string in_plane = text_of(plane), in_space = text_of(solid);
  return in_plane == in_space ? in_plane : fmt::format("{}; in space {}", in_plane, in_space);
}

void report_unknown(const Scope& scope, const std::vector<std::string>& valid) {
  for (const Node::Entry& entry : scope.node.object()) {
    if (std::find(valid.begin(), valid.end(), entry.key) != valid.end()) continue;
    scope.problems.error(entry.place,
                         fmt::format("unknown key \"{}\"{}{}", entry.key, scope.where(), suggestion(entry.key, valid)));
  }
}

void make_unit(const Scope& scope, std::string_view key, Vec3& direction) {
  if (direction.isZero(0.0)) return scope.error(key, "must not be zero");
  direction.stableNormalize();
}

void report_bad_name(const Scope& scope, const Node::Entry& entry) {
  constexpr std::string_view allowed = "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-";
  constexpr std::size_t longest = 100;  // with what else the name of a file has
  if (!entry.key.empty() && entry.key.size() <= longest && entry.key[0] != '_' && entry.key.find_first_not_of(allowed) == std::string::npos) return;
  scope.problems.error(entry.place, fmt::format("name \"{}\"{} must be made of letters, digits, _ and -, begin with no _ and have at most {} of them", entry.key,
                                                scope.where(), longest));
}

}  // namespace berm
