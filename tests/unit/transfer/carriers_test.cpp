/// Surface points in cells without material.   [docs/theory/formulation.md, section 6]

#include "blocks.hpp"

namespace berm {
namespace {

/// The nearest cell with material carries it: resultant and moment of its force are kept, and no node is an unknown that
/// nothing holds.
TEST(Carriers, FunctionsOfTheNearestMaterialGoOn) {
  for (const Space space : {Space::plane_strain, Space::solid})
    for (const int degree : {1, 2}) {
      const GridKind kind = space == Space::solid ? GridKind::hexahedra : GridKind::quads;
      MpmDiscretisation mpm(grid_of(space, kind), space, 1e-3, Formulation::updated_lagrangian, Comm{}, Volumetric::standard,
                            ShapeChoice{degree});
      add_block(mpm, space, 0, elastic(), 0.0, 1.0);
      mpm.move_points(1.2);
      Anchor beside, beyond_the_corner, inside;
      beside.x = corner + h * Vec3(1.2, 0.4, space == Space::solid ? 0.5 : 0.0);
      beyond_the_corner.x = corner + h * Vec3(1.1, 1.15, space == Space::solid ? 1.05 : 0.0);
      inside.x = corner + h * Vec3(0.4, 0.6, space == Space::solid ? 0.5 : 0.0);
      const std::vector<Anchor*> all = {&beside, &beyond_the_corner, &inside};
      for (Anchor* a : all) {
        a->X = a->x;
        mpm.locate(*a);
      }
      mpm.begin_step(all);
      EXPECT_EQ(mpm.active_cells().size(), 1u);
      for (const Anchor* a : all) {
        double sum = 0.0;
        Vec3 place = Vec3::Zero();
        for (int k = 0; k < a->stencil->n; ++k) {
          sum += a->stencil->N[k];
          place += a->stencil->N[k] * mpm.nodes[a->stencil->node[k]];
        }
        EXPECT_NEAR(sum, 1.0, 1e-12);
        EXPECT_LT((place - a->x).norm(), 1e-12);
        EXPECT_EQ(a->block, 0);
      }
    }
}

}  // namespace
}  // namespace berm
