#include "case/node.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <filesystem>

namespace berm {

std::string Place::text() const {
  if (!override.empty()) return fmt::format("override \"{}\"", override);
  if (line == 0) return file;
  return fmt::format("{}:{}:{}", file, line, column);
}

std::string Place::folder() const {
  return override.empty() ? std::filesystem::path(file).parent_path().string() : std::string();
}

Node::Node() = default;
Node::Node(Value v, Place p) : value(std::move(v)), place(std::move(p)) {}

Node::Entry* Node::find(std::string_view key) { return const_cast<Entry*>(static_cast<const Node*>(this)->find(key)); }

const Node::Entry* Node::find(std::string_view key) const {
  if (!is_object()) return nullptr;
  for (const Entry& entry : object()) {
    if (entry.key == key) return &entry;
  }
  return nullptr;
}

Node& Node::set(std::string_view key, Node node) {
  if (Entry* entry = find(key)) return entry->value = std::move(node);
  object().push_back({std::string(key), node.place, std::move(node)});
  return object().back().value;
}

void Node::erase(std::string_view key) {
  std::erase_if(object(), [&](const Entry& entry) { return entry.key == key; });
}

std::string_view Node::type_name() const {
  constexpr std::array<std::string_view, 7> names = {"true/false", "a whole number", "a decimal number", "a string",
                                                     "a date",     "an array",       "a table"};
  return names[value.index()];
}

Node pair_node(double x, double y) {
  Node::Array items;
  items.emplace_back(x);
  items.emplace_back(y);
  return Node(std::move(items));
}

}  // namespace berm
