#include "mesh/gmsh_model.hpp"

#include <fmt/format.h>
#include <gmsh.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <set>
#include <unordered_map>

#include "base/error.hpp"

namespace berm {

namespace {

constexpr double least_corner_sine = 1e-6;  ///< cells with a sharper or inverted corner are degenerate

/// Gmsh's life; restarted after an error, since an exception leaves its locks closed.
struct Session {
  Session() { start(); }
  ~Session() { gmsh::finalize(); }
  void start() {
    gmsh::initialize(0, nullptr, false);
    gmsh::option::setNumber("General.Terminal", 0);
    gmsh::option::setNumber("General.NumThreads", 1);
  }
  void restart() {
    gmsh::finalize();
    start();
  }
};

/// Gmsh's element types, see the section "MSH file format" of its manual.
std::optional<CellKind> kind_of(int gmsh_type) {
  switch (gmsh_type) {
    case 2:
      return CellKind::tri3;
    case 3:
      return CellKind::quad4;
    case 9:
      return CellKind::tri6;
    case 16:
      return CellKind::quad8;
    default:
      return std::nullopt;
  }
}

std::string name_of_type(int gmsh_type) {
  std::string name;
  int dim = 0, order = 0, n_nodes = 0, n_primary = 0;
  std::vector<double> local;
  gmsh::model::mesh::getElementProperties(gmsh_type, name, dim, order, n_nodes, local, n_primary);
  return name;
}

/// Runs through the nodes of a cell the other way round, starting at the same corner.
void reverse(std::vector<int>& nodes, int corners) {
  std::reverse(nodes.begin() + 1, nodes.begin() + corners);
  std::reverse(nodes.begin() + corners, nodes.end());
}

class Extraction {
public:
  explicit Extraction(const std::string& subject) : subject_(subject) {}

  Mesh run() {
    read_nodes();
    gmsh::vectorpair surfaces, volumes;
    gmsh::model::getEntities(volumes, 3);
    for (const auto& [dim, tag] : volumes) refuse_elements(dim, tag);
    gmsh::model::getEntities(surfaces, 2);
    for (const auto& [dim, tag] : surfaces) read_cells(tag);
    if (mesh_.kinds.empty()) fail("has no plane cells (triangles or quads); save the surface elements too");
    drop_unused_nodes();
    orient();
    read_groups();
    return std::move(mesh_);
  }

private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(subject_ + ": " + what); }

  void refuse_elements(int dim, int tag) const {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> tags, nodes;
    gmsh::model::mesh::getElements(types, tags, nodes, dim, tag);
    if (!types.empty())
      fail(fmt::format("element type \"{}\" is not supported (plane meshes only)", name_of_type(types[0])));
  }

  void read_nodes() {
    std::vector<double> coordinates, parameters;
    gmsh::model::mesh::getNodes(tags_, coordinates, parameters);
    order_.resize(tags_.size());
    for (std::size_t i = 0; i < order_.size(); ++i) order_[i] = i;
    std::sort(order_.begin(), order_.end(), [&](std::size_t a, std::size_t b) { return tags_[a] < tags_[b]; });
    for (std::size_t i : order_) {
      const double* x = &coordinates[3 * i];
      if (!std::isfinite(x[0]) || !std::isfinite(x[1]) || !std::isfinite(x[2]))
        fail(fmt::format("node {} has a coordinate that is not a number", tags_[i]));
      if (number_.emplace(tags_[i], mesh_.n_nodes()).second) {
        mesh_.nodes.emplace_back(x[0], x[1], x[2]);
      }
    }
  }

  void read_cells(int surface) {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> tags, nodes;
    gmsh::model::mesh::getElements(types, tags, nodes, 2, surface);
    for (std::size_t t = 0; t < types.size(); ++t) {
      const std::optional<CellKind> kind = kind_of(types[t]);
      if (!kind)
        fail(fmt::format(
            "element type \"{}\" is not supported (3-node and 6-node triangles, 4-node and 8-node quads are)",
            name_of_type(types[t])));
      const int n = nodes_of(*kind);
      for (std::size_t e = 0; e < tags[t].size(); ++e) add_cell(*kind, &nodes[t][e * n], surface);
    }
  }

  /// Files of format 2.2 repeat a cell for every physical group that it is in.
  void add_cell(CellKind kind, const std::size_t* node_tags, int surface) {
    std::vector<int> cell;
    for (int i = 0; i < nodes_of(kind); ++i) {
      const auto found = number_.find(node_tags[i]);
      if (found == number_.end()) fail(fmt::format("a cell uses node {}, which does not exist", node_tags[i]));
      cell.push_back(found->second);
    }
    std::vector<int> key = cell;
    std::sort(key.begin(), key.end());
    if (std::adjacent_find(key.begin(), key.end()) != key.end())
      fail(fmt::format("a cell uses node {} twice", tags_[order_[*std::adjacent_find(key.begin(), key.end())]]));
    const auto [place, is_new] = known_.emplace(std::move(key), mesh_.n_cells());
    if (is_new) mesh_.add_cell(kind, cell.data());
    cells_of_surface_[surface].push_back(place->second);
  }

  void drop_unused_nodes() {
    std::vector<int> renumbered(mesh_.nodes.size(), -1);
    for (int n : mesh_.connectivity) renumbered[n] = 0;
    std::vector<Vec3> kept;
    Vec3 low = mesh_.nodes[mesh_.connectivity[0]], high = low;
    for (int n = 0; n < mesh_.n_nodes(); ++n) {
      if (renumbered[n] < 0) continue;
      renumbered[n] = static_cast<int>(kept.size());
      kept.push_back(mesh_.nodes[n]);
      low = low.cwiseMin(mesh_.nodes[n]);
      high = high.cwiseMax(mesh_.nodes[n]);
    }
    if (mesh_.dimension() == 2) flatten(kept, (high - low).maxCoeff());
    for (int& n : mesh_.connectivity) n = renumbered[n];
    for (auto& [tag, n] : number_) n = renumbered[n];
    mesh_.nodes = std::move(kept);
  }

