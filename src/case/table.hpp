#pragma once
/// The builder of the one table that parses a case file, fills its defaults and documents it.
///
///   Table<Steps> t("How the run is cut into increments.");
///   t.integer("count", &Steps::count, {1, 1e9}, "increments that cover time 0..1");
///
/// A key's default is what the struct's own initialiser says, unless `.required()` or `.no_default()` follows. `member`
/// is a member pointer or a function from T& to a reference; std::optional members are filled when the key is given.

#include <functional>
#include <optional>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "case/scope.hpp"

namespace berm {

/// What the manual says about a key.
struct KeyInfo {
  std::string key, type, range, default_text, condition, doc;
  bool required = false;
  bool named = false;             ///< `children` are the keys of [key.NAME]
  Node json;                      ///< JSON Schema of the value
  std::vector<KeyInfo> children;  ///< of a table
};

KeyInfo number_info(const std::string& key, Unit unit, const Range& range, const std::string& doc);
KeyInfo integer_info(const std::string& key, const Range& range, const std::string& doc);
/// Two numbers, in the plane and in space.
KeyInfo pair_info(const std::string& key, Unit unit, const Range& range, const std::string& doc);
/// A number a direction.
KeyInfo vector_info(const std::string& key, Unit unit, const Range& range, const std::string& doc);
/// A number or an expression, and one a direction.
KeyInfo function_info(const std::string& key, Unit unit, bool of_place, const std::string& doc);
KeyInfo vector_function_info(const std::string& key, Unit unit, bool of_place, const std::string& doc);
KeyInfo choice_info(const std::string& key, const std::vector<std::string>& names, const std::string& doc);
/// Other words in the plane than in space.
KeyInfo choice_info(const std::string& key, const std::vector<std::string>& plane,
                    const std::vector<std::string>& solid, const std::string& doc);
/// Any key whose value has that JSON type.
KeyInfo plain_info(const std::string& key, const std::string& type, const std::string& json_type,
                   const std::string& doc);
KeyInfo table_info(const std::string& key, const std::string& doc, std::vector<KeyInfo> children, bool named);
/// JSON Schema of one or the other, and of an array of such items.
Node either_schema(Node one, Node other);
Node array_schema(Node items);
/// JSON Schema of a table with exactly these keys.
Node object_schema(const std::vector<KeyInfo>& keys);
/// How a default is written in a case file; nothing for values that are unset.
std::optional<Node> number_node(double value, Unit unit);
std::optional<Node> number_node(const std::optional<double>& value, Unit unit);
std::optional<Node> vector_node(const Vec2& value, Unit unit, int dimension);
std::optional<Node> vector_node(const Vec3& value, Unit unit, int dimension);
std::optional<Node> vector_node(const std::optional<Vec3>& value, Unit unit, int dimension);
std::optional<Node> function_node(const TimeFunction& value, Unit unit);
std::optional<Node> function_node(const std::optional<TimeFunction>& value, Unit unit);
std::optional<Node> function_node(const VectorFunction& value, Unit unit, int dimension);
std::optional<Node> function_node(const std::optional<VectorFunction>& value, Unit unit, int dimension);
/// Text of a default for the manual, in the plane and in space.
std::string default_text(const std::optional<Node>& plane, const std::optional<Node>& solid);
/// Reports the keys of the table that are not in `valid`.
void report_unknown(const Scope& scope, const std::vector<std::string>& valid);

/// Makes a direction a unit vector; reports one of length zero.
void make_unit(const Scope& scope, std::string_view key, Vec3& direction);

/// Reports a NAME of [key.NAME] that could not serve as a column or file name.
void report_bad_name(const Scope& scope, const Node::Entry& entry);

/// The words of a choice and what they stand for.
template <class E>
using Words = std::vector<std::pair<std::string, E>>;
/// Words of which some are for the plane and some for space.
template <class E>
struct WordsByDimension {
  Words<E> plane, solid;
  const Words<E>& of(int dimension) const { return dimension == 3 ? solid : plane; }
};
template <class E>
std::vector<std::string> names_of(const Words<E>& words) {
  std::vector<std::string> names;
  for (const auto& word : words) names.push_back(word.first);
  return names;
}

template <class T>
class Table {
public:
  using Read = std::function<void(Scope&, Node::Entry&, T&)>;
  /// Of a T with its initialisers, in a model of that dimension.
  using Default = std::function<std::optional<Node>(T&, int dimension)>;

