#pragma once
/// The only place that sees Gmsh: reading .msh files and meshing bodies.

#include <string>

#include "mesh/mesh.hpp"
#include "mesh/plane_region.hpp"

namespace berm {

/// Reads a .msh file (2.2 or 4.1) of plane cells of kinds tri3, quad4, tri6, quad8. Cells are turned counter-clockwise.
/// Physical surfaces become cell_groups, physical curves node_groups. Throws InputError that names the file and what is
/// wrong (missing, not a mesh, no plane cells, unsupported element type, not in the plane z = 0, degenerate cell).
Mesh read_msh(const std::string& path);

enum class BodyMeshKind { quads, triangles, hexahedra, tetrahedra };

struct BodyMeshOptions {
  BodyMeshKind kind = BodyMeshKind::quads;
  double size = 0.0;        ///< edge length [m]
  int order = 1;            ///< 1: tri3/quad4, 2: tri6/quad8
  bool structured = false;  ///< boxes: transfinite round(length/size) cells per side; triangles: halved quads
};

/// Meshes a shape (box alone: structured on request; everything else: Gmsh's frontal algorithms, quads by full-quad
/// recombination).
Mesh mesh_shape(const PlaneShape& shape, const BodyMeshOptions& options);

}  // namespace berm
