#include "case/scope.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "case/units.hpp"

namespace berm {
namespace {

std::string an_entry(const Scope& scope, std::string_view key) { return fmt::format("\"{}\"{}", key, scope.where()); }

/// An item of an array dressed as an entry, so that the readers of single values serve for arrays too.
Node::Entry item_entry(const Node::Entry& array, std::size_t i, const Node& item) {
  return {fmt::format("{}[{}]", array.key, i), item.place, item};
}

void wrong_type(const Scope& scope, const Node::Entry& entry, std::string_view wanted) {
  scope.problems.error(entry.value.place, fmt::format("{} must be {}, not {}", an_entry(scope, entry.key), wanted,
                                                      entry.value.type_name()));
}

/// Calls read(item, index) for each of an array with one number a direction; true if there are as many and all could be
/// read.
template <class Read>
bool read_items(const Scope& scope, const Node::Entry& entry, Read read) {
  const Node::Array* items = read_directions(scope, entry, "numbers", "");
  if (!items) return false;
  bool complete = true;
  for (std::size_t i = 0; i < items->size(); ++i) complete = read(item_entry(entry, i, (*items)[i]), i) && complete;
  return complete;
}

/// A number and at most the name of a unit: "9.81 m/s2". Everything else is an expression: "9.81*t", "2/t".
bool looks_like_quantity(const std::string& text) {
  char* rest = nullptr;
  std::strtod(text.c_str(), &rest);
  if (rest == text.c_str()) return false;
  while (*rest == ' ') ++rest;
  return *rest == '\0' || std::isalpha(static_cast<unsigned char>(*rest));
}

}  // namespace

int Scope::dimension() const {
  if (outer) return outer->dimension();
  const Node::Entry* model = node.find("model");
  const Node::Entry* entry = model ? model->value.find("dimension") : nullptr;
  const std::int64_t* number = entry ? std::get_if<std::int64_t>(&entry->value.value) : nullptr;
  return number && *number == 3 ? 3 : 2;
}

std::string Scope::where() const { return path.empty() ? " at the top level" : fmt::format(" in [{}]", path); }

Place Scope::place_of(std::string_view key) const {
  const Node::Entry* entry = node.find(key);
  return entry ? entry->value.place : place;
}

std::string Scope::path_of(std::string_view key) const {
  return path.empty() ? std::string(key) : fmt::format("{}.{}", path, key);
}

void Scope::error(std::string_view key, const std::string& text) const {
  problems.error(place_of(key), fmt::format("{} {}", an_entry(*this, key), text));
}

void Scope::explain(std::string_view key, const std::string& text) const {
  problems.error(place_of(key), fmt::format("{}: {}", an_entry(*this, key), text));
}

void Scope::warn(std::string_view key, const std::string& text) const { problems.warn(place_of(key), text); }

void Scope::missing(std::string_view key, const std::string& what) const {
  problems.error(place, fmt::format("missing key {} ({})", an_entry(*this, key), what));
}

std::optional<Scope> Scope::child(Node::Entry& entry) const {
  if (!entry.value.is_object()) {
    wrong_type(*this, entry, "a table");
    return std::nullopt;
  }
  return Scope{problems, entry.value, path_of(entry.key), entry.value.place, this};
}

void Scope::exactly_one(const std::vector<std::string>& keys) const {
  at_least_one(keys);
  const Node::Entry* first = nullptr;
  for (const std::string& key : keys) {
    const Node::Entry* entry = node.find(key);
    if (!entry) continue;
    if (!first) {
      first = entry;
      continue;
    }
    std::string remedy;
    if (const Node::Entry* given = !entry->value.place.override.empty() ? entry : !first->value.place.override.empty() ? first : nullptr) {
      remedy = fmt::format(" (an override changes keys and takes none away: leave \"{}\" out of the case, or override that)", given == entry ? first->key : entry->key);
    } else if (first->value.place.file != entry->value.place.file) {
      const Node::Entry* inherited = first->value.place.file == place.file ? entry : first;
      remedy = fmt::format(" (\"{}\" comes from {}; drop it with remove = [\"{}\"])", inherited->key,
                           inherited->value.place.text(), path_of(inherited->key));
    }
    error(key, fmt::format("cannot stand beside \"{}\"{}", first->key, remedy));
  }
}

void Scope::at_least_one(const std::vector<std::string>& keys) const {
  for (const std::string& key : keys) {
    if (has(key)) return;
  }
  problems.error(place, fmt::format("missing{}: one of {}", where(), fmt::join(keys, ", ")));
}

std::optional<double> read_number(const Scope& scope, const Node::Entry& entry, Unit unit, const Range& range) {
  const Node::Value& value = entry.value.value;
  double number = 0.0;
  if (const double* d = std::get_if<double>(&value)) {
    number = *d * file_factor(unit);
  } else if (const std::int64_t* i = std::get_if<std::int64_t>(&value)) {
    number = static_cast<double>(*i) * file_factor(unit);
  } else if (entry.value.string() && unit != Unit::none) {
    const Parsed parsed = parse_quantity(*entry.value.string(), unit);
    if (!parsed.error.empty()) {
      scope.problems.error(entry.value.place, fmt::format("{}: {}", an_entry(scope, entry.key), parsed.error));
      return std::nullopt;
    }
    number = parsed.value;
  } else {
    wrong_type(scope, entry, unit == Unit::none ? "a number" : "a number or a string with a unit");
    return std::nullopt;
  }
  if (!std::isfinite(number) || !in_range(range, number)) {
    const std::string bounds = std::isfinite(number) ? range_text(range, unit) : "finite";
    const std::string unit_text = unit == Unit::none ? "" : fmt::format(" {}", file_unit(unit));
    scope.problems.error(entry.value.place, fmt::format("{} must be {}, is {:.6g}{}", an_entry(scope, entry.key),
                                                        bounds, number / file_factor(unit), unit_text));
    return std::nullopt;
  }
  return number;
}

std::optional<TimeFunction> read_function(const Scope& scope, const Node::Entry& entry, Unit unit, bool of_place) {
  const std::string* text = entry.value.string();
  if (!text || looks_like_quantity(*text)) {
    const auto number = read_number(scope, entry, unit, {});
    return number ? std::optional(TimeFunction(*number)) : std::nullopt;
  }
  try {
    const TimeFunction function(*text, an_entry(scope, entry.key));
    if (of_place || !function.depends_on_place()) return function;
    scope.problems.error(entry.value.place, fmt::format("{}: \"{}\" may depend on the time t, not on x, y, z",
                                                        an_entry(scope, entry.key), *text));
    return std::nullopt;
  } catch (const std::invalid_argument& error) {
    scope.problems.error(entry.value.place, fmt::format("{}: {}", an_entry(scope, entry.key), error.what()));
    return std::nullopt;
  }
}

std::optional<VectorFunction> read_vector_function(const Scope& scope, const Node::Entry& entry, Unit unit,
                                                   bool of_place) {
  VectorFunction vector;
  const bool complete = read_items(scope, entry, [&](const Node::Entry& item, std::size_t i) {
    const auto function = read_function(scope, item, unit, of_place);
    if (function) vector.component[i] = *function;
    return function.has_value();
  });
  return complete ? std::optional(vector) : std::nullopt;
}

std::optional<int> read_integer(const Scope& scope, const Node::Entry& entry, const Range& range) {
  const std::int64_t* i = std::get_if<std::int64_t>(&entry.value.value);
  if (!i) {
    wrong_type(scope, entry, "a whole number");
    return std::nullopt;
  }
  if (*i < -2147483647 || *i > 2147483647 || !in_range(range, static_cast<double>(*i))) {
    const std::string bounds = range_text(range, Unit::none);
    scope.problems.error(
        entry.value.place,
        fmt::format("{} must be {}, is {}", an_entry(scope, entry.key),
                    bounds.empty() || in_range(range, static_cast<double>(*i)) ? "at most 2147483647" : bounds, *i));
    return std::nullopt;
  }
  return static_cast<int>(*i);
}

std::optional<bool> read_boolean(const Scope& scope, const Node::Entry& entry) {
  if (const bool* b = std::get_if<bool>(&entry.value.value)) return *b;
  wrong_type(scope, entry, "true or false");
  return std::nullopt;
}

std::optional<std::string> read_string(const Scope& scope, const Node::Entry& entry) {
  if (const std::string* s = entry.value.string()) return *s;
  wrong_type(scope, entry, "a string");
  return std::nullopt;
}

std::optional<std::string> read_name(const Scope& scope, const Node::Entry& entry) {
  const auto name = read_string(scope, entry);
  if (name && name->empty()) {  // elsewhere: none was given
    scope.problems.error(entry.value.place, fmt::format("{} must not be empty", an_entry(scope, entry.key)));
    return std::nullopt;
  }
  return name;
}

std::optional<Vec2> read_pair(const Scope& scope, const Node::Entry& entry, Unit unit, const Range& range) {
  const Node::Array* items = entry.value.array();
  if (!items || items->size() != 2) {
    scope.problems.error(entry.value.place,
                         fmt::format("{} must be an array of two numbers", an_entry(scope, entry.key)));
    return std::nullopt;
  }
  const auto x = read_number(scope, item_entry(entry, 0, (*items)[0]), unit, range);
  const auto y = read_number(scope, item_entry(entry, 1, (*items)[1]), unit, range);
  if (!x || !y) return std::nullopt;
  return Vec2(*x, *y);
}

const Node::Array* read_directions(const Scope& scope, const Node::Entry& entry, std::string_view what,
                                   std::string_view prefix) {
  const Node::Array* items = entry.value.array();
  const std::size_t n = items ? items->size() : 0;
  if (n == static_cast<std::size_t>(scope.dimension())) return items;
  std::string wanted;
  if (scope.dimension() == 3) {
    wanted = fmt::format("[{0}x, {0}y, {0}z] ([model] dimension = 3)", prefix);
  } else if (n == 3) {
    wanted = fmt::format("[{0}x, {0}y]; for three {1} set [model] dimension = 3", prefix, what);
  } else {
    wanted = fmt::format("an array of two {}", what);
  }
  scope.problems.error(entry.value.place, fmt::format("{} must be {}", an_entry(scope, entry.key), wanted));
  return nullptr;
}

std::optional<Vec3> read_vector(const Scope& scope, const Node::Entry& entry, Unit unit, const Range& range) {
  Vec3 vector = Vec3::Zero();
  const bool complete = read_items(scope, entry, [&](const Node::Entry& item, std::size_t i) {
    const auto number = read_number(scope, item, unit, range);
    vector[static_cast<Eigen::Index>(i)] = number.value_or(0.0);
    return number.has_value();
  });
  return complete ? std::optional(vector) : std::nullopt;
}

std::optional<std::vector<Vec2>> read_points(const Scope& scope, const Node::Entry& entry) {
  const Node::Array* items = entry.value.array();
  if (!items) {
    wrong_type(scope, entry, "an array of [x, y] points");
    return std::nullopt;
  }
  std::vector<Vec2> points;
  for (std::size_t i = 0; i < items->size(); ++i) {
    const auto point = read_pair(scope, item_entry(entry, i, (*items)[i]), Unit::length);
    if (!point) return std::nullopt;
    points.push_back(*point);
  }
  return points;
}

std::optional<std::size_t> read_choice(const Scope& scope, const Node::Entry& entry,
                                       const std::vector<std::string>& names) {
  const auto word = read_string(scope, entry);
  if (!word) return std::nullopt;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (names[i] == *word) return i;
  }
  scope.problems.error(entry.value.place, fmt::format("{}: unknown value \"{}\"{}", an_entry(scope, entry.key), *word,
                                                      suggestion(*word, names)));
  return std::nullopt;
}

