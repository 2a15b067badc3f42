#pragma once
/// A body cut once into coarse boxes, for questions about places.

#include <vector>

#include "mesh/convex_cell.hpp"
#include "mesh/surface.hpp"
#include "mesh/triangle_soup.hpp"

namespace berm {

class SolidBins {
public:
  explicit SolidBins(const TriangleSurface& surface);

  /// Is x in the body or within rounding of its surface?
  bool contains(const Vec3& x) const;
  /// Volume of the body inside the cell, and its first moment about `origin`. The cell must be convex.
  SolidMoments clip(const ConvexCell& cell, const Vec3& origin) const;

private:
  enum State : signed char { outside, inside, cut_through };
  int index(int d, double x) const;
  int number(int i, int j, int k) const { return (k * count_[1] + j) * count_[0] + i; }
  Soup box(int i, int j, int k) const;

  GridPlanes planes_;
  int count_[3];
  std::vector<State> states_;
  std::vector<int> soup_of_;  ///< of bins that are cut through
  std::vector<Soup> soups_;
  double tolerance_;
};

/// All triangles of the surface.
Soup soup_of(const TriangleSurface& surface);

}  // namespace berm
