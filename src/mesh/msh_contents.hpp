#pragma once
/// What the checks of text and of binary .msh files share: the nodes of the file and what its elements may be.

#include <fmt/format.h>

#include <functional>
#include <map>
#include <string>
#include <unordered_set>

#include "mesh/msh_check.hpp"

namespace berm {

class MshContents {
public:
  /// fail: throws with the place in the file.
  explicit MshContents(std::function<void(const std::string&)> fail) : fail_(std::move(fail)) {}

  void add_node(long long tag) {
    if (!nodes_.insert(tag).second) fail_(fmt::format("node {} exists already", tag));
  }
  void check_nodes(unsigned long long announced, long long first, long long last) const {
    if (nodes_.size() != announced) fail_("the number of nodes is not the one announced");
    for (const long long tag : nodes_)
      if (tag < first || tag > last) fail_(fmt::format("node {} is outside of the range announced", tag));
  }
  bool has_nodes() const { return !nodes_.empty(); }

  /// Nodes of an element of that type: cells, lines and points (Gmsh manual, "MSH file format").
  std::size_t nodes_of(long long type) const {
    static const std::map<long long, std::size_t> known = {{1, 2}, {2, 3},   {3, 4},  {4, 4},  {5, 8},  {8, 3},
                                                           {9, 6}, {11, 10}, {15, 1}, {16, 8}, {17, 20}};
    // Those that users are most likely to bring along.
    static const std::map<long long, const char*> unsupported = {
        {6, "6-node prism"},      {7, "5-node pyramid"},   {10, "9-node quad"},        {12, "27-node hexahedron"},
        {13, "18-node prism"},    {14, "14-node pyramid"}, {18, "15-node prism"},      {19, "13-node pyramid"},
        {21, "10-node triangle"}, {26, "4-node line"},     {29, "20-node tetrahedron"}};
    if (const auto found = known.find(type); found != known.end()) return found->second;
    const auto name = unsupported.find(type);
    fail_(fmt::format("element type {}{} is not supported ({})", type,
                      name == unsupported.end() ? "" : fmt::format(" ({})", name->second), supported_elements));
    return 0;
  }
  void check_use(long long node) const {
    if (!nodes_.count(node)) fail_(fmt::format("the element uses node {}, which does not exist", node));
  }

private:
  std::function<void(const std::string&)> fail_;
  std::unordered_set<long long> nodes_;
};

}  // namespace berm
