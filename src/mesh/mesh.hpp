#pragma once
/// Plain 2D meshes: background grids and body meshes alike.

#include <array>
#include <map>
#include <string>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

enum class CellKind : unsigned char { tri3, quad4, tri6, quad8 };

/// Nodes of a cell of that kind, counter-clockwise, corners first, then mid-sides (Gmsh/VTK order).
constexpr int nodes_of(CellKind kind) {
  constexpr std::array<int, 4> n = {3, 4, 6, 8};
  return n[static_cast<int>(kind)];
}
constexpr int corners_of(CellKind kind) { return kind == CellKind::tri3 || kind == CellKind::tri6 ? 3 : 4; }

struct Mesh {
  std::vector<Vec2> nodes;                              ///< coordinates [m]
  std::vector<CellKind> kinds;                          ///< one per cell
  std::vector<int> offsets = {0};                       ///< cell c has connectivity[offsets[c] .. offsets[c+1])
  std::vector<int> connectivity;                        ///< node numbers
  std::map<std::string, std::vector<int>> cell_groups;  ///< Gmsh physical surfaces: cells
  std::map<std::string, std::vector<int>> node_groups;  ///< Gmsh physical curves: nodes

  int n_nodes() const { return static_cast<int>(nodes.size()); }
  int n_cells() const { return static_cast<int>(kinds.size()); }
  const int* cell(int c) const { return connectivity.data() + offsets[c]; }

  void add_cell(CellKind kind, const int* node_numbers) {
    kinds.push_back(kind);
    connectivity.insert(connectivity.end(), node_numbers, node_numbers + nodes_of(kind));
    offsets.push_back(static_cast<int>(connectivity.size()));
  }
};

/// Area of the polygon of the cell's corners [m2]; positive if counter-clockwise.
double cell_area(const Mesh& mesh, int c);

/// Boundary edges (edges with one cell) as {cell, local edge}; local edge e runs from corner e to corner e+1
/// (mid-side node of edge e of quadratic cells: corners_of(kind) + e). Ordered by cell.
struct Edge {
  int cell;
  int local;
};
std::vector<Edge> boundary_edges(const Mesh& mesh);

/// Interior edges: the two cells that share them, and the end nodes.
struct InteriorEdge {
  int cell_a, cell_b;
  int node_a, node_b;
};
std::vector<InteriorEdge> interior_edges(const Mesh& mesh);

}  // namespace berm
