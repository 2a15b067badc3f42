/// Cases that are right: what ends up in the structs, defaults, units, the resolved copy.

#include "case/read_case.hpp"

#include <array>
#include <fstream>
#include <numbers>

#include "case_files.hpp"
#include "describe.hpp"

namespace berm {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

class ReadCase : public CaseFiles {
protected:
  void SetUp() override {
    CaseFiles::SetUp();
    write("mesh/frame.msh", "only its existence counts here");
    write("mesh/rock.stl", tetrahedron_stl);
    write("curve.csv", "nominal_strain [-],nominal_stress [Pa]\n0,0\n");
  }
};

TEST_F(ReadCase, smallCaseHasTheDefaultsOfTheStructs) {
  const Case c = read(small_case);
  EXPECT_EQ(c.method, Method::mpm);
  EXPECT_EQ(c.space, Space::plane_strain);
  EXPECT_EQ(c.dimension(), 2);
  EXPECT_EQ(c.kinematics, Kinematics::finite);
  EXPECT_EQ(c.thickness, 1.0);
  EXPECT_EQ(c.gravity.at(1.0), Vec3(0.0, -9.81, 0.0));
  EXPECT_EQ(describe_run(c), describe_run(Case{}));
  ASSERT_EQ(c.bodies.size(), 1u);
  EXPECT_EQ(c.bodies[0].points.kind, PointSeeding::Kind::grid);
  EXPECT_EQ(c.bodies[0].points.per_direction, 2);
  EXPECT_EQ(c.materials[0].crack_band, Material::CrackBand::sqrt_area);
  EXPECT_TRUE(c.warnings.empty());
}

TEST_F(ReadCase, gridAndModelInAllForms) {
  const Case c = read(full_case);
  EXPECT_EQ(c.title, "Splitting \"test\"");
  EXPECT_EQ(c.space, Space::plane_stress);
  EXPECT_EQ(c.kinematics, Kinematics::small);
  EXPECT_DOUBLE_EQ(c.thickness, 0.05);
  EXPECT_EQ(c.gravity.at(1.0), Vec3(0.0, -9.81, 0.0));
  const auto& grid = std::get<StructuredGrid>(c.grid);
  EXPECT_EQ(grid.kind, GridKind::union_jack);
  EXPECT_NEAR(grid.origin.x(), -0.1, 1e-16);
  EXPECT_EQ(grid.nx, 40);
  EXPECT_EQ(grid.ny, 44);
  EXPECT_EQ(grid.nz, 0);
  EXPECT_NEAR(grid.cell_size.x(), 0.005, 1e-16);
  EXPECT_NEAR(grid.cell_size.y(), 0.005, 1e-16);
  EXPECT_EQ(grid.origin.z(), 0.0);
  EXPECT_EQ(grid.cell_size.z(), 0.0);
  EXPECT_NEAR(grid.angle, 20.0 * degree, 1e-15);
}

TEST_F(ReadCase, materialsKeepTheOrderOfTheFile) {
  const Case c = read(full_case);
  ASSERT_EQ(c.materials.size(), 2u);
  EXPECT_EQ(c.materials[0].name, "concrete");
  EXPECT_EQ(c.materials[0].density, 2410.0);
  EXPECT_EQ(c.materials[0].crack_band, Material::CrackBand::fixed);
  EXPECT_EQ(c.materials[0].crack_band_length, 0.005);
  const auto& law = std::get<SimoJu>(c.materials[0].law);
  EXPECT_EQ(law.youngs_modulus, 35.5e9);
  EXPECT_EQ(law.tensile_strength, 3.05e6);
  EXPECT_EQ(law.fracture_energy, 100.0);
  EXPECT_EQ(law.strength_ratio, 12.3);
  EXPECT_EQ(c.materials[1].crack_band, Material::CrackBand::equal_circle);
  EXPECT_EQ(std::get<LinearElastic>(c.materials[1].law).youngs_modulus, 210e9);
}

TEST_F(ReadCase, bodiesInAllForms) {
  const Case c = read(full_case);
  ASSERT_EQ(c.bodies.size(), 3u);
  const Body& disc = c.bodies[0];
  EXPECT_EQ(disc.points.kind, PointSeeding::Kind::mesh);
  EXPECT_EQ(disc.points.per_element, 6);
  EXPECT_EQ(disc.points.mesh.kind, BodyMeshKind::triangles);
  EXPECT_EQ(disc.points.mesh.order, 2);
  EXPECT_EQ(disc.mesh.size, 0.005);
  const auto& difference = std::get<Combination>(std::get<PlaneShape>(*disc.shape).form);
  EXPECT_EQ(difference.kind, Combination::Kind::difference);
  EXPECT_EQ(std::get<Disc>(difference.parts[0].form).radius, 0.075);
  const auto& join = std::get<Combination>(difference.parts[1].form);
  EXPECT_EQ(join.kind, Combination::Kind::join);
  EXPECT_EQ(std::get<Box>(join.parts[0].form).max, Vec2(0.01, 0.01));
  EXPECT_EQ(std::get<Polygon>(join.parts[1].form).vertices.size(), 3u);
  EXPECT_EQ(c.bodies[1].mesh_file, path("mesh/frame.msh"));
  EXPECT_EQ(c.bodies[1].mesh_group, "core");
  EXPECT_EQ(c.bodies[1].points.kind, PointSeeding::Kind::mesh);
  EXPECT_TRUE(c.bodies[2].rigid);
  EXPECT_EQ(c.bodies[2].displacement.at(1.0), Vec3(0.0, -1e-4, 0.0));
}

TEST_F(ReadCase, triangleSeedsHaveThreePointsByDefault) {
  const Case c = read(small_case + "points = { mesh = \"triangles\", size = 0.05 }\n");
  EXPECT_EQ(c.bodies[0].points.per_element, 3);
  const Case quads = read(small_case + "points = { mesh = \"quads\", size = 0.05 }\n");
  EXPECT_EQ(quads.bodies[0].points.per_element, 4);
}

TEST_F(ReadCase, loadsAndOutput) {
  const Case c = read(full_case);
  EXPECT_EQ(c.boundaries[0].where.group, "side");
  EXPECT_FALSE(c.boundaries[0].where.min);
  EXPECT_EQ(*c.boundaries[0].where.max, Vec3(0.0, 1.0, 0.0));
  EXPECT_EQ(c.boundaries[0].u[0], TimeFunction(0.0));
  EXPECT_FALSE(c.boundaries[0].u[1]);
  EXPECT_FALSE(c.boundaries[0].u[2]);
  EXPECT_EQ(c.pins[0].fixed, (std::array{false, true, false}));
  EXPECT_EQ(c.pressures[0].value, 1e6);
  EXPECT_NEAR(c.pressures[0].where.sector->from, 84.261 * degree, 1e-15);
  EXPECT_NEAR(c.pressures[0].where.sector->to, 95.739 * degree, 1e-15);
  EXPECT_EQ(c.contacts[0].kind, Contact::Kind::frictionless);
  EXPECT_EQ(c.control.kind, Control::Kind::gauge);
  EXPECT_DOUBLE_EQ(c.control.target, 30e-6);
  EXPECT_EQ(c.solver.integration, Integration::impl_ex);
  EXPECT_EQ(c.output.nominal.direction, Vec3(0.6, 0.8, 0.0));
  EXPECT_EQ(c.output.references, std::vector<ReferenceCurve>{{.file = path("curve.csv")}});
  EXPECT_EQ(c.output.probes[1].quantity, Quantity::displacement_y);
}

TEST_F(ReadCase, smallSolidCaseHasDefaultsOfItsOwn) {
  const Case c = read(small_solid_case);
  EXPECT_EQ(c.space, Space::solid);
  EXPECT_EQ(c.dimension(), 3);
  EXPECT_EQ(c.gravity.at(1.0), Vec3(0.0, 0.0, -9.81));
  const auto& grid = std::get<StructuredGrid>(c.grid);
  EXPECT_EQ(grid.kind, GridKind::hexahedra);
  EXPECT_EQ(grid.cell_size, Vec3(0.1, 0.1, 0.1));
  EXPECT_EQ(grid.nz, 30);
  EXPECT_EQ(describe_run(c), describe_run(Case{}));
  for (const char* line : {"dimension = 3", "kind = \"hexahedra\"", "origin = [0.0, 0.0, 0.0]",
                           "direction = [0.0, -1.0, 0.0]", "linear = \"automatic\"", "linear_tolerance = 1e-08",
                           "[checkpoint]\nevery_steps = 0\nevery_minutes = 10.0", "[parallel]\nrebalance = 1.2"}) {
    EXPECT_NE(c.resolved.find(line), std::string::npos) << line << "\n" << c.resolved;
  }
  for (const char* key : {"plane =", "thickness ="}) EXPECT_EQ(c.resolved.find(key), std::string::npos) << key;
  EXPECT_TRUE(c.warnings.empty());
}

TEST_F(ReadCase, modelAndGridInSpace) {
  const Case c = read(full_solid_case);
  EXPECT_EQ(c.space, Space::solid);
  EXPECT_EQ(c.kinematics, Kinematics::small);
  EXPECT_EQ(c.formulation, Formulation::total_lagrangian);
  EXPECT_EQ(c.gravity.at(1.0), Vec3(0.0, 0.0, -9.81));
  const auto& grid = std::get<StructuredGrid>(c.grid);
  EXPECT_EQ(grid.kind, GridKind::tetrahedra);
  EXPECT_EQ(grid.origin, Vec3(-0.1, -0.2, -0.3));
  EXPECT_EQ(grid.nx, 4);
  EXPECT_EQ(grid.ny, 5);
  EXPECT_EQ(grid.nz, 6);
  EXPECT_LT((grid.cell_size - Vec3(0.1, 0.1, 0.2)).norm(), 1e-16);
  EXPECT_NEAR(grid.angle, 30.0 * degree, 1e-15);
}

TEST_F(ReadCase, solidShapesInAllForms) {
  const Case c = read(full_solid_case);
  ASSERT_EQ(c.bodies.size(), 6u);
  const auto form = [&](std::size_t i) { return std::get<SolidShape>(*c.bodies[i].shape).form; };
  const auto cylinder = std::get<Cylinder>(form(0));
  EXPECT_EQ(cylinder.from, Vec3(0.0, 0.0, -0.05));
  EXPECT_EQ(cylinder.to, Vec3(0.0, 0.0, 0.05));
  EXPECT_EQ(cylinder.radius, 0.025);
  const auto sphere = std::get<Sphere>(form(1));
  EXPECT_EQ(sphere.centre, Vec3(0.1, 0.2, 0.3));
  EXPECT_EQ(sphere.radius, 0.05);
  EXPECT_EQ(std::get<SurfaceFile>(form(2)).path, path("mesh/rock.stl"));
  EXPECT_FALSE(c.bodies[3].shape);
  EXPECT_EQ(c.bodies[3].mesh_file, path("mesh/frame.msh"));
  EXPECT_EQ(c.bodies[3].mesh_group, "core");
  const auto difference = std::get<SolidCombination>(form(4));
  EXPECT_EQ(difference.kind, SolidCombination::Kind::difference);
  const auto& extrusion = std::get<Extrusion>(difference.parts[0].form);
  ASSERT_EQ(extrusion.vertices.size(), 3u);
  EXPECT_EQ(extrusion.vertices[2], Vec2(0.1, 0.3));
  EXPECT_EQ(extrusion.from, -0.1);
  EXPECT_EQ(extrusion.to, 0.2);
  const auto& join = std::get<SolidCombination>(difference.parts[1].form);
  EXPECT_EQ(join.kind, SolidCombination::Kind::join);
  EXPECT_EQ(std::get<SolidBox>(join.parts[0].form).min, Vec3(0.1, 0.1, -0.2));
  EXPECT_EQ(std::get<Sphere>(join.parts[1].form).radius, 0.01);
  EXPECT_TRUE(c.bodies[5].rigid);
  EXPECT_EQ(std::get<SolidBox>(form(5)).max, Vec3(0.05, 0.05, 0.06));
  EXPECT_EQ(c.bodies[5].displacement.at(1.0), Vec3(0.0, 1e-3, -1e-4));
}

TEST_F(ReadCase, pointsAndMeshesInSpace) {
  const Case c = read(full_solid_case);
  const PointSeeding& core = c.bodies[0].points;
  EXPECT_EQ(core.kind, PointSeeding::Kind::mesh);
  EXPECT_EQ(core.mesh.kind, BodyMeshKind::hexahedra);
  EXPECT_TRUE(core.mesh.structured);
  EXPECT_EQ(core.per_element, 8);
  EXPECT_EQ(c.bodies[0].mesh.kind, BodyMeshKind::hexahedra);
  EXPECT_EQ(c.bodies[0].mesh.size, 0.005);
  const PointSeeding& ball = c.bodies[1].points;
  EXPECT_EQ(ball.mesh.kind, BodyMeshKind::tetrahedra);
  EXPECT_FALSE(ball.mesh.structured);
  EXPECT_EQ(ball.mesh.order, 2);
  EXPECT_EQ(ball.per_element, 1);
  EXPECT_EQ(c.bodies[1].mesh.kind, BodyMeshKind::tetrahedra);
  EXPECT_FALSE(c.bodies[1].mesh.structured);
  EXPECT_EQ(c.bodies[2].points.kind, PointSeeding::Kind::grid);
  EXPECT_EQ(c.bodies[3].points.per_element, 27);
  EXPECT_EQ(c.bodies[4].points.per_direction, 3);
  EXPECT_EQ(c.bodies[4].points.placement, PointSeeding::Placement::uniform);
  const Case tetrahedra = read(small_solid_case + "points = { mesh = \"tetrahedra\", size = 0.05 }\n");
  EXPECT_EQ(tetrahedra.bodies[0].points.per_element, 4);
  EXPECT_FALSE(tetrahedra.bodies[0].points.mesh.structured);
}

TEST_F(ReadCase, loadsAndOutputInSpace) {
  const Case c = read(full_solid_case);
  ASSERT_EQ(c.boundaries.size(), 2u);
  EXPECT_EQ(*c.boundaries[0].where.min, Vec3(-1.0, -1.0, -0.06));
  EXPECT_EQ(*c.boundaries[0].where.max, Vec3(1.0, 1.0, -0.04));
  EXPECT_EQ(c.boundaries[0].u[0], TimeFunction(0.0));
  EXPECT_FALSE(c.boundaries[0].u[1]);
  EXPECT_EQ(c.boundaries[0].u[2], TimeFunction(-0.002));
  EXPECT_EQ(c.boundaries[1].where.group, "side");
  EXPECT_EQ(c.pins[0].at, Vec3(0.0, 0.0, 0.01));
  EXPECT_EQ(c.pins[0].fixed, (std::array{true, false, true}));
  EXPECT_EQ(c.pressures[0].where.sector->centre, Vec2(0.0, 0.0));
  EXPECT_EQ(c.contacts[0].kind, Contact::Kind::shared_nodes);
  EXPECT_EQ(c.solver.linear, Solver::Linear::iterative);
  EXPECT_EQ(c.solver.linear_tolerance, 1e-9);
  EXPECT_EQ(c.checkpoint.every_steps, 5);
  EXPECT_EQ(c.checkpoint.every_minutes, 2.5);
  EXPECT_EQ(c.parallel.rebalance, 1.5);
  EXPECT_EQ(c.output.nominal.direction, Vec3(0.0, 0.0, -1.0));
  EXPECT_EQ(c.output.gauges[0].from, Vec3(0.0, 0.0, -0.05));
  EXPECT_EQ(c.output.gauges[0].to, Vec3(0.0, 0.0, 0.05));
  EXPECT_EQ(c.output.probes[0].at, Vec3(0.0, 0.0, 0.01));
  EXPECT_EQ(c.output.probes[0].quantity, Quantity::stress_zx);
  EXPECT_EQ(c.output.probes[1].quantity, Quantity::displacement_z);
}

TEST_F(ReadCase, pinsHoldAnyDirections) {
  for (const char* word : {"x", "y", "xy", "z", "xz", "yz", "xyz"}) {
    const std::string fix = word;
    const Case c = read(small_solid_case + "[pin.a]\nbody = \"block\"\nat = [0.5, 0.5, 0.5]\nfix = \"" + fix + "\"\n");
    for (std::size_t i = 0; i < 3; ++i) EXPECT_EQ(c.pins[0].fixed[i], fix.find("xyz"[i]) != std::string::npos) << fix;
  }
}

TEST_F(ReadCase, axisymmetricModelMayComeLastInTheFile) {
  const Case c = read(axisymmetric_case);
  EXPECT_EQ(c.space, Space::axisymmetric);
  EXPECT_EQ(c.dimension(), 2);
  EXPECT_EQ(c.output.probes[0].quantity, Quantity::strain_zz);
  EXPECT_EQ(c.resolved.find("thickness"), std::string::npos);
}

TEST_F(ReadCase, modelInSpaceMayComeLastInTheFile) {
  std::string text = small_solid_case;
  const std::size_t end = text.find("[grid]");
  const Case first = read(text);
  const Case second = read(text.substr(end) + text.substr(0, end));
  EXPECT_EQ(describe(first), describe(second));
}

TEST_F(ReadCase, dimensionFromAnOverrideAndFromABase) {
  write("base.toml", "[model]\ndimension = 3\n");
  std::string text = small_solid_case;
  text.erase(text.find("dimension"), text.find("gravity") - text.find("dimension"));
  EXPECT_EQ(read("base = \"base.toml\"\n" + text).space, Space::solid);
  EXPECT_EQ(read(text, {"model.dimension=3"}).space, Space::solid);
}

TEST_F(ReadCase, resolvedCopyIsTheSameCaseFromAnotherFolder) {
  for (const std::string& text : {small_case, full_case, "method = \"fem\"\n" + small_case + "mesh.size = 0.1\n",
                                  small_solid_case, full_solid_case, axisymmetric_case}) {
    const Case first = read(text);
    const Case second = read_case(write("elsewhere/copy.toml", first.resolved));
    EXPECT_EQ(describe(first), describe(second));
    EXPECT_EQ(first.resolved, second.resolved);
  }
}

TEST_F(ReadCase, resolvedCopyStatesDefaults) {
  const std::string text = read(small_case).resolved;
  for (const char* line :
       {"method = \"mpm\"", "thickness = 1.0", "count = 100", "max_iterations = 25", "crack_band = \"sqrt_area\"",
        "points = { per_direction = 2, placement = \"automatic\" }", "kind = \"time\""}) {
    EXPECT_NE(text.find(line), std::string::npos) << line << "\n" << text;
  }
}

TEST_F(ReadCase, resolvedCopyKeepsTheAngleExactly) {
  const Case first = read(small_case, {"grid.angle=0.5 rad"});
  EXPECT_EQ(std::get<StructuredGrid>(first.grid).angle, 0.5);
  EXPECT_EQ(describe(first), describe(read(first.resolved)));
}

/// Sweep files list variants of cases.
bool is_sweep(const std::filesystem::path& path) {
  std::ifstream file(path);
  for (std::string line; std::getline(file, line);)
    if (line.starts_with("[variant.")) return true;
  return false;
}

TEST_F(ReadCase, examplesAreRead) {
  int n = 0;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(BERM_SOURCE_DIR "/examples")) {
    if (entry.path().extension() != ".toml" || is_sweep(entry.path())) continue;
    const Case first = read_case(entry.path().string());
    const Case second = read_case(write("copy.toml", first.resolved));
    EXPECT_EQ(describe(first), describe(second)) << entry.path();
    ++n;
  }
  EXPECT_GT(n, 0);
}

