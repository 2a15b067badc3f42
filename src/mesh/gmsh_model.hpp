#pragma once
/// Gmsh's global state behind two functions. For gmsh*.cpp only.

#include <functional>
#include <string>

#include "mesh/mesh.hpp"

namespace berm {

/// Starts Gmsh once (silent, one thread), runs `work` on an empty model and empties it again. Whatever Gmsh throws
/// becomes an InputError "<subject>: <Gmsh's message>".
Mesh with_gmsh(const std::string& subject, const std::function<Mesh()>& work);

/// The plane cells of the current model. Throws InputError that begins with `subject`.
Mesh current_gmsh_mesh(const std::string& subject);

/// Smallest cross product of the two sides that leave a corner, over the product of their lengths (the sine of the
/// corner; curved sides: of their tangents). Above 0: the Jacobian is positive at all corners.
double smallest_corner_sine(const Mesh& mesh, int c);

}  // namespace berm
