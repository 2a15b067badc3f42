#pragma once
/// Models at map coordinates: 5e6 m from the origin a number has a billionth of a metre left.

#include "case/case.hpp"

namespace berm {

/// Where a case lies far from the origin for its cells, all its places count from the corner of its grid (or of its first
/// body) from now on, and Case::origin says where that is. Expressions of the place still get the user's coordinates.
void count_from_the_grid(Case& c);

}  // namespace berm
