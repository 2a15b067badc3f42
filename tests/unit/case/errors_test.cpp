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
  EXPECT_EQ(errors(small_case + "[contact.x]\nbody = \"block\"\nrigid = \"block\"\nfriction = 1\n"),
            "case.toml:19:9: \"rigid\" in [contact.x]: body \"block\" is deformable; a rigid one is needed\n"
            "case.toml:20:1: unknown key \"friction\" in [contact.x] (valid: body, rigid, kind, stiffness)");
}

TEST_F(CaseErrors, missingFile) {
  EXPECT_EQ(errors_of_file("no.toml"), "no.toml: case file \"no.toml\" does not exist");
}

TEST_F(CaseErrors, folderInsteadOfFile) {
  std::filesystem::create_directories(path("folder"));
  EXPECT_EQ(errors_of_file("folder"), "folder: case file \"folder\" is not a file");
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

}  // namespace
}  // namespace berm
