#pragma once
/// The only place that sees Gmsh: reading .msh files and meshing bodies.

#include <string>

#include "mesh/mesh.hpp"
#include "mesh/region.hpp"

namespace berm {

/// Reads a .msh file (2.2 or 4.1). With volume cells (tet4, tet10, hex8, hex20) it is a mesh in space, whose plane
/// cells only mark faces; without, one of plane cells (tri3, quad4, tri6, quad8). Cells are turned so that their
/// Jacobians are positive. Physical surfaces (space: volumes) become cell_groups, physical curves (space: surfaces)
/// node_groups. Throws InputError that names the file and what is wrong (missing, not a mesh, no cells, unsupported
/// element type, plane and volume cells mixed, plane cells not in the plane z = 0, degenerate cell).
Mesh read_msh(const std::string& path);

enum class BodyMeshKind { quads, triangles, hexahedra, tetrahedra };

struct BodyMeshOptions {
  BodyMeshKind kind = BodyMeshKind::quads;
  double size = 0.0;        ///< edge length [m]
  int order = 1;            ///< 1: tri3, quad4, tet4, hex8; 2: tri6, quad8, tet10, hex20
  bool structured = false;  ///< mapped cells of about `size`, see box_mesh.hpp and solid_mesh.hpp
};

/// Meshes a shape. Structured: boxes, discs and cylinders. Otherwise by Gmsh: quads (by full-quad recombination) or
/// triangles in the plane, tetrahedra in space. Hexahedra are always structured. Throws InputError if kind and shape do
/// not go together.
Mesh mesh_shape(const Shape& shape, const BodyMeshOptions& options);

/// Shapes that `structured` meshes exist for: shapes made of boxes, a disc or cylinder alone.
bool has_structured_mesh(const Shape& shape);

}  // namespace berm
