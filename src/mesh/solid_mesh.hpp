#pragma once
/// Meshes of solid shapes.

#include "mesh/gmsh.hpp"

namespace berm {

/// Does the shape consist of axis-parallel boxes only?
bool only_boxes(const SolidShape& shape);

/// Planes at all sides of all boxes; round(length/size) cells (at least one) between two planes; cells outside of the
/// shape are left out. Tetrahedra: every cell in six, neighbours mirrored. Throws InputError if the shape is empty.
Mesh mesh_solid_boxes(const SolidShape& shape, const BodyMeshOptions& options);

/// The n x n cells of mesh_disc (tetrahedra: n is even) in round(length/size) layers along the axis. Mid-side nodes lie
/// where the map of the disc puts them: those of the curved face on the cylinder.
Mesh mesh_cylinder(const Cylinder& cylinder, const BodyMeshOptions& options);

/// Structured as above, or tetrahedra by Gmsh. Throws InputError if kind and shape do not go together.
Mesh mesh_solid_shape(const SolidShape& shape, const BodyMeshOptions& options);

}  // namespace berm
