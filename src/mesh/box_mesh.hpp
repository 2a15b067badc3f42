#pragma once
/// Mapped meshes of shapes made of boxes, and of discs.

#include "mesh/gmsh.hpp"

namespace berm {

/// Does the shape consist of axis-parallel boxes only?
bool only_boxes(const PlaneShape& shape);

/// Shapes that `structured` meshes exist for: boxes and discs.
bool has_structured_mesh(const PlaneShape& shape);

/// n x n quads of a square on the disc, x = u sqrt(1 - v^2/2), y = v sqrt(1 - u^2/2), n = round(sqrt(area)/size); symmetric
/// about both axes. Triangles: quads halved with alternating diagonals.
Mesh mesh_disc(const Disc& disc, const BodyMeshOptions& options);

/// Lines at all sides of all boxes; round(length/size) cells (at least one) between two lines; cells outside of the
/// shape are left out. Triangles: quads halved with alternating diagonals. Throws InputError if the shape is empty.
Mesh mesh_boxes(const PlaneShape& shape, const BodyMeshOptions& options);

}  // namespace berm
