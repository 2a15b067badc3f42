/// What is seen before a run to be wrong, with its place, and that remedies are accepted. [docs/checks.md]

#include <fmt/format.h>

#include <algorithm>

#include "base/error.hpp"
#include "driver.hpp"
#include "sim/preflight.hpp"

namespace berm::verify {
namespace {

const std::string material = R"(
[material.m]
law = "linear_elastic"
density = 2400.0
youngs_modulus = 30e9
poisson_ratio = 0.2
[steps]
count = 1
)";

const std::string grid = "grid = { origin = [-0.2, -0.2], cell_size = 0.1, cells = [24, 24] }\n";
const std::string space_grid =
    "model.dimension = 3\ngrid = { kind = \"hexahedra\", origin = [-0.2, -0.2, -0.2], cell_size = 0.1, cells = [14, 14, 14] }\n";
const std::string base = "[boundary.base]\nwhere.box = { max = [9.0, 1e-6] }\nux = 0.0\nuy = 0.0\n";

std::string body(const std::string& name, const std::string& shape) {
  return fmt::format("[body.{}]\nmaterial = \"m\"\nshape = {{ {} }}\nmesh = {{ kind = \"quads\", size = 0.1 }}\n", name, shape);
}
std::string box(double x0, double y0, double x1, double y1) {
  return fmt::format("box = {{ min = [{}, {}], max = [{}, {}] }}", x0, y0, x1, y1);
}

/// What building the case says; "" if it can be built.
std::string complaint(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    refuse_free_bodies(*build_world(case_of(text, overrides)));
    return "";
  } catch (const InputError& error) {
    return error.what();
  }
}

void expect_words(const std::string& text, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(text.find(word), std::string::npos) << "no \"" << word << "\" in: " << text;
}

bool warns(const World& w, const std::string& word) {
  for (const std::string& text : w.spec.warnings)
    if (text.find(word) != std::string::npos) return true;
  for (const std::string& text : w.warnings)
    if (text.find(word) != std::string::npos) return true;
  return false;
}

// Gaps.

const std::string two_blocks = grid + material + body("a", box(0, 0, 0.5, 0.5)) + body("b", box(0.55, 0, 1, 0.5)) + base;

TEST(Preflight, BodiesThatTheGridWouldGlue) {
  expect_words(complaint(two_blocks), {"gap of 0.05 m between bodies \"a\" and \"b\"", "(0.525, ", "[contact.NAME]", "allow_glued"});
  EXPECT_EQ(complaint(two_blocks, {"body.b.shape.box.min=[0.7,0.0]", "body.b.shape.box.max=[1.2,0.5]"}), "");  // two whole cells
  EXPECT_EQ(complaint(two_blocks, {"contact.c={body=\"a\",other=\"b\",kind=\"frictionless\"}"}), "");
  const auto w = build_world(case_of(two_blocks, {"model.allow_glued=true"}));
  EXPECT_TRUE(warns(*w, "gap of 0.05 m"));
  EXPECT_FALSE(warns(*w, "allow_glued"));
}

/// Plate with a slit from its left side, as wide as a cell; offset: of the slit, in cells.
std::string slit(double width, double offset, bool solid) {
  const double y0 = 0.4 + 0.1 * offset, y1 = y0 + 0.1 * width;
  const std::string shape =
      solid ? fmt::format("difference = [ {{ box = {{ min = [0, 0, 0], max = [0.8, 1, 0.2] }} }}, {{ box = {{ min = [-1, {}, -1], max = [0.6, {}, 1] }} }} ]", y0, y1)
            : fmt::format("difference = [ {{ {} }}, {{ {} }} ]", box(0, 0, 1, 1), box(-1, y0, 0.6, y1));
  return (solid ? space_grid : grid) + material + fmt::format("[body.a]\nmaterial = \"m\"\nshape.{}\n", shape) +
         (solid ? "[boundary.base]\nwhere.box = { max = [9.0, 1e-6, 9.0] }\nux = 0.0\nuy = 0.0\nuz = 0.0\n" : base);
}

