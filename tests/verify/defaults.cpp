/// Everyday problems as somebody poses them who knows no option: only the defaults decide how they are computed.
/// [docs/adr/0016, docs/defaults.md]

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <tuple>

#include "driver.hpp"

namespace berm::verify {
namespace {

/// Force of the first boundary (or rigid body) with that name on the material.
Vec3 support_force(const Model& m, const std::string& name) {
  const Case& c = m.world->spec;
  for (std::size_t b = 0; b < c.boundaries.size(); ++b)
    if (c.boundaries[b].name == name) return m.step.balance().reactions.boundary[b];
  for (std::size_t b = 0; b < c.bodies.size(); ++b)
    if (c.bodies[b].name == name) return m.step.balance().reactions.rigid[b];
  ADD_FAILURE() << "no support " << name;
  return Vec3::Zero();
}

const std::string squeezed_block = R"(
model.plane = "stress"
grid = { origin = [-0.1, 0.0], cell_size = 0.1, cells = [12, 11] }
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 1e9
poisson_ratio = 0.0
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
[boundary.base]
where.box = { max = [1e3, 1e-6] }
uy = 0.0
[pin.p]
body = "b"
at = [0.5, 0.0]
fix = "x"
[boundary.top]
body = "b"
where.box = { min = [-1e3, 0.999] }
uy = -0.1
[steps]
count = 10
)";

/// Linear functions lose a third of the force when points cross cells: Hencky's law, E ln(l) / l.
TEST(Defaults, SqueezedBlock) {
  Model m(case_by_default(squeezed_block));
  ASSERT_TRUE(m.run());
  const double expected = 1e9 * std::log(0.9) / 0.9, force = support_force(m, "top").y();
  record({"Defaults", "block squeezed by 10 %, force [N]", force, "E ln(0.9) / 0.9", "1 %", "closed form"});
  EXPECT_LT(relative(force, expected), 0.01);
}

const std::string pressed_block = R"(
[grid]
cell_size = 0.005
cells = [16, 22]
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "20 MPa"
poisson_ratio = 0.3
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [0.05, 0.1] }
[body.platen]
rigid = true
shape.box = { min = [-0.01, 0.1], max = [0.07, 0.105] }
displacement = [0.0, -0.005]
[contact.top]
body = "b"
rigid = "platen"
kind = "frictionless"
[boundary.axis]
where.box.max = [1e-6, 1.0]
ux = 0.0
[boundary.base]
where.box.max = [1.0, 1e-6]
uy = 0.0
[steps]
count = 20
)";

/// The surface stays in its cell when the topmost points leave it: what it feels belongs to the cells that carry.
TEST(Defaults, PressedBlock) {
  // Force per width at the start; the sides swell by the root of 1 / 0.95^(nu / (1 - nu)) in plane strain.
  const double expected = 20e6 / (1.0 - 0.09) * std::log(1.0 / 0.95) / 0.95;
  Model m(case_by_default(pressed_block));
  ASSERT_TRUE(m.run());
  const double stress = -support_force(m, "platen").y() / 0.05;
  record({"Defaults", "block pressed by 5 %, nominal stress [Pa]", stress, "E/(1-nu2) ln(1/0.95)/0.95", "1 %", "closed form"});
  EXPECT_LT(relative(stress, expected), 0.01);

  // Linear functions lose some of it where points cross cells, but no longer half.
  Model linear(case_by_default(pressed_block, {"grid.shape_functions=linear"}));
  ASSERT_TRUE(linear.run());
  EXPECT_LT(relative(-support_force(linear, "platen").y() / 0.05, expected), 0.1);
}

const std::string touching = R"(
[model]
kinematics = "small"
[grid]
cell_size = 0.1
cells = [20, 10]
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "10 MPa"
poisson_ratio = 0.3
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [2.0, 1.0] }
[boundary.door]
body = "b"
where.box = { min = [-0.01, -0.001], max = [1.0, 0.001] }
ux = 0.0
uy = -0.001
[boundary.floor]
body = "b"
where.box = { min = [1.0, -0.001], max = [2.1, 0.001] }
ux = 0.0
uy = 0.0
[steps]
count = 1
)";

/// Two held surfaces that touch and move differently fought over the nodes that they share: -723 kN. What is free between
/// them is two cells, so the force is that of nodes that are held up to there.
TEST(Defaults, HalfOfABaseSinks) {
  Model m(case_by_default(touching));
  ASSERT_TRUE(m.run());
  const double force = support_force(m, "door").y();

  std::string by_nodes = touching;
  for (const auto& [from, to] : {std::pair<std::string, std::string>{"body = \"b\"\nwhere.box = { min = [-0.01, -0.001], max = [1.0, 0.001] }",
                                                                     "where.box = { min = [-0.01, -0.001], max = [0.901, 0.001] }"},
                                 {"body = \"b\"\nwhere.box = { min = [1.0, -0.001]", "where.box = { min = [1.099, -0.001]"}})
    by_nodes.replace(by_nodes.find(from), from.size(), to);
  Model nodes(case_by_default(by_nodes));
  ASSERT_TRUE(nodes.run());
  const double expected = support_force(nodes, "door").y();
  record({"Defaults", "half of a base sinks by 1 mm, its force [N]", force, fmt::format("{:.0f}", expected), "10 %",
          "nodes held but for two cells"});
  EXPECT_LT(relative(force, expected), 0.1);
  const auto& warnings = m.world->warnings;
  EXPECT_TRUE(std::any_of(warnings.begin(), warnings.end(),
                          [](const std::string& w) { return w.find("move differently") != std::string::npos; }));
}

