/// `base`, `remove` and overrides.

#include "case_files.hpp"
#include "describe.hpp"

namespace berm {
namespace {

class Inherit : public CaseFiles {
protected:
  void SetUp() override {
    CaseFiles::SetUp();
    write("base.toml", small_case + "[boundary.base]\nwhere.box = { max = [1.0, 0.0] }\nux = 0.0\nuy = 0.0\n");
  }
};

TEST_F(Inherit, childWinsKeyByKeyAndArraysAreReplaced) {
  const Case c =
      read("base = \"base.toml\"\n[grid]\ncells = [5, 6]\n[material.clay]\ndensity = 2000\n[steps]\ncount = 7\n");
  EXPECT_EQ(std::get<StructuredGrid>(c.grid).nx, 5);
  EXPECT_EQ(std::get<StructuredGrid>(c.grid).ny, 6);
  EXPECT_EQ(std::get<StructuredGrid>(c.grid).cell_size, Vec3(0.1, 0.1, 0.0));
  EXPECT_EQ(c.materials[0].density, 2000.0);
  EXPECT_EQ(std::get<LinearElastic>(c.materials[0].law).youngs_modulus, 1e7);
  EXPECT_EQ(c.steps.count, 7);
  EXPECT_EQ(c.boundaries.size(), 1u);
  EXPECT_EQ(c.resolved.find("base = \"base.toml\""), std::string::npos);
}

TEST_F(Inherit, removeDropsTablesAndKeysOfTheBase) {
  const Case c = read(
      "base = \"base.toml\"\nremove = [\"boundary.base\", \"model\", \"body.block.shape\"]\n"
      "[body.block]\nshape.disc = { centre = [0.5, 0.5], radius = 0.4 }\n");
  EXPECT_TRUE(c.boundaries.empty());
  EXPECT_EQ(c.gravity.at(1.0), Vec3(0.0, 0.0, 0.0));
  EXPECT_TRUE(std::holds_alternative<Disc>(std::get<PlaneShape>(*c.bodies[0].shape).form));
  EXPECT_EQ(c.resolved.find("remove"), std::string::npos);
}

TEST_F(Inherit, replacingAShapeWithoutRemoveSaysHow) {
  EXPECT_EQ(errors("base = \"base.toml\"\n[body.block]\nshape.disc = { centre = [0.5, 0.5], radius = 0.4 }\n"),
            "case.toml:3:14: \"disc\" in [body.block.shape] cannot stand beside \"box\" (\"box\" comes from "
            "base.toml:16:13; drop it with remove = [\"body.block.shape.box\"])");
}

TEST_F(Inherit, chainOfBasesInOtherFolders) {
  write("sub/mesh/a.msh", "");
  write("sub/middle.toml",
        "base = \"../base.toml\"\nremove = [\"body.block.shape\"]\n[body.block]\nfile = "
        "\"mesh/a.msh\"\npoints.per_element = 4\n");
  const Case c = read("base = \"sub/middle.toml\"\ntitle = \"last\"\n");
  EXPECT_EQ(c.title, "last");
  EXPECT_EQ(c.bodies[0].mesh_file, path("sub/mesh/a.msh"));
}

TEST_F(Inherit, errorsPointToTheFileThatIsWrong) {
  write("bad.toml", small_case + "[steps]\nadaptiv = true\n");
  EXPECT_EQ(errors("base = \"bad.toml\"\n[steps]\ncuont = 3\n"),
            "case.toml:3:1: unknown key \"cuont\" in [steps] (did you mean \"count\"?)\n"
            "bad.toml:18:1: unknown key \"adaptiv\" in [steps] (did you mean \"adaptive\"?)");
}

TEST_F(Inherit, cyclesAreAnError) {
  write("a.toml", "base = \"b.toml\"\n");
  write("b.toml", "base = \"./a.toml\"\n");
  EXPECT_TRUE(errors_of_file("a.toml").starts_with("b.toml:1:8: \"base\" goes round in a circle: "))
      << errors_of_file("a.toml");
  write("self.toml", "base = \"self.toml\"\n");
  EXPECT_TRUE(errors_of_file("self.toml").starts_with("self.toml:1:8: \"base\" goes round in a circle: "));
}

TEST_F(Inherit, overridesComeLast) {
  const Case c =
      read(small_case, {"solver.integration=impl_ex", "grid.cells=[3, 4]", "material.clay.youngs_modulus=2 GPa",
                        "steps = {count = 9, adaptive = false}", "title=Ein \"Titel\"", "model.plane = stress",
                        "body.block.shape.box.max = [2.0, 1.0]"});
  EXPECT_EQ(c.solver.integration, Integration::impl_ex);
  EXPECT_EQ(std::get<StructuredGrid>(c.grid).ny, 4);
  EXPECT_EQ(std::get<LinearElastic>(c.materials[0].law).youngs_modulus, 2e9);
  EXPECT_EQ(c.steps.count, 9);
  EXPECT_FALSE(c.steps.adaptive);
  EXPECT_EQ(c.title, "Ein \"Titel\"");
  EXPECT_EQ(c.space, Space::plane_stress);
  EXPECT_EQ(std::get<Box>(std::get<PlaneShape>(*c.bodies[0].shape).form).max, Vec2(2.0, 1.0));
  EXPECT_EQ(describe(c), describe(read(c.resolved)));
}

TEST_F(Inherit, errorsOfOverridesNameThem) {
  EXPECT_EQ(errors(small_case, {"steps.count=3O0"}),
            "override \"steps.count=3O0\": \"count\" in [steps] must be a whole number, not a string");
  EXPECT_EQ(errors(small_case, {"steps.count=99999999999999999999"}),
            "override \"steps.count=99999999999999999999\": 99999999999999999999 is no whole number: it begins with 0 or has more than 64 bits");
  EXPECT_EQ(errors(small_case, {"solver.integratoin=impl_ex"}),
            "override \"solver.integratoin=impl_ex\": unknown key \"integratoin\" in [solver] (did you mean "
            "\"integration\"?)");
  EXPECT_EQ(errors(small_case, {"steps"}), "override \"steps\": must be dotted.key=value");
  EXPECT_EQ(errors(small_case, {"base=other.toml"}), "override \"base=other.toml\": \"base\" cannot be overridden");
  EXPECT_EQ(errors(small_case, {"a b=1"}),
            "override \"a b=1\": must be dotted.key=value on one line, with keys of letters, digits, _ and -");
  EXPECT_NE(errors(small_case, {"grid.cells=[3,4"}).find("not valid TOML"), std::string::npos);
  EXPECT_NE(errors(small_case, {"title=a\nmethod=\"fem\""}), "");
}

TEST_F(Inherit, somethingMissingBelongsToTheFileNotToTheOverride) {
  std::string text = small_case;
  text.erase(text.find("density"), text.find("youngs") - text.find("density"));
  EXPECT_EQ(errors(text, {"material.clay.poisson_ratio=0.2"}),
            "case.toml:8:1: missing key \"density\" in [material.clay] (number [kg/m3])");
}

TEST_F(Inherit, pathsOfOverridesAreRelativeToTheCurrentFolder) {
  write("curve.csv", "nominal_strain [-],nominal_stress [Pa]\n0,0\n");
  const Case c =
      read(small_case, {"output.references=[\"" + std::filesystem::relative(path("curve.csv")).string() + "\"]"});
  EXPECT_EQ(c.output.references[0].file, path("curve.csv"));
}

}  // namespace
}  // namespace berm