/// Parts are apart where as many whole cells lie between them as the functions have a degree.
TEST(Preflight, SlitsThatTheGridDoesNotSee) {
  for (const bool solid : {false, true})
    for (const auto& [functions, degree] : {std::pair{"linear", 1}, {"b2gimp", 2}, {"cpgimp", 1}, {"cpdi", 1}, {"quadratic_bspline", 2}, {"cubic_bspline", 3}}) {
      if (solid && functions != std::string("linear") && degree != 2) continue;
      for (const double width : {0.4, 1.0, 2.0, 3.0})
        for (const double offset : {0.0, 0.3, 0.5}) {
          if (solid && (width == 0.4 || width == 3.0 || offset == 0.3)) continue;
          const double whole = offset == 0.0 ? std::floor(width) : std::floor(width + offset) - 1.0;
          const std::string text = complaint(slit(width, offset, solid), {fmt::format("grid.shape_functions=\"{}\"", functions)});
          EXPECT_EQ(text.empty(), whole >= degree) << functions << ' ' << width << ' ' << offset << ' ' << solid << ": " << text;
        }
    }
}

TEST(Preflight, NoGapWhereThereIsNone) {
  EXPECT_EQ(complaint(grid + material + body("a", "polygon = [[0, 0], [1, 0], [1, 1], [0.65, 1], [0.5, 0.75], [0.35, 1], [0, 1]]") + base), "");  // 60 degrees
  EXPECT_EQ(complaint(grid + material + body("a", "polygon = [[0, 0], [1, 0], [1, 0.45], [0.45, 0.45], [0.45, 1], [0, 1]]") + base), "");
  EXPECT_EQ(complaint(grid + material + body("a", "difference = [ { " + box(0, 0, 1, 1) + " }, { disc = { centre = [0.5, 0.5], radius = 0.25 } } ]") +
                      body("b", "disc = { centre = [0.5, 0.5], radius = 0.25 }") + base),
            "");
  EXPECT_EQ(complaint(grid + material + body("a", box(0, 0, 1, 0.5)) + body("b", box(0.2, 0.5, 0.7, 0.8)) + base), "");
}

TEST(Preflight, BodiesThatHangOnNodesBesideThem) {
  const std::string text = grid + "[steps]\nanalysis = \"dynamic\"\n" + material.substr(0, material.find("[steps]")) + body("a", box(0.04, 0, 0.54, 0.5)) +
                           "[boundary.w]\nwhere.box = { max = [1e-6, 9.0] }\nux = 0.0\nuy = 0.0\n";
  expect_words(complaint(text), {"[boundary.w]", "0.04 m beside body \"a\"", "[boundary.w] body = \"a\"", "allow_glued"});
  EXPECT_EQ(complaint(text, {"model.allow_glued=true"}), "");
  EXPECT_EQ(complaint(text, {"boundary.w.body=\"a\"", "boundary.w.where.box.max=[0.041,9.0]"}), "");
  EXPECT_EQ(complaint(text, {"body.a.shape.box.min=[0.0,0.0]", "body.a.shape.box.max=[0.5,0.5]"}), "");
  EXPECT_EQ(complaint(text, {"body.a.shape.box.min=[0.1,0.0]", "body.a.shape.box.max=[0.6,0.5]"}), "");  // a cell away
  EXPECT_EQ(complaint(text, {"boundary.w.where.box.max=[0.11,9.0]"}), "");                                  // nodes inside
}

