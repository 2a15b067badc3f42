#include "mesh/gmsh.hpp"

#include <gmsh.h>

#include "mesh/gmsh_model.hpp"
#include "mesh/msh_check.hpp"

namespace berm {

Mesh read_msh(const std::string& path) {
  check_msh(path);
  return with_gmsh(path, [&] {
    gmsh::open(path);
    return current_gmsh_mesh(path);
  });
}

}  // namespace berm
