#include "case/differences.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "case/places.hpp"

namespace berm {
namespace {

const std::string before = R"(method = "mpm"
[grid]
cells = [12, 6]
origin = [0, 0]
[body.a]
shape = { surface = "/first/a.stl" }
[pin.k]
at = [0.0, 1.0]
[steps]
count = 10
[output]
frames = 2
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = before;
  return text.replace(text.find(from), from.size(), to);
}

TEST(Differences, NoneOfTheSameText) { EXPECT_TRUE(differences(before, before).empty()); }

TEST(Differences, NumbersAreComparedAsNumbers) { EXPECT_TRUE(differences(before, changed("[0, 0]", "[0.0, 0.0]")).empty()); }

TEST(Differences, SayWhatWasAndIs) {
  const auto found = differences(before, changed("count = 10", "count = 20"));
  ASSERT_EQ(found.size(), 1u);
  EXPECT_EQ(found[0].key, "steps.count");
  EXPECT_EQ(found[0].before, "10");
  EXPECT_EQ(found[0].now, "20");
  EXPECT_FALSE(found[0].of_the_model());
}

TEST(Differences, AbsentOnEitherSide) {
  const auto less = differences(before, changed("frames = 2\n", "")), more = differences(changed("frames = 2\n", ""), before);
  ASSERT_EQ(less.size(), 1u);
  EXPECT_EQ(less[0].now, "absent");
  ASSERT_EQ(more.size(), 1u);
  EXPECT_EQ(more[0].before, "absent");
}

TEST(Differences, OfTheModelAreGridAndBodiesNotWhereTheirFilesLie) {
  EXPECT_TRUE(differences(before, changed("[12, 6]", "[13, 6]")).at(0).of_the_model());
  EXPECT_TRUE(differences(before, changed("\"mpm\"", "\"fem\"")).at(0).of_the_model());
  EXPECT_TRUE(differences(before, changed("[0.0, 1.0]", "[0.0, 2.0]")).at(0).of_the_model());
  EXPECT_FALSE(differences(before, changed("/first/a.stl", "/second/a.stl")).at(0).of_the_model());
}

TEST(Differences, OfTheModelIsWhatTheHistoryHasColumnsOf) {
  const std::string probe = "[probe.a]\nat = [0.0, 1.0]\nquantity = \"stress_yy\"\n";
  std::string other = probe;
  other.replace(other.find("yy"), 2, "xx");
  EXPECT_TRUE(differences(probe, other).at(0).of_the_model());
  EXPECT_TRUE(differences("", probe).at(0).of_the_model());
  EXPECT_TRUE(differences("[steps]\nanalysis = \"dynamic\"\n", "[steps]\nanalysis = \"quasi_static\"\n").at(0).of_the_model());
}

TEST(Differences, Motions) {
  const auto first = [](const char* then, const char* now) { return differences(then, now).at(0).of_a_motion(); };
  EXPECT_TRUE(first("[boundary.a]\nux = 0.0\n", "[boundary.a]\nux = 0.1\n"));
  EXPECT_TRUE(first("[boundary.a]\nun = 0.0\n", "[boundary.a]\nun = \"t\"\n"));
  EXPECT_TRUE(first("[body.a]\ndisplacement = [0.0, 0.0]\n", "[body.a]\ndisplacement = [0.0, 0.1]\n"));
  EXPECT_FALSE(first("[pressure.a]\nvalue = 0.0\n", "[pressure.a]\nvalue = 0.1\n"));
}

TEST(Differences, FilesThatHoldSomethingElse) {
  const std::string path = testing::TempDir() + "mesh_of_differences.msh";
  const auto contents = [&](const char* text) {
    std::ofstream(path) << text;
    return contents_of_files("[body.a]\nfile = \"" + path + "\"\n[body.b]\nmaterial = \"file\"\n");
  };
  const std::string one = contents("1 0 0"), two = contents("1 0 1");
  EXPECT_EQ(one.substr(0, 12), "body.a.file ");
  EXPECT_EQ(std::count(one.begin(), one.end(), '\n'), 1);
  EXPECT_NE(one, two);
  EXPECT_EQ(one, contents("1 0 0"));
}

TEST(Places, LinesBeginWithTheTableThatTheyName) {
  Case c;
  c.file = "dam.toml";
  c.places = {{"pin.k", "dam.toml:4:1"}, {"body.a", "dam.toml:9:1"}};
  EXPECT_EQ(with_places(c, "[pin.k]: no\n[pin.other]: no\nbody \"a\" is bad\nmesh.msh:3: bad"),
            "dam.toml:4:1: [pin.k]: no\ndam.toml: [pin.other]: no\ndam.toml:9:1: body \"a\" is bad\nmesh.msh:3: bad");
}

}  // namespace
}  // namespace berm
