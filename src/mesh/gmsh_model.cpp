#include "mesh/gmsh_model.hpp"

#include <fmt/format.h>
#include <gmsh.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <unordered_map>
#include <unordered_set>

#include "base/error.hpp"
#include "base/sort_unique.hpp"
#include "mesh/msh_check.hpp"

namespace berm {

namespace {

constexpr double least_corner_jacobian = 1e-6;  ///< cells with less are degenerate: flat, or inverted at a corner

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
  static const std::map<int, CellKind> kinds = {{2, CellKind::tri3},   {3, CellKind::quad4}, {9, CellKind::tri6},
                                                {16, CellKind::quad8}, {4, CellKind::tet4},  {5, CellKind::hex8},
                                                {11, CellKind::tet10}, {17, CellKind::hex20}};
  const auto found = kinds.find(gmsh_type);
  return found == kinds.end() ? std::nullopt : std::optional(found->second);
}

/// Gmsh's place of node i of a cell: it numbers the edges of tet10 and hex20 in an order of its own.
int gmsh_place(CellKind kind, int i) {
  constexpr int tet10[] = {0, 1, 2, 3, 4, 5, 6, 7, 9, 8};
  constexpr int hex20[] = {0, 1, 2, 3, 4, 5, 6, 7, 8, 11, 13, 9, 16, 18, 19, 17, 10, 12, 14, 15};
  if (kind == CellKind::tet10) return tet10[i];
  return kind == CellKind::hex20 ? hex20[i] : i;
}

std::string name_of_type(int gmsh_type) {
  std::string name;
  int dim = 0, order = 0, n_nodes = 0, n_primary = 0;
  std::vector<double> local;
  gmsh::model::mesh::getElementProperties(gmsh_type, name, dim, order, n_nodes, local, n_primary);
  return name;
}

int edge_between(CellKind kind, int a, int b) {
  const auto edges = edges_of(kind);
  const auto joins = [&](const auto& e) { return (e[0] == a && e[1] == b) || (e[0] == b && e[1] == a); };
  return static_cast<int>(std::find_if(edges.begin(), edges.end(), joins) - edges.begin());
}

/// Mirrors the order of the nodes of a cell, starting at the same corner: the Jacobian changes its sign.
std::vector<int> mirrored(CellKind kind, std::span<const int> nodes) {
  constexpr int tetrahedron[] = {0, 2, 1, 3}, hexahedron[] = {0, 3, 2, 1, 4, 7, 6, 5};
  const int n = corners_of(kind);
  const auto corner = [&](int i) {
    if (dimension_of(kind) == 2) return (n - i) % n;
    return is_simplex(kind) ? tetrahedron[i] : hexahedron[i];
  };
  std::vector<int> out;
  for (int i = 0; i < n; ++i) out.push_back(nodes[corner(i)]);
  if (nodes_of(kind) == n) return out;
  for (const auto& [a, b] : edges_of(kind)) out.push_back(nodes[n + edge_between(kind, corner(a), corner(b))]);
  return out;
}

/// The corners that the edges of corner i lead to, right-handed; in the plane two.
using CornerEdges = std::array<int, 3>;
CornerEdges edges_at(CellKind kind, int i) {
  constexpr CornerEdges tetrahedron[] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};
  const int n = dimension_of(kind) == 2 ? corners_of(kind) : 4;
  if (dimension_of(kind) == 3 && is_simplex(kind)) return tetrahedron[i];
  const int level = i - i % n, next = level + (i + 1) % n, previous = level + (i + n - 1) % n;
  return i < n ? CornerEdges{next, previous, i + n} : CornerEdges{previous, next, i - n};
}

class Extraction {
public:
  explicit Extraction(const std::string& subject) : subject_(subject) {}

