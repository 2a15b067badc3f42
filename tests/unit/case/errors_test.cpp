/// Cases that are wrong: every problem is found at once, with its place and a remedy.

#include <algorithm>

#include "case_files.hpp"

namespace berm {
namespace {

class CaseErrors : public CaseFiles {};

std::string with(std::string text, const std::string& from, const std::string& to) {
  return text.replace(text.find(from), from.size(), to);
}

TEST_F(CaseErrors, allProblemsAreListedInTheOrderOfTheFile) {
  std::string text = with(small_case, "density = 1900.0", "denisty = 1900.0");
  text = with(text, "poisson_ratio = 0.3", "poisson_ratio = 0.7");
  text = with(text, "material = \"clay\"", "material = \"sand\"");
  EXPECT_EQ(errors(text),
            "case.toml:8:1: missing key \"density\" in [material.clay] (number [kg/m3])\n"
            "case.toml:10:1: unknown key \"denisty\" in [material.clay] (did you mean \"density\"?)\n"
            "case.toml:12:17: \"poisson_ratio\" in [material.clay] must be -1 < value < 0.5, is 0.7\n"
            "case.toml:15:12: \"material\" in [body.block]: no material \"sand\" (valid: clay)");
}

TEST_F(CaseErrors, validKeysAreListedWhenNoneIsNear) {
  EXPECT_EQ(errors(small_case + "[contact.x]\nbody = \"block\"\nrigid = \"block\"\ncolour = 1\n"),
            "case.toml:19:9: \"rigid\" in [contact.x]: body \"block\" is deformable; a rigid one is needed\n"
            "case.toml:20:1: unknown key \"colour\" in [contact.x] (valid: body, rigid, other, kind, friction, stiffness, stages)");
}

TEST_F(CaseErrors, missingFile) {
  EXPECT_EQ(errors_of_file("no.toml"), "no.toml: case file \"no.toml\" does not exist");
}

TEST_F(CaseErrors, folderInsteadOfFile) {
  std::filesystem::create_directories(path("folder"));
  EXPECT_EQ(errors_of_file("folder"), "folder: case file \"folder\" is a folder: name a file in it");
}

TEST_F(CaseErrors, syntaxErrorHasAPlace) {
  EXPECT_TRUE(errors(small_case + "x = = 1\n").starts_with("case.toml:17:5: not valid TOML: "))
      << errors(small_case + "x = = 1\n");
}

TEST_F(CaseErrors, deepNestingIsRefused) {
  std::string key = "a";
  for (int i = 0; i < 200000; ++i) key += ".a";
  EXPECT_EQ(errors(key + " = 1\n"), "case.toml: not valid TOML: a key of more than a thousand parts");
  EXPECT_NE(errors(small_case, {key + "=1"}), "");
  EXPECT_EQ(errors(key.substr(0, 401) + " = 1\n").find("case.toml:1:"), 0u);
  EXPECT_EQ(errors("x = " + std::string(5000, '[')).find("case.toml:1:"), 0u);
}

TEST_F(CaseErrors, nameWithTwoMeaningsIsAmbiguous) {
  const std::string extra = R"([boundary.top]
where.box.min = [0, 1]
ux = 0
[pressure.top]
body = "block"
where.box.min = [0, 1]
value = 1.0
[output.nominal]
load = "top"
)";
  EXPECT_EQ(errors(small_case + extra),
            "case.toml:25:8: \"load\" in [output.nominal]: \"top\" is the name of more than one rigid body, boundary "
            "or pressure");
}

TEST_F(CaseErrors, crackBandTooLongForTheLaw) {
  const std::string concrete = R"(law = "simo_ju"
density = 2400
youngs_modulus = "30 GPa"
poisson_ratio = 0.2
tensile_strength = "3 MPa"
strength_ratio = 10
fracture_energy = 100
crack_band = 1.0
)";
  std::string text = small_case;
  text.replace(text.find("law ="), text.find("[body") - text.find("law ="), concrete);
  // 2 E Gf / ft^2 = 0.667 m
  EXPECT_TRUE(errors(text).starts_with("case.toml:16:14: \"crack_band\" in [material.clay]: crack-band length 1 m"))
      << errors(text);
  EXPECT_EQ(errors(with(text, "crack_band = 1.0", "crack_band = 0.6")), "");
}

