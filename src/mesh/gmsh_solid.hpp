#pragma once
/// Meshing of solid bodies: their surfaces and their interiors.

#include <vector>

#include "mesh/solid_shape.hpp"
#include "mesh/surface.hpp"

namespace berm {

/// The surface of the shape in triangles. Curved faces get edges of at most about `size` [m] and 60 chords a full
/// circle or more; bodies with plane faces only get the fewest triangles. Vertices of curved faces are moved by about
/// the height of the chords so that the enclosed volume is that of the true shape; they stay in plane faces. A surface
/// file is returned as it is. Throws InputError for wrong numbers, polygons that cross themselves and bodies with
/// nothing left.
TriangleSurface triangulate(const SolidShape& shape, double size);

/// Tetrahedra of a body.
struct SolidMesh {
  std::vector<Vec3> nodes;        ///< coordinates [m]
  int nodes_per_cell;             ///< 4 or 10
  std::vector<int> connectivity;  ///< VTK order, positive Jacobians
};

/// Meshes the shape with edges of about `size` [m]; order 1: 4 nodes a cell, order 2: 10 nodes, those of curved faces
/// on the true face. The same input gives the same mesh. Throws InputError as triangulate does.
SolidMesh mesh_solid(const SolidShape& shape, double size, int order);

}  // namespace berm
