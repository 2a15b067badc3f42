#include <gtest/gtest.h>

#include "mesh/grid.hpp"
#include "shape/linear.hpp"

namespace berm {
namespace {

/// Rounding of coordinates that are large against the cells must not look like a map that cannot be inverted.
TEST(LinearShapeFarAway, SmallCellsFarFromTheOrigin) {
  StructuredGrid spec;
  spec.kind = GridKind::hexahedra;
  spec.origin = Vec3(7.0, 3.0, 11.0);
  spec.cell_size = Vec3::Constant(1e-3);
  spec.nx = spec.ny = spec.nz = 7;
  const Grid grid = make_structured_grid(spec);
  Shape8 shape{};
  for (int c = 0; c < grid.mesh.n_cells(); ++c)
    for (const Vec3& at : {Vec3(0.211, 0.789, 0.211), Vec3(1.0 / 3.0, 0.1, 0.9), Vec3(0.0, 1.0, 0.5)}) {
      const Vec3 x = grid.mesh.nodes[grid.mesh.cell(c)[0]] + 1e-3 * at;
      ASSERT_TRUE(linear_shape(grid.mesh, c, x, shape));
      EXPECT_NEAR(shape.N[6], at.prod(), 1e-10);
    }
}

}  // namespace
}  // namespace berm
