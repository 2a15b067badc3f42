/// Mistakes that were made once: each of these failed before it was mended.

#include <filesystem>
#include <fstream>

#include "base/error.hpp"
#include "driver.hpp"
#include "sim/run.hpp"

namespace berm::verify {
namespace {

const std::string block = R"(
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e6
poisson_ratio = 0.3
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
mesh = { size = 0.25, structured = true }
[boundary.base]
where.box = { min = [-1.0, -1e-6], max = [2.0, 1e-6] }
ux = 0.0
uy = 0.0
[steps]
count = 4
)";

const std::string platen = R"(
[grid]
origin = [-0.5, 0.0]
cell_size = 0.25
cells = [8, 6]
[body.platen]
rigid = true
shape.box = { min = [0.0, 1.0], max = [1.0, 1.25] }
displacement = [0.0, -0.01]
[contact.top]
body = "b"
rigid = "platen"
)";

const std::string nominal = R"(
[output.nominal]
load = "platen"
displacement = "platen"
)";

double energy_error(const Model& m) {
  const double work = m.step.balance().external_work;
  return std::abs(work - m.material().stored_energy() - m.material().dissipated_energy()) / work;
}

/// Nodes held by a boundary and moved by a rigid body were counted in both reactions.
TEST(Regression, NodesOfABoundaryAndOfARigidBodyCountOnce) {
  Model m("method = \"mpm\"\n[model]\nkinematics = \"small\"\n" + block + platen + nominal +
              "[boundary.sides]\nwhere.box = { min = [-1.0, 0.9], max = [2.0, 2.0] }\nuy = -0.01\n",
          {"contact.top.kind=shared_nodes"});
  ASSERT_TRUE(m.run());
  EXPECT_LT(energy_error(m), 1e-6);
}

/// What the springs of pins stored was missing.
TEST(Regression, WhatPinsStoreIsInTheBalance) {
  const std::string held = block.substr(0, block.find("[boundary.base]")) + block.substr(block.find("[steps]"));
  Model m("method = \"mpm\"\n[model]\nkinematics = \"small\"\n[grid]\norigin = [-0.5, -0.5]\ncell_size = 0.25\ncells = [8, 8]\n" + held + R"(
[pin.left]
body = "b"
at = [0.0, 0.0]
fix = "xy"
[pin.right]
body = "b"
at = [1.0, 0.0]
fix = "y"
[pressure.top]
body = "b"
where.box.min = [-1.0, 0.999]
value = 1e4
)");
  ASSERT_TRUE(m.run());
  const double work = m.step.balance().external_work, kept = m.step.balance().contact_work;
  // Two pins with half of the load of 10 kN each and springs of E t: 2 x (5 kN)^2 / (2 x 1 MN/m)
  EXPECT_NEAR(kept, 25.0, 0.25);
  EXPECT_NEAR(work - m.material().stored_energy(), kept, 1e-6 * work);
}

/// Two boundaries that disagree about a node: the last one won silently.
TEST(Regression, BoundariesThatDisagreeAreRefused) {
  const std::string text = "method = \"fem\"\n" + block +
                           "[output.nominal]\nload = \"base\"\ndisplacement = \"base\"\n" +
                           "[boundary.again]\nwhere.box = { min = [-1.0, -1e-6], max = [2.0, 1e-6] }\nuy = -0.01\n";
  EXPECT_THROW(Model m(text), InputError);
  EXPECT_NO_THROW(Model m(text, {"boundary.again.uy=0.0"}));
}

/// Edges of two physical curves kept only one of the names.
TEST(Regression, EdgesBelongToAllTheirCurves) {
  const std::string mesh = scratch_file("curves.msh");
  std::ofstream(mesh)
      << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n3\n1 1 \"aload\"\n1 2 \"top\"\n2 3 \"b\"\n"
         "$EndPhysicalNames\n$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n$EndNodes\n$Elements\n3\n"
         "1 1 2 1 11 3 4\n2 1 2 2 12 3 4\n3 3 2 3 13 1 2 3 4\n$EndElements\n";
  std::string text = "method = \"fem\"\n" + block +
                     "[pressure.p]\nbody = \"b\"\nvalue = 1e3\n[output.nominal]\nload = \"p\"\n"
                     "displacement = \"base\"\n";
  const std::size_t shape = text.find("shape.box"), mesh_key = text.find("mesh = {");
  text.replace(shape, text.find('[', mesh_key + 1) - shape, "file = \"" + mesh + "\"\n");
  for (const char* group : {"aload", "top"}) {
    Model m(text, {std::string("pressure.p.where.group=") + group, "pressure.p.direction=dead"});
    ASSERT_TRUE(m.run());
    EXPECT_NEAR(m.step.balance().pressure_force[0].y(), -1e3, 1e-9);
  }
}

/// The first mesh file of an MPM run was empty, and files of an earlier run stayed in the folder.
TEST(Regression, OutputFolderHoldsThisRunOnly) {
  const std::filesystem::path folder = scratch_file("out");
  const std::string text = "method = \"mpm\"\n" + block + platen + nominal + "[output]\nframes = 4\n";
  run_case(case_of(text), {folder, true, {}});
  EXPECT_GT(std::filesystem::file_size(folder / "mesh_0000.vtu"),
            0.5 * std::filesystem::file_size(folder / "mesh_0004.vtu"));
  EXPECT_TRUE(std::filesystem::exists(folder / "points_0004.vtu"));
  run_case(case_of(text, {"output.frames=1", "steps.count=1"}), {folder, true, {}});
  EXPECT_FALSE(std::filesystem::exists(folder / "points_0004.vtu"));
  EXPECT_TRUE(std::filesystem::exists(folder / "summary.json"));
}

/// A probe far outside gave the value of the nearest point.
TEST(Regression, PlacesOutsideOfTheBodiesAreRefused) {
  const std::string text = "method = \"mpm\"\n" + block + platen + nominal;
  EXPECT_THROW(Model m(text + "[probe.far]\nat = [-9.0, 9.0]\nquantity = \"stress_xx\"\n"), InputError);
  EXPECT_THROW(Model m(text + "[gauge.far]\nfrom = [0.0, 0.5]\nto = [1.9, 0.5]\n"), InputError);
  EXPECT_NO_THROW(Model m(text + "[gauge.near]\nfrom = [0.0, 0.5]\nto = [1.0, 0.5]\n"));
}

}  // namespace
}  // namespace berm::verify