TEST_F(ReadCase, gridFromAFile) {
  write("sub/grid.msh", "");
  std::string text = small_case;
  text.replace(text.find("cell_size"), text.find("[material") - text.find("cell_size"), "file = \"sub/grid.msh\"\n\n");
  EXPECT_EQ(std::get<std::string>(read(text).grid), path("sub/grid.msh"));
}

TEST_F(ReadCase, suspiciousUnitsAreWarnings) {
  std::string text = small_case;
  text.replace(text.find("1e7"), 3, "35.5");
  text.replace(text.find("1900.0"), 6, "1.9");
  const std::vector<std::string> warnings = read(text).warnings;
  ASSERT_EQ(warnings.size(), 2u);
  EXPECT_EQ(warnings[0], path("case.toml") + ":10:11: density = 1.9 kg/m3: did you mean t/m3 or g/cm3?");
  EXPECT_EQ(warnings[1], path("case.toml") + ":11:18: youngs_modulus = 35.5 Pa: did you mean GPa?");
}

TEST_F(ReadCase, otherWarnings) {
  const std::string extra =
      "[material.spare]\nlaw = \"linear_elastic\"\ndensity = 2000\nyoungs_modulus = 1e9\npoisson_ratio = 0\n"
      "[output]\nreferences = [\"absent.csv\"]\n";
  std::string text = small_case + extra;
  text.replace(text.find("max = [1.0"), 10, "max = [1500.0");
  std::string all;
  for (const std::string& warning : read(text).warnings) all += warning + "\n";
  EXPECT_NE(all.find("is 1500 m long: did you mean mm?"), std::string::npos) << all;
  EXPECT_NE(all.find("[material.spare] is not used by any body"), std::string::npos) << all;
  EXPECT_NE(all.find("\"absent.csv\" does not exist"), std::string::npos) << all;
}