/// What has the nodes in common with a body that touches a support hangs on that body.
TEST(Preflight, LayersAndInclusionsAreCarried) {
  EXPECT_EQ(complaint(grid + material + body("a", box(0, 0, 1, 0.05)) + body("b", box(0, 0.05, 1, 1)) + base), "");
  const std::string host = body("a", "difference = [ { " + box(0, 0, 1, 1) + " }, { disc = { centre = [0.5, 0.07], radius = 0.04 } } ]") +
                           body("b", "disc = { centre = [0.5, 0.07], radius = 0.04 }");
  EXPECT_EQ(complaint(grid + material + host + base), "");
  EXPECT_EQ(complaint(grid + material + host + base, {"grid.shape_functions=\"cubic_bspline\""}), "");
  // Another body that touches far away carries nothing.
  const std::string beside = "[boundary.w]\nwhere.box = { max = [1e-6, 9.0] }\nux = 0.0\nuy = 0.0\n";
  expect_words(complaint(grid + material + body("a", box(0, 0, 0.5, 0.5)) + body("b", box(0.04, 1, 0.54, 1.5)) + beside), {"beside body \"b\""});
}

/// At the edge of a joint the sides of two bodies meet as those of a notch do.
TEST(Preflight, JointsThatOpen) {
  EXPECT_EQ(complaint(grid + material + body("a", box(0, 0, 1, 0.5)) + body("b", "polygon = [[0.3, 0.5], [0.7, 0.5], [0.9, 0.7], [0.1, 0.7]]") + base), "");
}

/// A body of another layer in a slit does not keep its sides apart.
TEST(Preflight, SlitFilledByABodyInContact) {
  const std::string text = grid + material +
                           body("a", "difference = [ { " + box(0, 0, 1, 1) + " }, { " + box(-1, 0.42, 0.6, 0.47) + " } ]") +
                           body("b", box(0, 0.42, 0.6, 0.47)) + base;
  EXPECT_EQ(complaint(text), "");  // one material, joined
  expect_words(complaint(text, {"contact.c={body=\"a\",other=\"b\",kind=\"frictionless\"}"}), {"gap of 0.05 m in body \"a\""});
}

TEST(Preflight, MotionsThatBeginWithAJump) {
  const std::string text = grid + material.substr(0, material.find("[steps]")) + body("a", box(0, 0, 1, 1)) +
                           "[steps]\nanalysis = \"dynamic\"\n[boundary.b]\nwhere.box = { max = [9.0, 1e-6] }\nux = ";
  expect_words(complaint(text + "\"1e-3*(1 + 0*x)*cos(50*t)\"\n"), {"[boundary.b]", "0.001 at ("});
  EXPECT_EQ(complaint(text + "\"1e-3*x*sin(50*t)\"\n"), "");
  EXPECT_EQ(complaint(text + "\"1e-3*sin(2*pi*5*t + pi)\"\n"), "");  // rounding is no jump
}

TEST(Preflight, HeldNodesInsideABody) {
  for (const char* where : {"min = [0.49, 0.49], max = [0.51, 0.51]", "min = [0.1, 0.49], max = [0.9, 0.51]"})
    EXPECT_EQ(complaint(grid + material + body("a", box(0, 0, 1, 1)) + fmt::format("[boundary.i]\nwhere.box = {{ {} }}\nux = 0.0\nuy = 0.0\n", where) + base), "");
}

/// Nodes that a boundary moves stay in their places of the grid: 28 % of the force of a block squeezed by 10 % was missing.
TEST(Preflight, BodiesThatLeaveMovedNodes) {
  const std::string text = grid + material + body("a", box(0, 0, 1, 1)) + base + "[boundary.top]\nwhere.box = { min = [-9.0, 0.999], max = [9.0, 1.001] }\nuy = ";
  const auto told = [&](const std::string& motion, const std::vector<std::string>& overrides = {}) {
    return warns(*build_world(case_of(text + motion, overrides)), "the body leaves them");
  };
  EXPECT_TRUE(told("\"-0.1*t\"\n"));
  EXPECT_FALSE(told("\"-0.005*t\"\n"));
  EXPECT_FALSE(told("0.0\nux = 0.1\n"));  // sheared: it slides along them
  EXPECT_FALSE(told("\"-0.1*t\"\n", {"model.formulation=total_lagrangian"}));
  EXPECT_FALSE(told("\"-0.1*t\"\n", {"model.kinematics=small"}));
  EXPECT_FALSE(told("\"-0.1*t\"\n", {"boundary.top.body=\"a\""}));
}

