#pragma once
#include "mesh/region.hpp"

namespace berm {

/// A box that holds the shape [m], of no height in the plane; from inf to -inf if it is empty. Throws InputError if its STL file is wrong.
SolidBox bounds_of(const Shape& shape);

}  // namespace berm