TEST_F(CaseErrors, controlByGaugeNeedsAllItsParts) {
  EXPECT_EQ(errors(small_case + "[control]\nkind = \"gauge\"\n"),
            "case.toml:17:1: missing key \"gauge\" in [control] (name of a gauge)\n"
            "case.toml:17:1: missing key \"target\" in [control] (number [m])\n"
            "case.toml:18:8: \"kind\" in [control] needs a load to scale (add a [pressure.NAME])");
}

TEST_F(CaseErrors, rigidBodyTakesNothingOfADeformableOne) {
  const std::string rigid =
      "[body.wall]\nrigid = true\nshape.disc = { centre = [0, 0], radius = 1 }\nmaterial = \"clay\"\npoints = {}\n";
  EXPECT_EQ(errors(small_case + rigid),
            "case.toml:20:12: \"material\" in [body.wall] is only allowed in deformable bodies\n"
            "case.toml:21:10: \"points\" in [body.wall] is only allowed in deformable bodies");
}

TEST_F(CaseErrors, bodyFromAFileHasItsOwnMesh) {
  write("a.msh", "");
  const std::string body = "[body.a]\nmaterial = \"clay\"\nfile = \"a.msh\"\n";
  EXPECT_EQ(
      errors(small_case + body + "points = { per_direction = 2 }\n"),
      "case.toml:17:1: missing key \"points.per_element\" in [body.a] (Gauss points of an element of the file; e.g. "
      "points = { per_element = 4 })\n"
      "case.toml:20:28: \"per_direction\" in [body.a.points] is only allowed without \"mesh\", in bodies with a shape");
  EXPECT_EQ(errors(small_case + body + "points.per_element = 3\nmesh.size = 0.1\n"),
            "case.toml:21:1: \"mesh\" in [body.a] is only allowed in deformable bodies with a shape");
  EXPECT_EQ(errors(small_case + body + "points.per_element = 3\n"), "");
}