TEST(Preflight, BodiesOnEachOtherWithoutFriction) {
  const std::string text = grid + material + body("a", box(0, 0, 1, 0.5)) + body("b", box(0, 0.5, 1, 1)) + base +
                           "[contact.c]\nbody = \"b\"\nother = \"a\"\nkind = \"frictionless\"\n";
  expect_words(complaint(text), {"body \"b\", near (0.5, 0.75), can move along x: nothing"});
  EXPECT_EQ(complaint(text + "[pin.p]\nbody = \"b\"\nat = [0.5, 0.9]\nfix = \"x\"\n"), "");
  EXPECT_EQ(complaint(text, {"contact.c={body=\"b\",other=\"a\",kind=\"friction\",friction=0.3}"}), "");
}

/// Supports of later stages hold nothing yet, and nobody asks them to.
TEST(Preflight, SupportsOfLaterStages) {
  const std::string text = grid + material.substr(0, material.find("[steps]")) + body("a", box(0, 0, 1, 1)) + base +
                           "[stage.one]\ncount = 1\nanalysis = \"quasi_static\"\n[stage.two]\ncount = 1\nanalysis = \"quasi_static\"\n"
                           "[boundary.top]\nwhere.box = { min = [-9.0, 0.999], max = [9.0, 1.001] }\nuy = 0.0\nstages = [\"two\"]\n";
  EXPECT_FALSE(warns(*build_world(case_of(text)), "holds nothing"));
}

// Places that are filled twice.

TEST(Preflight, BodiesInOnePlace) {
  for (const char* method : {"mpm", "fem"}) {
    const std::string text = fmt::format("method = \"{}\"\n", method) + grid + material + body("a", box(0, 0, 1, 1)) + body("b", box(0, 0, 1, 1)) + base;
    expect_words(complaint(text), {"bodies \"a\" and \"b\" overlap: 1 m2", "shape.difference"});
    expect_words(complaint(text, {"body.b.shape.box.min=[0.5,0.5]", "body.b.shape.box.max=[1.5,1.5]"}), {"overlap: 0.25"});
    EXPECT_EQ(complaint(text, {"body.b.shape.box.min=[0.0,1.0]", "body.b.shape.box.max=[1.0,2.0]"}), "");
  }
}

TEST(Preflight, MaterialInsideRigidBodies) {
  const std::string text = grid + material + body("a", box(0, 0, 1, 1)) + base +
                           "[body.r]\nrigid = true\nshape." + box(0.2, 0.8, 0.8, 1.4) + "\n[contact.c]\nbody = \"a\"\nrigid = \"r\"\nkind = \"frictionless\"\n";
  expect_words(complaint(text), {"[contact.c]", "0.12 m2 of body \"a\"", "rigid body \"r\"", "0.2 m deep"});
  EXPECT_EQ(complaint(text, {"body.r.shape.box.min=[0.2,1.0]"}), "");
  // Wished into its place, without a hole for it.
  expect_words(complaint(text, {"body.r.shape.box.min=[0.3,0.3]", "body.r.shape.box.max=[0.7,0.7]"}), {"rigid body \"r\""});
}

// Supports.