  explicit Table(std::string doc) : doc_(std::move(doc)) {}

  template <class M>
  Table& number(const std::string& key, M member, Unit unit, Range range, const std::string& doc) {
    return add(
        number_info(key, unit, range, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto v = read_number(s, e, unit, range)) std::invoke(member, t) = *v;
        },
        [=](T& t, int) { return number_node(std::invoke(member, t), unit); });
  }

  template <class M>
  Table& integer(const std::string& key, M member, Range range, const std::string& doc) {
    return add(
        integer_info(key, range, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto v = read_integer(s, e, range)) std::invoke(member, t) = *v;
        },
        [=](T& t, int) { return std::optional<Node>(Node(std::int64_t{std::invoke(member, t)})); });
  }

  template <class M>
  Table& boolean(const std::string& key, M member, const std::string& doc) {
    return add(
        plain_info(key, "true or false", "boolean", doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto v = read_boolean(s, e)) std::invoke(member, t) = *v;
        },
        [=](T& t, int) { return std::optional<Node>(Node(bool{std::invoke(member, t)})); });
  }

  /// Free text. Absent by default.
  template <class M>
  Table& text(const std::string& key, M member, const std::string& doc) {
    return custom(plain_info(key, "string", "string", doc), [=](Scope& s, Node::Entry& e, T& t) {
      if (const auto v = read_string(s, e)) std::invoke(member, t) = *v;
    });
  }

  /// The name of something, `type` says of what: an error if empty. Absent by default.
  template <class M>
  Table& name(const std::string& key, M member, const std::string& type, const std::string& doc) {
    return custom(plain_info(key, type, "string", doc), [=](Scope& s, Node::Entry& e, T& t) {
      if (const auto v = read_name(s, e)) std::invoke(member, t) = *v;
    });
  }

  /// Names, of `type`. Absent by default.
  template <class M>
  Table& names(const std::string& key, M member, const std::string& type, const std::string& doc) {
    KeyInfo info = plain_info(key, type, "array", doc);
    info.json.set("items", plain_info("", "", "string", "").json);
    return custom(info, [=](Scope& s, Node::Entry& e, T& t) {
      if (const auto v = read_strings(s, e)) std::invoke(member, t) = *v;
    });
  }

  /// Path of a file. Absent by default.
  template <class M>
  Table& file(const std::string& key, M member, const std::string& doc) {
    return custom(plain_info(key, "file", "string", doc), [=](Scope& s, Node::Entry& e, T& t) {
      if (const auto v = read_file(s, e, true)) std::invoke(member, t) = *v;
    });
  }

  /// Two numbers, in the plane and in space: a Vec2.
  template <class M>
  Table& pair(const std::string& key, M member, Unit unit, const std::string& doc, Range range = {}) {
    return add(
        pair_info(key, unit, range, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto v = read_pair(s, e, unit, range)) std::invoke(member, t) = *v;
        },
        [=](T& t, int dimension) { return vector_node(std::invoke(member, t), unit, dimension); });
  }

  /// As many numbers as the model has dimensions: a Vec3, z = 0 in the plane.
  template <class M>
  Table& vector(const std::string& key, M member, Unit unit, const std::string& doc, Range range = {}) {
    return add(
        vector_info(key, unit, range, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto v = read_vector(s, e, unit, range)) std::invoke(member, t) = *v;
        },
        [=](T& t, int dimension) { return vector_node(std::invoke(member, t), unit, dimension); });
  }

  /// A TimeFunction, of the place too if `of_place`.
  template <class M>
  Table& function(const std::string& key, M member, Unit unit, bool of_place, const std::string& doc) {
    return add(
        function_info(key, unit, of_place, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto v = read_function(s, e, unit, of_place)) std::invoke(member, t) = *v;
        },
        [=](T& t, int) { return function_node(std::invoke(member, t), unit); });
  }

  /// A VectorFunction: as many functions as the model has dimensions, of the place too if `of_place`.
  template <class M>
  Table& vector_function(const std::string& key, M member, Unit unit, const std::string& doc, bool of_place = false) {
    return add(
        vector_function_info(key, unit, of_place, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto v = read_vector_function(s, e, unit, of_place)) std::invoke(member, t) = *v;
        },
        [=](T& t, int dimension) { return function_node(std::invoke(member, t), unit, dimension); });
  }

  template <class M, class E>
  Table& choice(const std::string& key, M member, const Words<E>& options, const std::string& doc) {
    const std::vector<std::string> names = names_of(options);
    return add(
        choice_info(key, names, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto i = read_choice(s, e, names)) std::invoke(member, t) = options[*i].second;
        },
        [=](T& t, int) -> std::optional<Node> {
          for (const auto& [name, value] : options) {
            if (std::invoke(member, t) == value) return Node(name);
          }
          return std::nullopt;
        });
  }

  /// Other words in the plane than in space; the default is the first one.
  template <class M, class E>
  Table& choice(const std::string& key, M member, const WordsByDimension<E>& options, const std::string& doc) {
    const std::vector<std::string> plane = names_of(options.plane), solid = names_of(options.solid);
    add(
        choice_info(key, plane, solid, doc),
        [=](Scope& s, Node::Entry& e, T& t) {
          if (const auto i = read_choice(s, e, plane, solid))
            std::invoke(member, t) = options.of(s.dimension())[*i].second;
        },
        [=](T&, int dimension) { return std::optional<Node>(Node(options.of(dimension).front().first)); });
    fields_.back().absent = [=](const Scope& s, T& t) {
      std::invoke(member, t) = options.of(s.dimension()).front().second;
    };
    return *this;
  }

  /// A table in this table. Its defaults hold when it is absent, except for optional members and after `.no_default()`.
  template <class M, class U>
  Table& table(const std::string& key, M member, const Table<U>& inner) {
    const auto read = [=](Scope& s, Node::Entry& e, T& t) {
      auto child = s.child(e);
      if (!child) return;
      auto& target = std::invoke(member, t);
      if constexpr (std::is_convertible_v<decltype(target), U&>) {
        inner.read(*child, target);
      } else {
        inner.read(*child, target.emplace());
      }
    };
    custom(table_info(key, inner.doc(), inner.keys(), false), read);
    constexpr bool is_plain = std::is_convertible_v<std::invoke_result_t<M, T&>, U&>;
    fields_.back().read_absent = is_plain;
    return *this;
  }

  /// Tables [key.NAME]: one element of the vector each, whose `name` is NAME.
  template <class M, class U>
  Table& named(const std::string& key, M member, const std::string& doc, std::vector<KeyInfo> children,
               std::function<void(Scope&, U&)> read_one) {
    return custom(table_info(key, doc, std::move(children), true), [=](Scope& s, Node::Entry& e, T& t) {
      auto all = s.child(e);
      if (!all) return;
      for (Node::Entry& one : all->node.object()) {
        report_bad_name(*all, one);
        auto scope = all->child(one);
        if (!scope) continue;
        U& element = std::invoke(member, t).emplace_back();
        element.name = one.key;
        read_one(*scope, element);
      }
    });
  }
  template <class M, class U>
  Table& named(const std::string& key, M member, const Table<U>& inner) {
    return named<M, U>(key, member, inner.doc(), inner.keys(), [=](Scope& s, U& u) { inner.read(s, u); });
  }

  /// A key with its own reader; without a default unless `fallback` gives one.
  Table& custom(KeyInfo info, Read read, Default fallback = nullptr) {
    return add(std::move(info), std::move(read), std::move(fallback));
  }

  // Said of the key added last:
  Table& required() {
    fields_.back().info.required = true;
    return no_default();
  }
  Table& no_default() {
    fields_.back().fallback = nullptr;
    fields_.back().absent = nullptr;
    fields_.back().read_absent = false;
    return *this;
  }
  /// The key may only be given (and has its default only) if `condition` holds; `text` completes "only ...".
  /// Conditions see the keys that were added before.
  Table& only(std::function<bool(const Scope&, const T&)> condition, const std::string& text) {
    fields_.back().condition = std::move(condition);
    fields_.back().info.condition = text;
    return *this;
  }
  Table& only_with(const std::string& key) {
    return only([=](const Scope& s, const T&) { return s.has(key); }, "with \"" + key + "\"");
  }
  Table& only_without(const std::string& key) {
    return only([=](const Scope& s, const T&) { return !s.has(key); }, "without \"" + key + "\"");
  }
  /// `alternative`: what serves instead, e.g. "; in the plane take \"disc\"".
  Table& only_in_space(const std::string& alternative = "") {
    return only([](const Scope& s, const T&) { return s.dimension() == 3; },
                "in space ([model] dimension = 3)" + alternative);
  }
  Table& only_in_plane(const std::string& alternative = "") {
    return only([](const Scope& s, const T&) { return s.dimension() == 2; },
                "in the plane ([model] dimension = 2)" + alternative);
  }

  /// Runs after all keys have been read without an error; before defaults are written.
  Table& check(std::function<void(Scope&, T&)> rule) {
    rules_.push_back(std::move(rule));
    return *this;
  }

  void read(Scope& scope, T& out) const {
    const std::size_t errors_before = scope.problems.count();
    report_unknown(scope, valid_keys());
    for (const Field& field : fields_) read_field(field, scope, out);
    if (scope.problems.count() != errors_before) return;
    for (const auto& rule : rules_) rule(scope, out);
    write_defaults(scope, out);
  }

  const std::string& doc() const { return doc_; }
  std::vector<KeyInfo> keys() const {
    std::vector<KeyInfo> infos;
    for (const Field& field : fields_) {
      infos.push_back(field.info);
      T fresh{};
      if (field.fallback) infos.back().default_text = default_text(field.fallback(fresh, 2), field.fallback(fresh, 3));
    }
    return infos;
  }