TEST_F(CaseErrors, oneBadValueIsReportedOnce) {
  const std::string text = errors(with(small_case, "cells = [10, 20]", "cells = [10, 0]"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 0) << text;
}

/// The one error of a case in space with this shape.
class DimensionErrors : public CaseFiles {
protected:
  std::string of_shape(const std::string& shape) const {
    std::string text = small_solid_case;
    return errors(text.replace(text.find("shape.box"), std::string::npos, "shape." + shape + "\n"));
  }
};

TEST_F(CaseErrors, dimensionIsTwoOrThreeAndComesFirst) {
  EXPECT_EQ(errors(with(small_solid_case, "dimension = 3", "dimension = 4")),
            "case.toml:2:13: \"dimension\" in [model] must be 2 or 3, is 4");
  EXPECT_EQ(errors(with(small_solid_case, "dimension = 3", "dimension = 3.0")),
            "case.toml:2:13: \"dimension\" in [model] must be a whole number, not a decimal number");
  EXPECT_EQ(errors("model = 3\n" + small_case.substr(small_case.find("[grid]"))),
            "case.toml:1:9: \"model\" at the top level must be a table, not a whole number");
}

TEST_F(DimensionErrors, twoNumbersInSpace) {
  EXPECT_EQ(errors(with(small_solid_case, "[0.0, 0.0, -9.81]", "[0.0, -9.81]")),
            "case.toml:3:11: \"gravity\" in [model] must be [x, y, z] ([model] dimension = 3)");
  EXPECT_EQ(errors(with(small_solid_case, "[10, 20, 30]", "[10, 20]")),
            "case.toml:7:9: \"cells\" in [grid] must be [nx, ny, nz] ([model] dimension = 3)");
  EXPECT_EQ(errors(with(small_solid_case, "cell_size = 0.1", "cell_size = [0.1, 0.1]")),
            "case.toml:6:13: \"cell_size\" in [grid] must be [x, y, z] ([model] dimension = 3)");
  EXPECT_EQ(of_shape("sphere = { centre = [0, 0], radius = 1 }"),
            "case.toml:17:27: \"centre\" in [body.block.shape.sphere] must be [x, y, z] ([model] dimension = 3)");
}

TEST_F(DimensionErrors, threeNumbersInThePlane) {
  EXPECT_EQ(errors(with(small_case, "[0.0, -9.81]", "[0.0, 0.0, -9.81]")),
            "case.toml:2:11: \"gravity\" in [model] must be [x, y]; for three numbers set [model] dimension = 3");
  EXPECT_EQ(errors(with(small_case, "[10, 20]", "[10, 20, 30]")),
            "case.toml:6:9: \"cells\" in [grid] must be [nx, ny]; for three whole numbers set [model] dimension = 3");
  EXPECT_EQ(errors(with(small_case, "[0.0, -9.81]", "-9.81")),
            "case.toml:2:11: \"gravity\" in [model] must be an array of two numbers");
}

TEST_F(DimensionErrors, everyEntryOfAVectorIsChecked) {
  EXPECT_EQ(errors(with(small_solid_case, "[0.0, 0.0, -9.81]", "[\"1 m\", 0, true]")),
            "case.toml:3:12: \"gravity[0]\" in [model]: \"1 m\" has the unit of a length; an acceleration is needed, "
            "such as \"1 m/s2\"\n"
            "case.toml:3:22: \"gravity[2]\" in [model] must be a number or a string with a unit, not true/false");
  EXPECT_EQ(errors(with(small_solid_case, "[10, 20, 30]", "[10, 20, 0]")),
            "case.toml:7:18: \"cells[2]\" in [grid] must be 1 <= value <= 100000, is 0");
}

/// Only keys are counted: comments and strings may have as many dots as they like.
TEST_F(CaseErrors, dotsOfCommentsAndStrings) {
  const std::string dots(1500, '.');
  EXPECT_EQ(errors("# " + dots + "\n" + small_case), "");
  EXPECT_EQ(errors("title = \"" + dots + "\"  # \"" + dots + "\n" + small_case), "");
  EXPECT_EQ(errors("title = '" + dots + "'\n" + small_case), "");
  EXPECT_EQ(errors("title = \"\"\"\n" + dots + " \"" + dots + "\n\"\"\"\n" + small_case), "");
  std::string key = "a";
  for (int k = 0; k < 1500; ++k) key += ".a";
  EXPECT_NE(errors(key + " = 1\n" + small_case).find("a key of more than a thousand parts"), std::string::npos);
  EXPECT_NE(errors("title = \"a\"\n" + key + " = 1\n" + small_case).find("a key of more than a thousand parts"), std::string::npos);
}

TEST_F(CaseErrors, expressionsOfLoadsAndMotions) {
  const auto gravity = [&](const std::string& value) {
    return errors(with(small_case, "[0.0, -9.81]", "[0.0, \"" + value + "\"]"));
  };
  EXPECT_EQ(gravity("-9.81*min(t/0.5, 1)"), "");
  EXPECT_EQ(gravity("-9.81 m/s2"), "");
  EXPECT_EQ(gravity("-9.81*"),
            "case.toml:2:17: \"gravity[1]\" in [model]: \"-9.81*\": Unexpected end of expression at "
            "position 7");
  EXPECT_EQ(gravity("-9.81*time"),
            "case.toml:2:17: \"gravity[1]\" in [model]: \"-9.81*time\": Unexpected token "
            "\"time\" found at position 6.");
  EXPECT_EQ(gravity("-9.81*y"),
            "case.toml:2:17: \"gravity[1]\" in [model]: \"-9.81*y\" may depend on the time t, not on x, y, z");
}

TEST_F(DimensionErrors, planeThingsInSpace) {
  EXPECT_EQ(errors(with(small_solid_case, "dimension = 3", "dimension = 3\nplane = \"strain\"\nthickness = 2")),
            "case.toml:3:9: \"plane\" in [model] is only allowed in the plane ([model] dimension = 2)\n"
            "case.toml:4:13: \"thickness\" in [model] is only allowed in plane strain and plane stress");
  EXPECT_EQ(of_shape("disc = { centre = [0, 0], radius = 1 }"),
            "case.toml:17:14: \"disc\" in [body.block.shape] is only allowed in the plane ([model] dimension = 2); in "
            "space take \"cylinder\" or \"sphere\"");
  EXPECT_EQ(
      of_shape("polygon = [[0, 0], [1, 0], [0, 1]]"),
      "case.toml:17:17: \"polygon\" in [body.block.shape] is only allowed in the plane ([model] dimension = 2); in "
      "space take \"extrusion\"");
  EXPECT_EQ(
      errors(with(small_solid_case, "cell_size", "kind = \"union_jack\"\ncell_size")),
      "case.toml:6:8: \"kind\" in [grid]: \"union_jack\" is for the plane ([model] dimension = 2); in space there "
      "are hexahedra, tetrahedra");
  EXPECT_EQ(errors(small_solid_case + "mesh = { kind = \"quads\", size = 0.1 }\n"),
            "case.toml:18:17: \"kind\" in [body.block.mesh]: \"quads\" is for the plane ([model] dimension = 2); in "
            "space there are hexahedra, tetrahedra");
}

TEST_F(DimensionErrors, solidThingsInThePlane) {
  const auto with_shape = [](const std::string& shape) {
    std::string text = small_case;
    return text.replace(text.find("shape.box"), std::string::npos, "shape." + shape + "\n");
  };
  const std::string only =
      " in [body.block.shape] is only allowed in space ([model] dimension = 3); in the plane take ";
  EXPECT_EQ(errors(with_shape("cylinder = { from = [0, 0, 0], to = [0, 0, 1], radius = 1 }")),
            "case.toml:16:18: \"cylinder\"" + only + "\"disc\" or \"box\"");
  EXPECT_EQ(errors(with_shape("sphere = { centre = [0, 0, 0], radius = 1 }")),
            "case.toml:16:16: \"sphere\"" + only + "\"disc\"");
  EXPECT_EQ(errors(with_shape("extrusion = { from = 0 }")), "case.toml:16:19: \"extrusion\"" + only + "\"polygon\"");
  EXPECT_EQ(errors(with_shape("surface = \"a.stl\"")),
            "case.toml:16:17: \"surface\"" + only + "\"polygon\", or a mesh with \"file\"");
  EXPECT_EQ(errors(with(small_case, "cell_size", "kind = \"hexahedra\"\ncell_size")),
            "case.toml:5:8: \"kind\" in [grid]: \"hexahedra\" is for models in space ([model] dimension = 3); in the "
            "plane there are quads, triangles_right, triangles_left, union_jack");
  EXPECT_EQ(
      errors(small_case + "points = { mesh = \"tetrahedra\", size = 0.1 }\n"),
      "case.toml:17:19: \"mesh\" in [body.block.points]: \"tetrahedra\" is for models in space ([model] dimension = "
      "3); in the plane there are quads, triangles");
  EXPECT_EQ(errors(small_case + "[boundary.a]\nwhere.box.min = [0, 0]\nuz = 0\n"),
            "case.toml:19:6: \"uz\" in [boundary.a] is only allowed in space ([model] dimension = 3)");
  EXPECT_EQ(
      errors(small_case + "[pin.a]\nbody = \"block\"\nat = [0.5, 0.5]\nfix = \"z\"\n"),
      "case.toml:20:7: \"fix\" in [pin.a]: \"z\" is for models in space ([model] dimension = 3); in the plane there "
      "are x, y, xy");
  const std::string quantity = errors(small_case + "[probe.a]\nat = [0.5, 0.5]\nquantity = \"stress_yz\"\n");
  EXPECT_TRUE(
      quantity.starts_with("case.toml:19:12: \"quantity\" in [probe.a]: \"stress_yz\" is for models in space "
                           "([model] dimension = 3); in the plane there are stress_xx, stress_yy, stress_zz, "))
      << quantity;
}

TEST_F(DimensionErrors, misspeltWordsAreSuggestedForTheDimension) {
  EXPECT_EQ(errors(with(small_solid_case, "cell_size", "kind = \"hexaedra\"\ncell_size")),
            "case.toml:6:8: \"kind\" in [grid]: unknown value \"hexaedra\" (did you mean \"hexahedra\"?)");
  EXPECT_EQ(errors(small_solid_case + "[pin.a]\nbody = \"block\"\nat = [0.5, 0.5, 0.5]\nfix = \"yx\"\n"),
            "case.toml:21:7: \"fix\" in [pin.a]: unknown value \"yx\" (did you mean \"x\"?)");
}

TEST_F(DimensionErrors, brokenShapes) {
  EXPECT_EQ(of_shape("box = { min = [0, 0, 0], max = [1, 1, 0] }"),
            "case.toml:17:38: \"max\" in [body.block.shape.box] must be larger than \"min\" in every direction");
  EXPECT_EQ(of_shape("cylinder = { from = [1, 2, 3], to = [1, 2, 3], radius = 1 }"),
            "case.toml:17:43: \"to\" in [body.block.shape.cylinder] must differ from \"from\": the cylinder has no "
            "length");
  EXPECT_EQ(of_shape("extrusion = { polygon = [[0, 0], [1, 0], [0, 1]], from = 1, to = \"100 cm\" }"),
            "case.toml:17:72: \"to\" in [body.block.shape.extrusion] must be larger than \"from\"");
  EXPECT_EQ(of_shape("extrusion = { polygon = [[0, 0], [1, 1]], from = 0, to = 1 }"),
            "case.toml:17:31: \"polygon\" in [body.block.shape.extrusion] needs at least 3 vertices, has 2");
  EXPECT_EQ(of_shape("extrusion = { polygon = [[0, 0, 0], [1, 0, 0], [1, 1, 0]], from = 0, to = 1 }"),
            "case.toml:17:32: \"polygon[0]\" in [body.block.shape.extrusion] must be an array of two numbers");
  EXPECT_EQ(errors(with(small_solid_case, "shape.box = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 2.0] }", "")),
            "case.toml:15:1: missing in [body.block]: one of shape, file");
  EXPECT_EQ(
      errors(with(small_solid_case, "box = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 2.0] }", "union = [{}, {}]")),
      "case.toml:17:16: missing in [body.block.shape.union[0]]: one of box, cylinder, sphere, extrusion, surface, "
      "union, difference\n"
      "case.toml:17:20: missing in [body.block.shape.union[1]]: one of box, cylinder, sphere, extrusion, surface, "
      "union, difference");
}

TEST_F(DimensionErrors, surfacesFromFiles) {
  EXPECT_EQ(of_shape("surface = \"no.stl\""),
            "case.toml:17:17: \"surface\" in [body.block.shape]: file \"no.stl\" does not exist (looked for no.stl)");
  std::string open = tetrahedron_stl;
  open.erase(open.find("facet normal 1 1 1"), open.find("endsolid") - open.find("facet normal 1 1 1"));
  write("open.stl", open);
  EXPECT_EQ(
      of_shape("surface = \"open.stl\""),
      "case.toml:17:17: \"surface\" in [body.block.shape]: open.stl: the surface is not closed: 3 open edge(s), the "
      "first one at (0.5, 0.5, 0) (close the holes in the program that made it; vertices of neighbours must "
      "coincide)");
  write("good.stl", tetrahedron_stl);
  EXPECT_EQ(of_shape("surface = \"good.stl\""), "");
  EXPECT_EQ(of_shape("union = [{ surface = \"good.stl\" }, { sphere = { centre = [0, 0, 0], radius = 1 } }]"),
            "case.toml:17:28: \"surface\" in [body.block.shape.union[0]] cannot be a part of a union or difference: an "
            "STL surface stands alone (combine the parts in the program that made it)");
}

TEST_F(DimensionErrors, meshesAndPoints) {
  const std::string sphere = with(small_solid_case, "box = { min = [0.0, 0.0, 0.0], max = [1.0, 1.0, 2.0] }",
                                  "sphere = { centre = [0, 0, 0], radius = 1 }");
  EXPECT_EQ(
      errors(sphere + "points = { mesh = \"hexahedra\", size = 0.1 }\n"),
      "case.toml:18:19: \"mesh\" in [body.block.points]: hexahedra are for cylinders and shapes made of boxes; take "
      "tetrahedra");
  EXPECT_EQ(
      errors(sphere + "mesh = { kind = \"hexahedra\", size = 0.1 }\n"),
      "case.toml:18:17: \"kind\" in [body.block.mesh]: hexahedra are for cylinders and shapes made of boxes; take "
      "tetrahedra");
  EXPECT_EQ(errors(sphere + "mesh = { kind = \"tetrahedra\", size = 0.1, structured = true }\n"),
            "case.toml:18:56: \"structured\" in [body.block.mesh] is for cylinders and shapes made of boxes");
  EXPECT_EQ(errors(small_solid_case + "mesh = { kind = \"hexahedra\", size = 0.1, structured = false }\n"),
            "case.toml:18:55: \"structured\" in [body.block.mesh] must be true for hexahedra; else take tetrahedra");
  EXPECT_EQ(errors(small_solid_case + "points = { mesh = \"hexahedra\", size = 0.1, per_element = 4 }\n"),
            "case.toml:18:58: \"per_element\" in [body.block.points] must be one of 1, 8, 27, is 4");
  EXPECT_EQ(errors(small_solid_case + "points = { mesh = \"tetrahedra\", size = 0.1, per_element = 8 }\n"),
            "case.toml:18:59: \"per_element\" in [body.block.points] must be one of 1, 4, is 8");
  write("a.msh", "");
  EXPECT_EQ(errors(small_solid_case + "[body.a]\nmaterial = \"clay\"\nfile = \"a.msh\"\npoints.per_element = 3\n"),
            "case.toml:21:22: \"per_element\" in [body.a.points] must be one of 1, 4, 8, 27, is 3");
  EXPECT_EQ(
      errors("method = \"fem\"\n" + small_solid_case),
      "case.toml:16:1: missing key \"mesh\" in [body.block] (method \"fem\" meshes the body; e.g. mesh = { kind = "
      "\"tetrahedra\", size = 0.01 })");
}

TEST_F(DimensionErrors, boundaries) {
  EXPECT_EQ(errors(small_solid_case + "[boundary.a]\nwhere.box = { min = [0, 0, 1], max = [1, 1, 0] }\nuz = 0\n"),
            "case.toml:19:38: \"max\" in [boundary.a.where.box] must not be smaller than \"min\" in any direction");
  EXPECT_EQ(errors(small_solid_case + "[boundary.a]\nwhere.box.min = [0, 0, 1]\n"),
            "case.toml:18:1: missing in [boundary.a]: one of ux, uy, uz, normal");
}

TEST_F(CaseErrors, numbersOfTheRun) {
  const auto of = [&](const char* change) { return errors(small_case, {change}); };
  EXPECT_EQ(of("parallel.rebalance=1.0"),
            "override \"parallel.rebalance=1.0\": \"rebalance\" in [parallel] must be > 1, is 1");
  EXPECT_EQ(of("checkpoint.every_steps=-1"),
            "override \"checkpoint.every_steps=-1\": \"every_steps\" in [checkpoint] must be >= 0, is -1");
  EXPECT_EQ(of("checkpoint.every_minutes=-0.5"),
            "override \"checkpoint.every_minutes=-0.5\": \"every_minutes\" in [checkpoint] must be >= 0, is -0.5 min");
  EXPECT_EQ(of("solver.linear_tolerance=1"),
            "override \"solver.linear_tolerance=1\": \"linear_tolerance\" in [solver] must be 0 < value < 1, is 1");
  EXPECT_EQ(of("solver.linear=direkt"),
            "override \"solver.linear=direkt\": \"linear\" in [solver]: unknown value \"direkt\" (did you mean "
            "\"direct\"?)");
}

TEST_F(CaseErrors, radiiAreNotNegative) {
  const std::string must = "the radius x must not be negative in an axisymmetric model; ";
  EXPECT_EQ(errors(with(axisymmetric_case, "cells =", "origin = [-0.1, 0]\ncells =")),
            "case.toml:3:10: \"origin\" in [grid]: " + must + "the grid reaches x = -0.1 m");
  EXPECT_EQ(errors(axisymmetric_case, {"grid.angle=90"}),
            "case.toml:1:1: \"origin\" in [grid]: " + must + "the grid reaches x = -1.2 m");
  EXPECT_EQ(errors(with(axisymmetric_case, "min = [0.0, 0.0]", "min = [-0.2, 0.0]")),
            "case.toml:13:1: \"shape\" in [body.specimen]: " + must + "the shape reaches x = -0.2 m");
  const std::string box = "box = { min = [0.0, 0.0], max = [0.5, 1.0] }";
  EXPECT_EQ(errors(with(axisymmetric_case, box, "disc = { centre = [0.1, 0.0], radius = 0.3 }")),
            "case.toml:13:1: \"shape\" in [body.specimen]: " + must + "the shape reaches x = -0.2 m");
  // A disc cut along the axis is half a disc, not one that reaches over it.
  const auto cut_disc = [&](const std::string& max) {
    return errors(
        with(axisymmetric_case, box,
             "difference = [{ disc = { centre = [0, 0.5], radius = 0.4 } }, { box = { min = [-1, -1], max = " + max +
                 " } }]"));
  };
  EXPECT_EQ(cut_disc("[0, 2]"), "");
  EXPECT_EQ(cut_disc("[0, 0.5]"),
            "case.toml:13:1: \"shape\" in [body.specimen]: " + must + "the shape reaches x = -0.4 m");
  EXPECT_EQ(cut_disc("[2, 2]").find("case.toml:13:1: \"shape\" in [body.specimen]: shape: "), 0u) << cut_disc("[2, 2]");
  EXPECT_EQ(errors(with(axisymmetric_case, "plane = \"axisymmetric\"", "plane = \"axisymmetric\"\nthickness = 1")),
            "case.toml:21:13: \"thickness\" in [model] is only allowed in plane strain and plane stress");
  EXPECT_EQ(errors(axisymmetric_case), "");
}

}  // namespace
}  // namespace berm
