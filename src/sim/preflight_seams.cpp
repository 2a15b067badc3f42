/// Meshes that look like one and are several.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "base/groups.hpp"
#include "base/sort_unique.hpp"
#include "sim/advice.hpp"
#include "sim/preflight.hpp"

namespace berm {
namespace {

/// By place, the first node that lies there. Programs write coordinates with rounding.
class NodePlaces {
public:
  explicit NodePlaces(const Mesh& mesh) : same_(1e-5 * longest_edge(mesh)) {}
  int first_at(const Vec3& x, int node) {
    return first_.try_emplace({std::round(x.x() / same_), std::round(x.y() / same_), std::round(x.z() / same_)}, node).first->second;
  }

private:
  double same_;
  std::map<std::array<double, 3>, int> first_;
};

}  // namespace

void tell_seams(World& w, const std::string& body, const Mesh& mesh) {
  std::vector<int> used = mesh.connectivity;
  sort_unique(used);
  NodePlaces places(mesh);
  int doubled = 0, first = -1;
  for (const int node : used)
    if (places.first_at(mesh.nodes[node], node) != node && doubled++ == 0) first = node;
  if (doubled > 0)
    w.warnings.push_back(fmt::format("mesh of body \"{}\": {} node{} in the place of another, the first at {}: elements are not joined there, and come apart "
                                     "or pass through each other. If that is no crack, join them (Gmsh: Coherence Mesh;)",
                                     body, doubled, doubled == 1 ? " lies" : "s lie", place_text(w.spec, mesh.nodes[first])));
}

BodyParts parts_of_mesh(const Mesh& mesh) {
  Groups groups(mesh.nodes.size());
  NodePlaces places(mesh);
  for (int e = 0; e < mesh.n_cells(); ++e)
    for (const int node : mesh.nodes_of_cell(e)) {
      groups.join(node, mesh.cell(e)[0]);
      groups.join(node, places.first_at(mesh.nodes[node], node));
    }
  std::vector<int> group;
  for (int node = 0; node < mesh.n_nodes(); ++node) group.push_back(groups.of(node));
  return {mesh.nodes, group, longest_edge(mesh)};
}

}  // namespace berm