private:
  struct Field {
    KeyInfo info;
    Read read;
    Default fallback;
    std::function<bool(const Scope&, const T&)> condition;
    std::function<void(const Scope&, T&)> absent;  ///< sets a default that is not the struct's
    bool read_absent = false;                      ///< a table that is read as an empty one if it is absent
  };

  Table& add(KeyInfo info, Read read, Default fallback) {
    fields_.push_back({std::move(info), std::move(read), std::move(fallback), nullptr, nullptr, false});
    return *this;
  }

  std::vector<std::string> valid_keys() const {
    std::vector<std::string> valid;
    for (const Field& field : fields_) valid.push_back(field.info.key);
    return valid;
  }

  void read_field(const Field& field, Scope& scope, T& out) const {
    const std::string& key = field.info.key;
    Node::Entry* entry = scope.node.find(key);
    const bool allowed = !field.condition || field.condition(scope, out);
    if (entry && !allowed) {
      scope.error(key, "is only allowed " + field.info.condition);
    } else if (entry) {
      field.read(scope, *entry, out);
    } else if (field.info.required && allowed) {
      scope.missing(key, field.info.type);
    } else if (field.read_absent && allowed) {
      Node::Entry empty{key, scope.place, Node(Node::Object{}, scope.place)};
      field.read(scope, empty, out);
      if (!empty.value.object().empty()) scope.node.set(key, std::move(empty.value));
    } else if (field.absent && allowed) {
      field.absent(scope, out);
    }
  }

  void write_defaults(Scope& scope, const T& out) const {
    for (const Field& field : fields_) {
      if (!field.fallback || scope.has(field.info.key)) continue;
      if (field.condition && !field.condition(scope, out)) continue;
      T fresh{};
      if (auto node = field.fallback(fresh, scope.dimension())) {
        node->place = scope.place;
        scope.node.set(field.info.key, std::move(*node));
      }
    }
  }

  std::string doc_;
  std::vector<Field> fields_;
  std::vector<std::function<void(Scope&, T&)>> rules_;
};

}  // namespace berm
