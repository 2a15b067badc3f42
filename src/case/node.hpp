#pragma once
/// A TOML document as a plain tree that remembers where every key and value stands, and keeps the order of the file.

#include <cstdint>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace berm {

/// Where something was written: in a file, or in a command-line override.
struct Place {
  std::string file;      ///< as the user wrote it
  std::string override;  ///< text of the override; empty in files
  int line = 0, column = 0;

  /// "dam.toml:14:9", or `override "solver.integration=impl_ex"`.
  std::string text() const;
  /// Folder against which relative paths resolve: of the file; the current one for overrides.
  std::string folder() const;
};

struct Node {
  struct Entry;
  struct Date {
    std::string text;
  };
  using Array = std::vector<Node>;
  using Object = std::vector<Entry>;
  using Value = std::variant<bool, std::int64_t, double, std::string, Date, Array, Object>;

  Value value = Object{};
  Place place = {};

  Node();
  Node(Value v, Place p = {});

  bool is_object() const { return std::holds_alternative<Object>(value); }
  Object& object() { return std::get<Object>(value); }
  const Object& object() const { return std::get<Object>(value); }
  const Array* array() const { return std::get_if<Array>(&value); }
  Array* array() { return std::get_if<Array>(&value); }
  const std::string* string() const { return std::get_if<std::string>(&value); }

  /// The entry with that key, or nullptr (also if this is no table).
  Entry* find(std::string_view key);
  const Entry* find(std::string_view key) const;
  /// Adds or replaces an entry; returns its value.
  Node& set(std::string_view key, Node node);
  void erase(std::string_view key);
  /// What a person calls it: "a string", "a table", ...
  std::string_view type_name() const;
};

struct Node::Entry {
  std::string key;
  Place place;
  Node value;
};

/// Two numbers as an array.
Node pair_node(double x, double y);

/// TOML text of a table: headers down to depth two, deeper tables inline. Reads back to the same tree.
std::string write_toml(const Node& root);
/// The same tree as indented JSON.
std::string write_json(const Node& root);

}  // namespace berm