const std::string friction_floor = R"(
model.gravity = [0.0, -10.0]
grid = { origin = [-2.0, -3.0], cell_size = 0.25, cells = [24, 24] }
[material.m]
law = "linear_elastic"
youngs_modulus = 1e7
poisson_ratio = 0.3
density = 1000.0
[body.b]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 1.0] }
[body.floor]
rigid = true
shape.box = { min = [-1.5, -1.0], max = [2.5, -0.03] }
[contact.c]
body = "b"
rigid = "floor"
kind = "friction"
friction = 0.3
[steps]
analysis = "dynamic"
duration = 0.2
count = 100
[dynamics]
integrator = "bossak"
transfer = "blend"
[solver]
ghost_penalty = 0.0
)";

/// Nodes that only surface points reached had neither mass nor stiffness, and the matrix no inverse.
TEST(Defaults, NodesThatCarryNothingAreNoUnknowns) {
  for (const char* functions : {"linear", "cpgimp"}) {
    Model m(case_by_default(friction_floor, {"grid.shape_functions=" + std::string(functions)}));
    EXPECT_TRUE(m.run()) << functions;
    EXPECT_NEAR(m.world->discretisation->point_displacements()[0].y(), -0.03, 0.01) << functions;
  }
}

/// A block of 2 GPa that is thrown up an incline with friction chatters: points open and close. All its heat is booked.
TEST(Defaults, HeatOfABlockThrownUpAnIncline) {
  Model m(case_by_default(R"(
model.gravity = ["-9.81*0.422618", "-9.81*0.906308"]
grid = { origin = [-0.5, -0.25], cell_size = 0.25, cells = [12, 5] }
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = 2e8
poisson_ratio = 0.3
[body.block]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 0.5] }
velocity = [4.0, 0.0]
[body.plane]
rigid = true
shape.box = { min = [-1.0, -0.5], max = [4.0, 0.0] }
[contact.c]
body = "block"
rigid = "plane"
kind = "friction"
friction = 0.2
[steps]
analysis = "dynamic"
duration = 0.6
count = 120
)"));
  ASSERT_TRUE(m.run());
  // x = v t - g (sin + mu cos) t^2 / 2 until it stands, and what friction took on that way.
  const double a = 9.81 * (0.422618 + 0.2 * 0.906308), way = 4.0 * 0.6 - 0.5 * a * 0.36, heat = 0.2 * 500.0 * 9.81 * 0.906308 * way;
  const Balance& b = m.step.balance();
  record({"Defaults", "block thrown up an incline, heat of friction [J]", b.friction_work, "mu N s", "2 %", "Coulomb"});
  EXPECT_LT(relative(b.friction_work, heat), 0.02);
}

/// Square elements of a file on a grid that they do not fit.
std::string mesh_of_squares(int n) {
  const std::string path = scratch_file(fmt::format("squares_{}.msh", n));
  std::ofstream out(path);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << (n + 1) * (n + 1) << "\n";
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) out << fmt::format("{} {} {} 0\n", j * (n + 1) + i + 1, double(i) / n, double(j) / n);
  out << "$EndNodes\n$Elements\n" << n * n << "\n";
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const int a = j * (n + 1) + i + 1;
      out << fmt::format("{} 3 2 1 1 {} {} {} {}\n", j * n + i + 1, a, a + 1, a + n + 2, a + n + 1);
    }
  out << "$EndElements\n";
  return path;
}

/// With the functions of small strain so far, linear ones, a block was up to a fifth too soft or too stiff without a word, and 8 times too soft where cells
/// were empty, of which nothing was said.
TEST(Defaults, PointsOfAMeshFileFillTheCells) {
  const auto shortening = [](int n, int per_element) {
    Model m(case_by_default(fmt::format(R"(
model.kinematics = "small"
grid = {{ cell_size = 0.1, cells = [12, 12] }}
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = 1e9
poisson_ratio = 0.2
[body.b]
material = "m"
file = "{}"
points.per_element = {}
[boundary.base]
where.box.max = [2.0, 1e-6]
uy = 0.0
[boundary.left]
where.box.max = [1e-6, 2.0]
ux = 0.0
[pressure.top]
body = "b"
where.box.min = [-1.0, 0.999]
value = 1e5
[gauge.g]
from = [0.05, 0.05]
to = [0.05, 0.95]
[steps]
count = 1
)",
                                        mesh_of_squares(n), per_element)));
    EXPECT_TRUE(m.run());
    EXPECT_EQ(n == 3, std::any_of(m.world->warnings.begin(), m.world->warnings.end(), [](const std::string& w) { return w.find("some have no point") != w.npos; }));
    return -m.world->boundary->gauges()[0].elongation();
  };
  const double exact = 0.9 * 1e5 * (1.0 - 0.2 * 0.2) / 1e9;  // plane strain, free to widen
  for (const auto& [n, per_element, tolerance] : {std::tuple(5, 9, 0.02), std::tuple(8, 4, 0.02), std::tuple(5, 4, 0.02), std::tuple(3, 9, 0.04)}) {
    const double reached = shortening(n, per_element);
    EXPECT_LT(relative(reached, exact), tolerance) << n << " x " << n << " elements of " << per_element << " points: " << reached;
    record({"Defaults", fmt::format("block of {0} x {0} elements of a file with {1} points each on 10 x 10 cells: shortening", n, per_element), reached, fmt::format("{:.6g}", exact),
            fmt::format("{}", tolerance), "uniform stress"});
  }
}

}  // namespace
}  // namespace berm::verify
