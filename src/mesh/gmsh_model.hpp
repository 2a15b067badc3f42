#pragma once
/// Gmsh's global state behind two functions. For gmsh*.cpp only.

#include <functional>
#include <string>

#include "mesh/mesh.hpp"

namespace berm {

/// Starts Gmsh once (silent, one thread), runs `work` on an empty model and empties it again. Whatever Gmsh throws
/// becomes an InputError "<subject>: <Gmsh's message>".
Mesh with_gmsh(const std::string& subject, const std::function<Mesh()>& work);

/// The volume cells of the current model, or the plane cells if there are none. Throws InputError that begins with
/// `subject`.
Mesh current_gmsh_mesh(const std::string& subject);

/// Scaled Jacobian: smallest determinant of the unit tangents of the edges that leave a corner (plane: the sine of the
/// corner), 1 for squares and cubes. Above 0: the Jacobian is positive at all corners.
double smallest_corner_jacobian(const Mesh& mesh, int c);

}  // namespace berm
