#pragma once
/// Closed surfaces made of triangles: the boundaries of solid bodies.

#include <array>
#include <string>
#include <vector>

#include "mesh/solid_shape.hpp"
#include "base/tensor.hpp"

namespace berm {

struct TriangleSurface {
  std::vector<Vec3> vertices;                 ///< coordinates [m]
  std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise seen from outside
  std::vector<Vec3> normals;  ///< one a triangle: outward unit normal of the true surface at its centre, or its own

  int n_triangles() const { return static_cast<int>(triangles.size()); }
  const Vec3& corner(int triangle, int i) const { return vertices[triangles[triangle][i]]; }
};

/// Reads a closed surface from an STL file (ASCII or binary); coinciding vertices become one. A surface that is inside
/// out is turned. Throws InputError that names the file and what is wrong (missing, not an STL file, truncated, open,
/// torn, twisted, flat triangles, overlapping parts) and where.
TriangleSurface read_stl(const std::string& path);
/// The same, moved as the shape says.
TriangleSurface read_stl(const SurfaceFile& file);

/// Enclosed volume [m3].
double volume(const TriangleSurface& surface);
/// Corner coordinates of the smallest box around the surface [m].
Vec3 low_corner(const TriangleSurface& surface);
Vec3 high_corner(const TriangleSurface& surface);
/// Outward normal of a triangle times its area [m2].
Vec3 area_vector(const TriangleSurface& surface, int triangle);

/// The same surface with no edge longer than `longest`: edges are halved, both neighbours alike, so it stays closed.
/// Throws InputError unless `longest` is positive.
TriangleSurface split(const TriangleSurface& surface, double longest);

/// Turns the triangles so that the surface encloses its body, cavities included; normals are turned along. For surfaces
/// whose triangles have any orientation.
void turn_outward(TriangleSurface& surface);

/// Throws InputError that begins with `subject` unless the surface is closed, consistently oriented, encloses a
/// positive volume, and its separate parts either lie apart or are cavities.
void check_closed(const TriangleSurface& surface, const std::string& subject);
/// Throws InputError that begins with `subject` if an edge runs through a triangle.
void refuse_crossings(const TriangleSurface& surface, const std::string& subject);

}  // namespace berm
