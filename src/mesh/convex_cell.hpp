#pragma once
/// Convex polyhedra that bodies are cut with.

#include <array>
#include <vector>

#include "base/tensor.hpp"

namespace berm {

struct ConvexCell {
  std::vector<Vec3> vertices;           ///< coordinates [m]
  std::vector<std::vector<int>> faces;  ///< corners of plane faces, counter-clockwise seen from outside
};

/// From the corners of a hexahedron in VTK order (bottom counter-clockwise seen from above, then top), of positive
/// volume. Faces that are not plane become four triangles around the mean of their corners: neighbours agree, and the
/// volume is that of the trilinear cell. Such a cell need not be quite convex; SolidRegion::clip copes with that.
ConvexCell hexahedron_cell(const std::array<Vec3, 8>& corners);
/// From the corners of a tetrahedron in VTK order (positive volume).
ConvexCell tetrahedron_cell(const std::array<Vec3, 4>& corners);

}  // namespace berm