TEST(Preflight, BodiesThatNothingHolds) {
  const std::string free_body = grid + material + body("a", box(0, 0, 1, 1));
  for (const std::string method : {"mpm", "fem"}) {
    const auto text = [&](const std::string& rest) { return complaint("method = \"" + method + "\"\n" + free_body + rest); };
    expect_words(text(""), {"body \"a\", near (0.5, 0.5), can move along x, y and turn: nothing holds it", "[boundary.NAME]", "analysis = \"dynamic\""});
    expect_words(text("[boundary.t]\nwhere.box = { min = [-1.0, 0.9999] }\nuy = 0.001\n"), {"can move along x: nothing"});
    expect_words(text("[pin.p]\nbody = \"a\"\nat = [0.25, 0.5]\nfix = \"xy\"\n"), {"can turn about (0.25, 0.5): nothing"});
    EXPECT_EQ(text("[pin.p]\nbody = \"a\"\nat = [0.25, 0.5]\nfix = \"xy\"\n[pin.q]\nbody = \"a\"\nat = [0.75, 0.5]\nfix = \"y\"\n"), "");
    expect_words(text(base + body("b", box(1.4, 0.5, 1.9, 0.9))), {"body \"b\", near (1.65, 0.7), can move along x, y and turn"});
    EXPECT_EQ(text(base + body("b", box(0, 1, 1, 1.5))), "");  // stands on the first
    EXPECT_EQ(text("[boundary.l]\nbody = \"a\"\nwhere.box = { max = [1e-6, 9.0] }\nux = 0.0\nuy = 0.0\n"), "");
    const std::string floor = "[body.f]\nrigid = true\nshape." + box(-0.1, -0.2, 1.1, 0.0) + "\n[contact.c]\nbody = \"a\"\nrigid = \"f\"\n";
    expect_words(text(floor + "kind = \"frictionless\"\n"), {"can move along x: nothing"});
    EXPECT_EQ(text(floor + "kind = \"friction\"\nfriction = 0.3\n"), "");
  }
  EXPECT_EQ(complaint(free_body, {"steps.analysis=dynamic"}), "");
}

TEST(Preflight, BodiesThatNothingHoldsInSpaceAndAroundAnAxis) {
  const std::string cube = space_grid + material + "[body.a]\nmaterial = \"m\"\nshape.box = { min = [0, 0, 0], max = [1, 1, 1] }\n";
  expect_words(complaint(cube), {"can move along x, y, z and turn"});
  expect_words(complaint(cube + "[boundary.b]\nwhere.box = { max = [9.0, 9.0, 1e-6] }\nuz = 0.0\n"), {"can move along x, y and turn"});
  EXPECT_EQ(complaint(cube + "[boundary.b]\nwhere.box = { max = [9.0, 9.0, 1e-6] }\nux = 0.0\nuy = 0.0\nuz = 0.0\n"), "");
  const std::string ring = "model.plane = \"axisymmetric\"\ngrid = { origin = [0.0, 0.0], cell_size = 0.1, cells = [12, 12] }\n" + material + body("a", box(0.5, 0, 1, 1));
  expect_words(complaint(ring), {"can move along y"});
  EXPECT_EQ(complaint(ring + "[boundary.b]\nwhere.box = { max = [9.0, 1e-6] }\nuy = 0.0\n"), "");
}

TEST(Preflight, SplinesWithTooFewPoints) {
  const std::string text = "grid = { origin = [0, 0], cell_size = 1.0, cells = [1, 1], shape_functions = \"cubic_bspline\" }\n" + material +
                           body("a", box(0, 0, 1, 1)) + base;
  const std::string says = complaint(text);
  expect_words(says, {"body \"a\" has 4 points", "[body.a] points.per_direction = "});
  const std::string wanted = says.substr(says.find("per_direction = ") + 16, 1);
  EXPECT_EQ(complaint(text, {"body.a.points.per_direction=" + wanted}), "");
  expect_words(complaint(text, {"body.a.points.mesh=triangles", "body.a.points.size=1.0", "body.a.points.per_element=1"}), {"more points.per_element"});
}

/// Rows of such cells: a place in the middle of one is nearer to points than a cell is wide.
TEST(Preflight, FlatCellsHaveProbesToo) {
  EXPECT_EQ(complaint("grid = { origin = [-25.0, -0.25], cell_size = [25.0, 0.25], cells = [6, 6] }\n" + material + body("a", box(0, 0, 100, 1)) +
                      base.substr(0, base.find("max")) + "max = [900.0, 1e-6] }\nux = 0.0\nuy = 0.0\n[probe.p]\nat = [50.0, 0.5]\nquantity = \"stress_yy\"\n"),
            "");
}