  Mesh run() {
    read_nodes();
    read_cells(3);
    if (mesh_.kinds.empty()) read_cells(2);
    if (mesh_.kinds.empty())
      fail(
          "has no plane cells (triangles or quads) and no volume cells (tetrahedra or hexahedra); save the surface or "
          "volume elements too");
    if (mesh_.dimension() == 3) check_surfaces();
    drop_unused_nodes();
    orient();
    read_groups();
    return std::move(mesh_);
  }

private:
  [[noreturn]] void fail(const std::string& what) const { throw InputError(subject_ + ": " + what); }

  struct KeyHash {
    std::size_t operator()(const std::vector<int>& key) const {
      std::size_t hash = 0;
      for (int k : key) hash = hash * 1000003u + static_cast<std::size_t>(k);
      return hash;
    }
  };

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

  /// Calls visit(kind, tags of its nodes in our order, entity) for every element of that dimension.
  template <class Visit>
  void for_each_element(int dimension, Visit visit) const {
    gmsh::vectorpair entities;
    gmsh::model::getEntities(entities, dimension);
    for (const auto& entity : entities) {
      std::vector<int> types;
      std::vector<std::vector<std::size_t>> tags, nodes;
      gmsh::model::mesh::getElements(types, tags, nodes, dimension, entity.second);
      for (std::size_t t = 0; t < types.size(); ++t) {
        const std::optional<CellKind> kind = kind_of(types[t]);
        if (!kind)
          fail(fmt::format("element type \"{}\" is not supported ({})", name_of_type(types[t]), supported_elements));
        std::vector<std::size_t> cell(nodes_of(*kind));
        for (std::size_t e = 0; e < tags[t].size(); ++e) {
          for (std::size_t i = 0; i < cell.size(); ++i)
            cell[i] = nodes[t][e * cell.size() + gmsh_place(*kind, static_cast<int>(i))];
          visit(*kind, cell, entity.second);
        }
      }
    }
  }

  void read_cells(int dimension) {
    for_each_element(dimension, [this](CellKind kind, const std::vector<std::size_t>& tags, int entity) {
      add_cell(kind, tags, entity);
    });
  }

  /// Files of format 2.2 repeat a cell for every physical group that it is in.
  void add_cell(CellKind kind, const std::vector<std::size_t>& node_tags, int entity) {
    const std::vector<int> cell = numbers_of(node_tags);
    std::vector<int> key = cell;
    std::sort(key.begin(), key.end());
    if (std::adjacent_find(key.begin(), key.end()) != key.end())
      fail(fmt::format("a cell uses node {} twice", tags_[order_[*std::adjacent_find(key.begin(), key.end())]]));
    const auto [place, is_new] = known_.emplace(std::move(key), mesh_.n_cells());
    if (is_new) mesh_.add_cell(kind, cell.data());
    cells_of_entity_[entity].push_back(place->second);
  }

  std::vector<int> numbers_of(const std::vector<std::size_t>& node_tags) const {
    std::vector<int> numbers;
    for (std::size_t tag : node_tags) {
      const auto found = number_.find(tag);
      if (found == number_.end()) fail(fmt::format("a cell uses node {}, which does not exist", tag));
      numbers.push_back(found->second);
    }
    return numbers;
  }

