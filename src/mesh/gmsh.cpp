#include "mesh/gmsh.hpp"

#include <gmsh.h>

#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "mesh/gmsh_model.hpp"

namespace berm {

namespace {

/// What can be told without Gmsh, whose own messages for these are poor.
void check_file(const std::string& path) {
  if (!std::filesystem::exists(path)) throw InputError(path + ": there is no such file");
  std::ifstream file(path);
  std::string line;
  if (!std::filesystem::is_regular_file(path) || !std::getline(file, line))
    throw InputError(path + ": cannot be read, or is empty");
  if (line.rfind("$MeshFormat", 0) != 0)
    throw InputError(path + ": is not a Gmsh mesh (it does not begin with $MeshFormat; export it as .msh 4.1 or 2.2)");
  std::string version;
  file >> version;
  if (version != "2.2" && version != "4.1")
    throw InputError(path + ": .msh version " + version + " is not supported (export it as 4.1 or 2.2)");
}

}  // namespace

Mesh read_msh(const std::string& path) {
  check_file(path);
  return with_gmsh(path, [&] {
    gmsh::open(path);
    return current_gmsh_mesh(path);
  });
}

}  // namespace berm
