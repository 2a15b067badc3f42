#pragma once
/// The isoparametric map of an element and its inverse.

#include "fem/element.hpp"

namespace berm::fem {

/// dX/dxi; in the plane the third column is the unit vector along z.
Mat3 jacobian(const Mesh& mesh, int element, const ElementShape& shape);

/// Interpolates places of the nodes.
Vec3 place(const Mesh& mesh, int element, const ElementShape& shape);

/// Local coordinates of x in an element, or outside of it by its extended functions. False if there are none to be
/// found.
bool local_coordinates(const Mesh& mesh, int element, const Vec3& x, Vec3& xi);

/// How far x lies outside of an element, in cells: 0 inside, infinity if there is no telling.
double distance_outside(const Mesh& mesh, int element, const Vec3& x);

/// The mesh of straight-sided cells with the same corners.
Mesh corner_mesh(const Mesh& mesh);

}  // namespace berm::fem
