#pragma once
/// The surfaces of bodies in pieces that carry loads and contact.

#include <span>

#include "bc/surface.hpp"

namespace berm {

/// Surface points stand this many to a cell: enough for the ends of a loaded arc to count. In space each stands for an
/// area, and the faces of a body have many.
inline double surface_points_per_cell(const Case& c) { return c.dimension() == 3 ? 3.0 : 10.0; }

/// Every face of the boundary of a body's mesh in equal pieces no longer than `spacing`, at least two an edge.
void add_surface_of_mesh(const Case& c, int body, const Mesh& mesh, double spacing, std::vector<SurfacePoint>& out);
/// The boundary of a shape in pieces no longer than `spacing`.
void add_surface_of_shape(const Case& c, int body, const Region& region, double spacing,
                          std::vector<SurfacePoint>& out);
/// From places inside a body to its surface, at right angles; zero where it is farther than `reach`.
std::vector<Vec3> ways_to_surface(const std::vector<Vec3>& places, std::span<const SurfacePoint> surface, double reach);

}  // namespace berm