  /// Plane meshes lie in the plane z = 0.
  void flatten(std::vector<Vec3>& nodes, double size) const {
    for (Vec3& x : nodes) {
      if (std::abs(x.z()) > 1e-9 * size)
        fail(fmt::format("the mesh does not lie in the plane z = 0 (a node has z = {:g})", x.z()));
      x.z() = 0.0;
    }
  }

  void orient() {
    for (int c = 0; c < mesh_.n_cells(); ++c) {
      if (cell_measure(mesh_, c) < 0.0) {
        const auto begin = mesh_.connectivity.begin() + mesh_.offsets[c];
        std::vector<int> nodes(begin, begin + nodes_of(mesh_.kinds[c]));
        reverse(nodes, corners_of(mesh_.kinds[c]));
        std::copy(nodes.begin(), nodes.end(), begin);
      }
      if (!(smallest_corner_sine(mesh_, c) > least_corner_sine)) {
        const Vec3& x = mesh_.nodes[mesh_.cell(c)[0]];
        fail(fmt::format("degenerate cell at ({:g}, {:g}{}): it is flat, crossed or not convex", x.x(), x.y(),
                         mesh_.dimension() == 3 ? fmt::format(", {:g}", x.z()) : ""));
      }
    }
  }

  void read_groups() {
    gmsh::vectorpair groups;
    gmsh::model::getPhysicalGroups(groups);
    for (const auto& [dim, tag] : groups) {
      std::string name;
      gmsh::model::getPhysicalName(dim, tag, name);
      if (name.empty()) name = std::to_string(tag);
      if (dim == 1) add_to(mesh_.node_groups[name], nodes_of_group(tag));
      if (dim == 2) add_to(mesh_.cell_groups[name], cells_of_group(tag));
    }
  }

  static void add_to(std::vector<int>& group, std::vector<int> members) {
    group.insert(group.end(), members.begin(), members.end());
    std::sort(group.begin(), group.end());
    group.erase(std::unique(group.begin(), group.end()), group.end());
  }

  std::vector<int> nodes_of_group(int tag) const {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates;
    gmsh::model::mesh::getNodesForPhysicalGroup(1, tag, tags, coordinates);
    std::vector<int> nodes;
    for (std::size_t t : tags) {
      const auto found = number_.find(t);
      if (found != number_.end() && found->second >= 0) nodes.push_back(found->second);
    }
    return nodes;
  }

  std::vector<int> cells_of_group(int tag) const {
    std::vector<int> surfaces, cells;
    gmsh::model::getEntitiesForPhysicalGroup(2, tag, surfaces);
    for (int surface : surfaces) {
      const auto found = cells_of_surface_.find(surface);
      if (found != cells_of_surface_.end()) cells.insert(cells.end(), found->second.begin(), found->second.end());
    }
    return cells;
  }

  struct KeyHash {
    std::size_t operator()(const std::vector<int>& key) const {
      std::size_t hash = 0;
      for (int k : key) hash = hash * 1000003u + static_cast<std::size_t>(k);
      return hash;
    }
  };

  const std::string& subject_;
  Mesh mesh_;
  std::vector<std::size_t> tags_, order_;
  std::unordered_map<std::size_t, int> number_;  ///< by Gmsh tag; -1: dropped
  std::unordered_map<std::vector<int>, int, KeyHash> known_;
  std::map<int, std::vector<int>> cells_of_surface_;
};

}  // namespace

Mesh with_gmsh(const std::string& subject, const std::function<Mesh()>& work) {
  static Session session;
  const auto failure = [&](const std::string& message) {
    session.restart();
    return InputError(fmt::format("{}: {}", subject, message.empty() ? "Gmsh gave up without a message" : message));
  };
  try {
    gmsh::clear();
    Mesh mesh = work();
    gmsh::clear();
    return mesh;
  } catch (const InputError&) {
    session.restart();
    throw;
  } catch (const std::string& message) {  // Gmsh 4.8 throws strings
    throw failure(message);
  } catch (const std::exception& error) {
    throw failure(error.what());
  }
}

Mesh current_gmsh_mesh(const std::string& subject) { return Extraction(subject).run(); }

double smallest_corner_sine(const Mesh& mesh, int c) {
  const int corners = corners_of(mesh.kinds[c]);
  const bool curved = nodes_of(mesh.kinds[c]) > corners;
  const int* nodes = mesh.cell(c);
  // Direction in which the side from corner `a` to corner `b` leaves a; `side` counts from the smaller corner on.
  const auto leaving = [&](int a, int b, int side) {
    const Vec3 &from = mesh.nodes[nodes[a]], &to = mesh.nodes[nodes[b]];
    return curved ? Vec3(4.0 * mesh.nodes[nodes[corners + side]] - 3.0 * from - to) : Vec3(to - from);
  };
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < corners; ++i) {
    const int next = (i + 1) % corners, previous = (i + corners - 1) % corners;
    const Vec3 ahead = leaving(i, next, i), behind = leaving(i, previous, previous);
    const double lengths = ahead.norm() * behind.norm();
    smallest = std::min(smallest, lengths > 0.0 ? ahead.cross(behind).z() / lengths : 0.0);
  }
  return smallest;
}

}  // namespace berm