// Cells through a thickness.

TEST(Preflight, BeamsOfFewCells) {
  const std::string beam = body("a", box(0, 0, 2, 0.2)) + base + material;
  const auto notes = [](const std::string& text, const std::vector<std::string>& overrides = {}) {
    return build_world(case_of(text, overrides))->thin_parts;
  };
  // A cantilever of 2 cells is 1.12 times too stiff, one of a single cell 1.50 times.
  const auto two = notes(grid + beam);
  ASSERT_EQ(two.size(), 1u);
  expect_words(two[0], {"body a is 2 cells thick", "0.2 m", "12 % too stiff"});
  const std::vector<std::string> coarse = {"grid.cell_size=0.2", "grid.cells=[12,4]"}, fem = {"method=\"fem\""};
  ASSERT_EQ(notes(grid + beam, coarse).size(), 1u);
  EXPECT_NE(notes(grid + beam, coarse)[0].find("50 % too stiff"), std::string::npos);
  EXPECT_EQ(notes(grid + beam, {"grid.angle=0.3"}).size(), 1u);
  EXPECT_EQ(notes(grid + beam, fem).size(), 1u);
  // Four cells of halves of squares: 1.22 times (measured: 1.216).
  const auto halves = notes(grid + beam, {"grid.cell_size=0.05", "grid.cells=[48,12]", "grid.kind=\"triangles_right\""});
  ASSERT_EQ(halves.size(), 1u);
  expect_words(halves[0], {"4 cells thick", "22 % too stiff"});
  // Enough cells, quadratic functions, a stub, a slice between rollers.
  EXPECT_TRUE(notes(grid + beam, {"grid.cell_size=0.05", "grid.cells=[48,12]"}).empty());
  EXPECT_TRUE(notes(grid + beam, {"grid.shape_functions=\"b2gimp\""}).empty());
  EXPECT_TRUE(notes(grid + beam, {fem[0], "body.a.mesh.order=2"}).empty());
  EXPECT_TRUE(notes(grid + body("a", box(0, 0, 0.6, 0.2)) + base + material).empty());
  const std::string rollers = "[boundary.low]\nwhere.box = { max = [9.0, 1e-6] }\nuy = 0.0\n[boundary.high]\nwhere.box = { min = [-9.0, 0.199] }\nuy = 0.0\n";
  EXPECT_TRUE(notes(grid + body("a", box(0, 0, 2, 0.2)) + rollers + material).empty());
}

TEST(Preflight, BodiesInACell) {
  const auto notes = [](double size) { return build_world(case_of(grid + body("a", box(0, 0, size, size)) + base + material, {}))->thin_parts; };
  ASSERT_EQ(notes(0.05).size(), 1u);
  expect_words(notes(0.05)[0], {"body a is 0.05 m long, 0.5 of a cell", "0.013 m"});
  EXPECT_TRUE(notes(0.1).empty());  // one cell for a test of a law
}

TEST(Preflight, CellsThatLock) {
  const std::string clay = "[material.m]\nlaw = \"mohr_coulomb\"\ndensity = 2000.0\nyoungs_modulus = 1e8\npoisson_ratio = 0.49\ncohesion = 3e4\nfriction_angle = 0.0\n[steps]\ncount = 1\n";
  const auto says = [&](const std::vector<std::string>& overrides) {
    const Case c = case_by_default(grid + body("a", box(0, 0, 1, 1)) + base + clay, overrides);
    return std::any_of(c.choices.begin(), c.choices.end(), [](const std::string& text) { return text.find(" lock where") != std::string::npos; });
  };
  EXPECT_FALSE(says({}));
  EXPECT_TRUE(says({"model.volumetric=\"standard\""}));
  EXPECT_TRUE(says({"grid.kind=\"triangles_right\""}));
  EXPECT_TRUE(says({"method=\"fem\""}));
  EXPECT_FALSE(says({"method=\"fem\"", "body.a.mesh.order=2"}));
}

}  // namespace
}  // namespace berm::verify