TEST_F(ReadCase, everySolidFormMayBeTooLarge) {
  std::string far = tetrahedron_stl;
  while (far.find(" 1 0 0 ") != std::string::npos) far.replace(far.find(" 1 0 0 "), 7, " 1500 0 0 ");
  write("far.stl", far);
  const auto first_warning = [&](const std::string& shape) {
    std::string text = small_solid_case;
    text.replace(text.find("shape.box"), std::string::npos, "shape." + shape + "\n");
    const std::vector<std::string> warnings = read(text).warnings;
    return warnings.empty() ? "" : warnings[0];
  };
  for (const char* shape :
       {"box = { min = [0, 0, -1500], max = [1, 1, 0] }", "sphere = { centre = [0, 0, 0], radius = 750 }",
        "cylinder = { from = [0, 0, 0], to = [0, 0, 1], radius = 750 }",
        "cylinder = { from = [-1500, 0, 0], to = [0, 0, 0], radius = 1 }",
        "extrusion = { polygon = [[0, 0], [1500, 0], [0, 1]], from = 0, to = 1 }",
        "extrusion = { polygon = [[0, 0], [1, 0], [0, 1]], from = 0, to = 1500 }",
        "union = [{ sphere = { centre = [0, 0, 0], radius = 1 } }, { sphere = { centre = [1498, 0, 0], radius = 1 } }]",
        "surface = \"far.stl\""}) {
    EXPECT_NE(first_warning(shape).find("is 1500 m long: did you mean mm?"), std::string::npos) << shape;
  }
  EXPECT_EQ(first_warning("cylinder = { from = [-950, 0, 0], to = [0, 0, 0], radius = 475 }"), "");
  EXPECT_EQ(first_warning("box = { min = [500000, 4600000, 0], max = [500001, 4600001, 1] }"), "");  // on a map
  EXPECT_EQ(first_warning("difference = [{ sphere = { centre = [0, 0, 0], radius = 1 } }, { box = { min = [0, -1500, -1500], max = [1500, 1500, 1500] } }]"), "");
}

TEST_F(ReadCase, everyLawOfTheListIsReadable) {
  for_each_law([&]<class L>(L) {
    std::string material = "law = \"" + std::string(L::name) + "\"\ndensity = 2000.0\n";
    for (const auto& p : L::parameters()) {
      if (p.default_value) continue;
      const bool modulus = p.key == "youngs_modulus";
      const double value = modulus             ? 3e10
                           : p.range.max < 1e6 ? 0.25 * (p.range.max + 3.0 * std::max(p.range.min, 0.0))
                                               : 1e3 + std::max(p.range.min, 0.0);
      material += p.key + " = " + fmt::format("{:.17g}", value / (p.unit == Unit::angle ? degree : 1.0)) + "\n";
    }
    std::string text = small_case;
    text.replace(text.find("law ="), text.find("[body") - text.find("law ="), material + "\n");
    if (errors(text).find("give one of tensile_strength") !=
        std::string::npos) {  // optional keys that exclude each other
      text.replace(text.find("law ="), 0, "tensile_strength = 1e6\n");
    }
    EXPECT_EQ(errors(text), "") << text;
    EXPECT_TRUE(std::holds_alternative<L>(read(text).materials.at(0).law));
  });
}

}  // namespace
}  // namespace berm
