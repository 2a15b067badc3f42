#pragma once
/// Crack-band length of a cell (docs/theory/damage.md).

#include <cmath>
#include <numbers>

#include "case/case.hpp"
#include "mesh/mesh.hpp"

namespace berm {

/// sqrt_area: edge of the square or cube that the cell is a part of: sqrt(A) of a quad, sqrt(2 A) of a triangle (half a
/// quad), cbrt(V) of a hexahedron, cbrt(6 V) of a tetrahedron (a sixth of a cube); equal_circle: diameter of the circle of
/// equal area, sqrt(4 A / pi), or of the sphere of equal volume, cbrt(6 V / pi); fixed: the length given. [m]
inline double crack_band_length(const Material& material, const Mesh& mesh, int cell) {
  const double measure = cell_measure(mesh, cell);
  const bool solid = mesh.dimension() == 3;
  switch (material.crack_band) {
    case Material::CrackBand::sqrt_area:
      return edge_length(mesh.kinds[cell], measure);
    case Material::CrackBand::equal_circle:
      return solid ? std::cbrt(6.0 * measure / std::numbers::pi) : std::sqrt(4.0 * measure / std::numbers::pi);
    case Material::CrackBand::fixed:
      break;
  }
  return material.crack_band_length;
}

}  // namespace berm
