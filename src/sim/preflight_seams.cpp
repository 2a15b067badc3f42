/// Meshes that look like one and are several.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "base/sort_unique.hpp"
#include "sim/advice.hpp"
#include "sim/preflight.hpp"

namespace berm {

void tell_seams(World& w, const std::string& body, const Mesh& mesh) {
  const double same = 1e-5 * longest_edge(mesh);  // programs write coordinates with rounding
  std::vector<int> used = mesh.connectivity;
  sort_unique(used);
  std::vector<std::array<double, 3>> places;
  for (const int node : used) {
    const Vec3& x = mesh.nodes[node];
    places.push_back({std::round(x.x() / same), std::round(x.y() / same), std::round(x.z() / same)});
  }
  std::sort(places.begin(), places.end());
  int doubled = 0;
  Vec3 first = Vec3::Zero();
  for (std::size_t k = 1; k < places.size(); ++k)
    if (places[k] == places[k - 1] && doubled++ == 0) first = same * Vec3(places[k][0], places[k][1], places[k][2]);
  if (doubled > 0)
    w.warnings.push_back(fmt::format("mesh of body \"{}\": {} node{} in the place of another, the first at {}: elements are not joined there, and come apart "
                                     "or pass through each other. If that is no crack, join them (Gmsh: Coherence Mesh;)",
                                     body, doubled, doubled == 1 ? " lies" : "s lie", place_text(w.spec, first)));
}

}  // namespace berm
