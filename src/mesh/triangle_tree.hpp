#pragma once
/// The nearest triangle of a surface.

#include <vector>

#include "mesh/surface.hpp"

namespace berm {

/// Binary tree of boxes around triangles.
class TriangleTree {
public:
  /// The surface must outlive the tree.
  explicit TriangleTree(const TriangleSurface& surface);

  struct Hit {
    int triangle;
    Vec3 point;     ///< nearest point of the triangle
    bool interior;  ///< not on an edge or a corner
  };
  Hit nearest(const Vec3& x) const;

private:
  struct Node {
    Vec3 low, high;
    int first, count;  ///< count > 0: a leaf with these triangles of `order_`; else first: the left child
    int right;
  };
  int build(int first, int last);

  const TriangleSurface& surface_;
  std::vector<int> order_;
  std::vector<Node> nodes_;
};

}  // namespace berm
