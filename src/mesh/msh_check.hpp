#pragma once
/// A look at the text of a .msh file before Gmsh reads it.

#include <string>

namespace berm {

/// What read_msh can read, for messages.
constexpr const char* supported_elements =
    "triangles of 3 and 6 nodes, quads of 4 and 8, tetrahedra of 4 and 10, hexahedra of 8 and 20 are; Gmsh saves them "
    "with Mesh.SecondOrderIncomplete = 1";

/// Gmsh 4.8 trusts the counts and node numbers of a file and crashes if they are wrong. Throws InputError with file and
/// line for text files (2.2 and 4.1) whose nodes or elements are incomplete, out of step with their counts, of an
/// unsupported type, or refer to nodes that do not exist. Binary files likewise, with the byte in the place of the line.
void check_msh(const std::string& path);
/// Of a file that is known to be binary; old: version 2.2.
void check_binary_msh(const std::string& path, bool old);

}  // namespace berm