  /// In a mesh of volume cells the plane ones only mark faces.
  void check_surfaces() const {
    std::unordered_set<std::vector<int>, KeyHash> faces;
    for (int c = 0; c < mesh_.n_cells(); ++c)
      for (const FaceCorners& f : faces_of(mesh_.kinds[c])) {
        std::vector<int> key;
        for (int i = 0; i < f.n; ++i) key.push_back(mesh_.cell(c)[f.corner[i]]);
        std::sort(key.begin(), key.end());
        faces.insert(std::move(key));
      }
    for_each_element(2, [&](CellKind kind, const std::vector<std::size_t>& tags, int) {
      std::vector<int> key = numbers_of(tags);
      const Vec3& x = mesh_.nodes[key[0]];
      key.resize(corners_of(kind));
      std::sort(key.begin(), key.end());
      if (!faces.count(key))
        fail(
            fmt::format("plane and volume cells are mixed: the plane cell at ({:g}, {:g}, {:g}) is no face of a volume "
                        "cell (save the two in files of their own)",
                        x.x(), x.y(), x.z()));
    });
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
        const std::vector<int> nodes = mirrored(mesh_.kinds[c], mesh_.nodes_of_cell(c));
        std::copy(nodes.begin(), nodes.end(), mesh_.connectivity.begin() + mesh_.offsets[c]);
      }
      if (!(smallest_corner_jacobian(mesh_, c) > least_corner_jacobian)) {
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
      if (dim == mesh_.dimension() - 1) add_to(mesh_.node_groups[name], nodes_of_group(dim, tag));
      if (dim == mesh_.dimension()) add_to(mesh_.cell_groups[name], cells_of_group(dim, tag));
    }
  }

  static void add_to(std::vector<int>& group, std::vector<int> members) {
    group.insert(group.end(), members.begin(), members.end());
    sort_unique(group);
  }

  std::vector<int> nodes_of_group(int dim, int tag) const {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates;
    gmsh::model::mesh::getNodesForPhysicalGroup(dim, tag, tags, coordinates);
    std::vector<int> nodes;
    for (std::size_t t : tags) {
      const auto found = number_.find(t);
      if (found != number_.end() && found->second >= 0) nodes.push_back(found->second);
    }
    return nodes;
  }

  std::vector<int> cells_of_group(int dim, int tag) const {
    std::vector<int> entities, cells;
    gmsh::model::getEntitiesForPhysicalGroup(dim, tag, entities);
    for (int entity : entities) {
      const auto found = cells_of_entity_.find(entity);
      if (found != cells_of_entity_.end()) cells.insert(cells.end(), found->second.begin(), found->second.end());
    }
    return cells;
  }

  const std::string& subject_;
  Mesh mesh_;
  std::vector<std::size_t> tags_, order_;
  std::unordered_map<std::size_t, int> number_;  ///< by Gmsh tag; -1: dropped
  std::unordered_map<std::vector<int>, int, KeyHash> known_;
  std::map<int, std::vector<int>> cells_of_entity_;
};

}  // namespace

Mesh with_gmsh(const std::string& subject, const std::function<Mesh()>& work) {
  static Session session;
  const auto failure = [&](const std::string& message) {
    session.restart();
    return InputError(fmt::format("{}: {}", subject, message.find_first_not_of(" \t\n") == message.npos ? "Gmsh gave up without a message" : message));
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
  } catch (const std::bad_alloc&) {
    throw failure("there is no memory for it: its cells are too many, or a count in a file is wrong");
  } catch (const std::exception&) {  // in words of C++
    throw failure("Gmsh cannot read it: a count or a number in a file is wrong");
  }
}

Mesh current_gmsh_mesh(const std::string& subject) { return Extraction(subject).run(); }

double smallest_corner_jacobian(const Mesh& mesh, int c) {
  const CellKind kind = mesh.kinds[c];
  const int* nodes = mesh.cell(c);
  const bool curved = nodes_of(kind) > corners_of(kind);
  const auto at = [&](int i) -> const Vec3& { return mesh.nodes[nodes[i]]; };
  // Unit tangent with which the edge to corner `b` leaves corner `a`.
  const auto leaving = [&](int a, int b) {
    const int mid = corners_of(kind) + edge_between(kind, a, b);
    const Vec3 tangent = curved ? Vec3(4.0 * at(mid) - 3.0 * at(a) - at(b)) : Vec3(at(b) - at(a));
    const double length = tangent.norm();
    return length > 0.0 ? Vec3(tangent / length) : Vec3(Vec3::Zero());
  };
  double smallest = std::numeric_limits<double>::infinity();
  for (int i = 0; i < corners_of(kind); ++i) {
    const CornerEdges to = edges_at(kind, i);
    const Vec3 third = dimension_of(kind) == 2 ? Vec3(Vec3::UnitZ()) : leaving(i, to[2]);
    smallest = std::min(smallest, leaving(i, to[0]).cross(leaving(i, to[1])).dot(third));
  }
  return smallest;
}

}  // namespace berm
