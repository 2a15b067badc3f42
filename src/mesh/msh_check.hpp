#pragma once
/// A look at the text of a .msh file before Gmsh reads it.

#include <string>

namespace berm {

/// Gmsh 4.8 trusts the counts and node numbers of a file and crashes if they are wrong. Throws InputError with file and
/// line for text files (2.2 and 4.1) whose nodes or elements are incomplete, out of step with their counts, of an
/// unsupported type, or refer to nodes that do not exist. Binary files are only checked for their header.
void check_msh(const std::string& path);

}  // namespace berm
