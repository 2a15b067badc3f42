#pragma once
/// Mapped meshes of shapes made of boxes.

#include "mesh/gmsh.hpp"

namespace berm {

/// Does the shape consist of axis-parallel boxes only?
bool only_boxes(const Shape& shape);

/// Lines at all sides of all boxes; round(length/size) cells (at least one) between two lines; cells outside of the
/// shape are left out. Triangles: quads halved with alternating diagonals. Throws InputError if the shape is empty.
Mesh mesh_boxes(const Shape& shape, const BodyMeshOptions& options);

}  // namespace berm
