#pragma once
/// Plain meshes of cells in the plane or in space: background grids and body meshes alike.

#include <array>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

enum class CellKind : unsigned char { tri3, quad4, tri6, quad8, tet4, hex8, tet10, hex20 };

/// Nodes of a cell of that kind, corners first, then mid-sides, in VTK's order (that of Gmsh but for the mid-sides of
/// tet10 and hex20); counter-clockwise in the plane.
constexpr int nodes_of(CellKind kind) {
  constexpr std::array<int, 8> n = {3, 4, 6, 8, 4, 8, 10, 20};
  return n[static_cast<int>(kind)];
}
constexpr int corners_of(CellKind kind) {
  constexpr std::array<int, 8> n = {3, 4, 3, 4, 4, 8, 4, 8};
  return n[static_cast<int>(kind)];
}
constexpr int dimension_of(CellKind kind) { return kind >= CellKind::tet4 ? 3 : 2; }
/// Triangles and tetrahedra.
constexpr bool is_simplex(CellKind kind) { return corners_of(kind) - dimension_of(kind) == 1; }
/// The linear cell with the same corners.
constexpr CellKind linear_kind(CellKind kind) {
  if (dimension_of(kind) == 2) return is_simplex(kind) ? CellKind::tri3 : CellKind::quad4;
  return is_simplex(kind) ? CellKind::tet4 : CellKind::hex8;
}

/// Corners of a face of a cell (in the plane: of an edge), seen from outside counter-clockwise (in the plane: the cell
/// to the left).
struct FaceCorners {
  int n;
  std::array<int, 4> corner;
};
/// The faces of a cell: 3, 4 (plane), 4, 6.
std::span<const FaceCorners> faces_of(CellKind kind);
constexpr int max_faces = 6;

/// The six tetrahedra of a cube by its corners in VTK order: from corner 0 along the axes in the order of a permutation to
/// corner 6 (Kuhn). Number = 2 * (longest axis) + (is the second axis the higher one of the other two?).
constexpr int kuhn_tetrahedra[6][4] = {{0, 1, 2, 6}, {0, 5, 1, 6}, {0, 2, 3, 6},
                                       {0, 3, 7, 6}, {0, 4, 5, 6}, {0, 7, 4, 6}};

/// The edges of a cell by its corners: 3, 4 (plane), 6, 12. Node corners_of(kind) + e of a quadratic cell is the
/// mid-side node of edge e.
std::span<const std::array<int, 2>> edges_of(CellKind kind);

struct Mesh {
  std::vector<Vec3> nodes;                              ///< coordinates [m]; z = 0 in the plane
  std::vector<CellKind> kinds;                          ///< one per cell
  std::vector<int> offsets = {0};                       ///< cell c has connectivity[offsets[c] .. offsets[c+1])
  std::vector<int> connectivity;                        ///< node numbers
  std::map<std::string, std::vector<int>> cell_groups;  ///< Gmsh physical surfaces (space: volumes): cells
  std::map<std::string, std::vector<int>> node_groups;  ///< Gmsh physical curves (space: surfaces): nodes

  int n_nodes() const { return static_cast<int>(nodes.size()); }
  int n_cells() const { return static_cast<int>(kinds.size()); }
  /// 2 or 3: all cells of a mesh have the same.
  int dimension() const { return kinds.empty() ? 2 : dimension_of(kinds[0]); }
  const int* cell(int c) const { return connectivity.data() + offsets[c]; }
  std::span<const int> nodes_of_cell(int c) const { return {cell(c), static_cast<std::size_t>(nodes_of(kinds[c]))}; }

  void add_cell(CellKind kind, const int* node_numbers) {
    kinds.push_back(kind);
    connectivity.insert(connectivity.end(), node_numbers, node_numbers + nodes_of(kind));
    offsets.push_back(static_cast<int>(connectivity.size()));
  }
};

/// Corner positions of a cell: at most 8.
struct Corners {
  int n = 0;
  std::array<Vec3, 8> x;
};
Corners corners(const Mesh& mesh, int c);

/// Area of the polygon of the cell's corners [m2], positive if counter-clockwise; volume of the (tri)linear cell [m3],
/// positive if its Jacobian is.
double cell_measure(const Mesh& mesh, int c);
/// Edge of the square or cube that a cell of that area or volume is a regular part of (half, whole, sixth) [m].
double edge_length(CellKind kind, double measure);
/// Mean of the corners.
Vec3 cell_centre(const Mesh& mesh, int c);

/// A face of a cell, numbered as in faces_of. Mid-side node of edge e of quadratic plane cells: corners_of(kind) + e.
struct CellFace {
  int cell;
  int local;
};
/// Corner positions of a face in the order of faces_of.
Corners face_corners(const Mesh& mesh, const CellFace& face);
/// Faces with one cell, ordered by cell.
std::vector<CellFace> boundary_faces(const Mesh& mesh);

/// For every cell and face the cell on the other side or -1: entry max_faces * cell + face. Throws InputError if a face
/// has more than two cells.
std::vector<int> cell_neighbours(const Mesh& mesh);

}  // namespace berm
