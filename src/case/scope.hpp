#pragma once
/// The table of a case file that is being read, and readers of single values. Every reader reports what is wrong and
/// then returns nothing.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "base/parameter.hpp"
#include "base/tensor.hpp"
#include "base/time_function.hpp"
#include "case/problems.hpp"

namespace berm {

struct Scope {
  Problems& problems;
  Node& node;                    ///< a table
  std::string path;              ///< "body.specimen"; "" for the top level
  Place place;                   ///< where complaints about something missing point to
  const Scope* outer = nullptr;  ///< the table that holds this one

  bool has(std::string_view key) const { return node.find(key) != nullptr; }
  /// Numbers that a place has: 3 if the case file says [model] dimension = 3, else 2.
  int dimension() const;
  /// Error at the key's value, or at the table if the key is absent: `"key" in [path] <text>`.
  void error(std::string_view key, const std::string& text) const;
  /// Error at the key's value: `"key" in [path]: <text>`, for texts that quote the value.
  void explain(std::string_view key, const std::string& text) const;
  void warn(std::string_view key, const std::string& text) const;
  void missing(std::string_view key, const std::string& what) const;
  /// ` in [path]`, or ` at the top level`.
  std::string where() const;
  /// The place of a key's value, or of the table.
  Place place_of(std::string_view key) const;
  std::string path_of(std::string_view key) const;
  /// The table under a key; reports a value that is not a table.
  std::optional<Scope> child(Node::Entry& entry) const;

  /// Reports if not exactly (at least) one of the keys is given.
  void exactly_one(const std::vector<std::string>& keys) const;
  void at_least_one(const std::vector<std::string>& keys) const;
};

/// A number in SI and radians; strings carry units, bare angles are degrees.
std::optional<double> read_number(const Scope&, const Node::Entry&, Unit, const Range&);
std::optional<int> read_integer(const Scope&, const Node::Entry&, const Range&);
std::optional<bool> read_boolean(const Scope&, const Node::Entry&);
std::optional<std::string> read_string(const Scope&, const Node::Entry&);
std::optional<std::string> read_name(const Scope&, const Node::Entry&);  ///< a string that is not empty
/// Two numbers, in the plane and in space.
std::optional<Vec2> read_pair(const Scope&, const Node::Entry&, Unit, const Range& = {});
/// A number a direction; z = 0 in the plane.
std::optional<Vec3> read_vector(const Scope&, const Node::Entry&, Unit, const Range& = {});
/// A number, a string with a unit, or an expression of t and, if `of_place`, of x, y and z.
std::optional<TimeFunction> read_function(const Scope&, const Node::Entry&, Unit, bool of_place);
std::optional<VectorFunction> read_vector_function(const Scope&, const Node::Entry&, Unit, bool of_place);
/// The items of an array with one item a direction, e.g. [x, y] and [x, y, z]; nullptr after any other number of them.
/// `what`: "numbers", "whole numbers"; `prefix` of the names of the directions in messages.
const Node::Array* read_directions(const Scope&, const Node::Entry&, std::string_view what, std::string_view prefix);
std::optional<std::vector<Vec2>> read_points(const Scope&, const Node::Entry&);
/// Index into `names`.
std::optional<std::size_t> read_choice(const Scope&, const Node::Entry&, const std::vector<std::string>& names);
/// The same where plane models and models in space have words of their own: index into those of this model.
std::optional<std::size_t> read_choice(const Scope&, const Node::Entry&, const std::vector<std::string>& plane,
                                       const std::vector<std::string>& solid);
/// An absolute path, resolved against the folder of the file that holds the entry; written back into the entry.
/// A file that does not exist is an error, or a warning if it is not `needed`.
std::optional<std::string> read_file(const Scope&, Node::Entry&, bool needed);
std::optional<std::vector<std::string>> read_strings(const Scope&, const Node::Entry&);
/// A string, or an array of them.
std::optional<std::vector<std::string>> read_one_or_more(const Scope&, const Node::Entry&);

}  // namespace berm
