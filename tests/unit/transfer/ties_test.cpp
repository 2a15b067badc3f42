/// Functions of higher degree that reach across a gap between parts that lie apart.

#include "blocks.hpp"

namespace berm {
namespace {

/// Two columns of 4 cells in a grid of 12 x 10 cells (in space 4 deep), `gap` cells apart; `joined` below.
std::pair<long, Vec3> ties(Space space, int degree, double gap, bool joined) {
  StructuredGrid s;
  s.kind = space == Space::solid ? GridKind::hexahedra : GridKind::quads;
  s.cell_size = Vec3(h, h, h);
  s.nx = 12;
  s.ny = 10;
  s.nz = space == Space::solid ? 4 : 0;
  MpmDiscretisation mpm(make_structured_grid(s), space, 0.0, Formulation::updated_lagrangian, Comm{},
                        Volumetric::standard, ShapeChoice{degree});
  const auto add = [&](double x0, double x1, double y0, double y1) {
    const Vec3 low(x0 * h, y0 * h, h), high(x1 * h, y1 * h, 3.0 * h);
    const Shape shape = space == Space::solid ? Shape(SolidShape{SolidBox{low, high}})
                                              : Shape(PlaneShape{Box{in_plane(low), in_plane(high)}});
    mpm.add_body(0, "block", elastic(), seed_from_grid(Region(shape, h), mpm.grid(), {}, "block"), 1.0);
  };
  add(1.0, 5.0, 1.0, 9.0);
  add(5.0 + gap, 9.0 + gap, 1.0, 9.0);
  if (joined) add(5.0, 5.0 + gap, 1.0, 2.0);
  mpm.move_points(1.2);
  mpm.begin_step({});
  return mpm.ties_across_gaps();
}

TEST(Ties, AreFoundWhereASupportIsWiderThanTheGap) {
  for (const Space space : {Space::plane_strain, Space::solid})
    for (const int degree : {1, 2, 3})
      for (const int gap : {1, 2, 3}) {
        const bool expected = degree > gap;
        const auto [apart, at] = ties(space, degree, gap, false);
        EXPECT_EQ(apart > 0, expected) << degree << ' ' << gap;
        EXPECT_EQ(ties(space, degree, gap, true).first > 0, expected) << degree << ' ' << gap;  // a slit
        if (!expected) continue;
        EXPECT_GT(at.x(), 4.0 * h);
        EXPECT_LT(at.x(), (6.0 + gap) * h);
      }
}

TEST(Ties, AreNoneInOnePiece) {
  for (const int degree : {2, 3}) {
    EXPECT_EQ(ties(Space::plane_strain, degree, 0.0, false).first, 0);
    EXPECT_EQ(ties(Space::solid, degree, 0.0, false).first, 0);
  }
}

}  // namespace
}  // namespace berm