std::optional<std::size_t> read_choice(const Scope& scope, const Node::Entry& entry,
                                       const std::vector<std::string>& plane, const std::vector<std::string>& solid) {
  const bool in_space = scope.dimension() == 3;
  const std::vector<std::string>& names = in_space ? solid : plane;
  const std::vector<std::string>& others = in_space ? plane : solid;
  const std::string* word = entry.value.string();
  const auto is_in = [&](const std::vector<std::string>& list) {
    return std::find(list.begin(), list.end(), *word) != list.end();
  };
  if (!word || is_in(names) || !is_in(others)) return read_choice(scope, entry, names);
  scope.problems.error(entry.value.place,
                       fmt::format("{}: \"{}\" is for {} {}", an_entry(scope, entry.key), *word,
                                   in_space ? "the plane ([model] dimension = 2); in space there are"
                                            : "models in space ([model] dimension = 3); in the plane there are",
                                   fmt::join(names, ", ")));
  return std::nullopt;
}

std::optional<std::string> read_file(const Scope& scope, Node::Entry& entry, bool needed) {
  const auto written = read_string(scope, entry);
  if (!written) return std::nullopt;
  namespace fs = std::filesystem;
  const std::string path = fs::absolute(fs::path(entry.value.place.folder()) / *written).lexically_normal().string();
  entry.value.value = path;
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) {
    const std::string text =
        fmt::format("{}: file \"{}\" {} (looked for {})", an_entry(scope, entry.key), *written,
                    fs::exists(path, ignored) ? "is none: a folder, a pipe or a device" : "does not exist", path);
    if (needed) {
      scope.problems.error(entry.value.place, text);
    } else {
      scope.problems.warn(entry.value.place, text);
    }
  }
  return path;
}

std::optional<std::vector<std::string>> read_strings(const Scope& scope, const Node::Entry& entry) {
  const Node::Array* items = entry.value.array();
  if (!items) {
    wrong_type(scope, entry, "an array of strings");
    return std::nullopt;
  }
  std::vector<std::string> strings;
  for (std::size_t i = 0; i < items->size(); ++i)
    if (const auto text = read_name(scope, item_entry(entry, i, (*items)[i]))) strings.push_back(*text);
  return strings;
}

std::optional<std::vector<std::string>> read_one_or_more(const Scope& scope, const Node::Entry& entry) {
  if (entry.value.array()) return read_strings(scope, entry);
  if (entry.value.string()) {
    const auto one = read_name(scope, entry);
    return one ? std::optional(std::vector{*one}) : std::nullopt;
  }
  wrong_type(scope, entry, "a string or an array of strings");
  return std::nullopt;
}

}  // namespace berm
