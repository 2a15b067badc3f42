#pragma once
/// Crack-band length of a cell (docs/theory/damage.md).

#include <cmath>
#include <numbers>

#include "case/case.hpp"
#include "mesh/mesh.hpp"

namespace berm {

/// sqrt_area: sqrt(A) of a quad, sqrt(2 A) of a triangle (half a quad); equal_circle: diameter of the circle of equal
/// area, sqrt(4 A / pi); fixed: the length given. [m]
inline double crack_band_length(const Material& material, const Mesh& mesh, int cell) {
  const double area = cell_area(mesh, cell);
  switch (material.crack_band) {
    case Material::CrackBand::sqrt_area:
      return std::sqrt(corners_of(mesh.kinds[cell]) == 3 ? 2.0 * area : area);
    case Material::CrackBand::equal_circle:
      return std::sqrt(4.0 * area / std::numbers::pi);
    case Material::CrackBand::fixed:
      break;
  }
  return material.crack_band_length;
}

}  // namespace berm
