#pragma once
/// Mapped meshes of plane shapes made of boxes, and of discs.

#include <vector>

#include "mesh/gmsh.hpp"

namespace berm {

/// Does the shape consist of axis-parallel boxes only?
bool only_boxes(const PlaneShape& shape);

/// n x n quads of a square on the disc, x = u sqrt(1 - v^2/2), y = v sqrt(1 - u^2/2), n = round(sqrt(area)/size);
/// symmetric about both axes. Triangles: quads halved with alternating diagonals.
Mesh mesh_disc(const Disc& disc, const BodyMeshOptions& options);

/// Lines at all sides of all boxes; round(length/size) cells (at least one) between two lines; cells outside of the
/// shape are left out. Triangles: quads halved with alternating diagonals. Throws InputError if the shape is empty.
Mesh mesh_boxes(const PlaneShape& shape, const BodyMeshOptions& options);

/// Coordinates of the mesh lines between `low` and `high` [m]: every one of `breaks` in between, and between two of
/// them round(length/size) cells, at least one.
std::vector<double> mesh_lines(std::vector<double> breaks, double low, double high, double size);

/// The same cells with mid-side nodes half-way.
Mesh with_mid_sides(const Mesh& linear);

}  // namespace berm
