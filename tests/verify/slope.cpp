/// Slopes that fail under their own weight: factor of safety by reduction of the strength (Griffiths and Lane 1999,
/// example 1), and the height of a vertical cut in clay without drainage.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

struct Mesh {
  std::string name, method, kind;
  int order;
  double size;  ///< [m]
};

std::string common(const Mesh& mesh) {
  return fmt::format(R"(
method = "{}"
[model]
kinematics = "small"
gravity = [0.0, -10.0]
[steps]
count = 10
min_fraction = 0.02
[solver]
max_iterations = 30
)",
                     mesh.method);
}

std::string body(const Mesh& mesh, double width, double height, const std::string& polygon) {
  return fmt::format("[grid]\nkind = \"{}\"\ncell_size = {}\ncells = [{}, {}]\n",
                     mesh.kind == "triangles" ? "union_jack" : "quads", mesh.size, std::lround(width / mesh.size) + 1,
                     std::lround(height / mesh.size) + 1) +
         fmt::format("[body.soil]\nmaterial = \"soil\"\nshape.polygon = {}\n", polygon) +
         fmt::format("mesh = {{ kind = \"{}\", size = {}, order = {} }}\n", mesh.kind, mesh.size, mesh.order) +
         R"(
[boundary.base]
where.box.max = [1e3, 1e-6]
ux = 0.0
uy = 0.0
[boundary.back]
where.box.max = [1e-6, 1e3]
ux = 0.0
)";
}

/// 2:1, 10 m, c = 10 kPa, 20 deg, 20 kN/m3: c / (gamma H) = 0.05. Strength divided by F.
std::string slope(const Mesh& mesh, double F) {
  constexpr double degree = std::numbers::pi / 180.0;
  return common(mesh) + body(mesh, 32.0, 10.0, "[[0.0, 0.0], [32.0, 0.0], [12.0, 10.0], [0.0, 10.0]]") +
         fmt::format(
             "[material.soil]\nlaw = \"mohr_coulomb\"\ndensity = 2000.0\nyoungs_modulus = 1e8\npoisson_ratio = 0.3\n"
             "cohesion = {}\nfriction_angle = {}\ndilatancy_angle = 0.0\n",
             10e3 / F, std::atan(std::tan(20.0 * degree) / F) / degree);
}

struct Outcome {
  bool equilibrium;     ///< under all of the weight
  double displacement;  ///< largest of any point at the last equilibrium [m]
};

Outcome carry(const Mesh& mesh, double F) {
  Model model(slope(mesh, F));
  Outcome o{model.run(), 0.0};
  for (const Vec3& u : model.world->discretisation->point_displacements())
    o.displacement = std::max(o.displacement, u.norm());
  fmt::print("  {}: F = {:.4f}: equilibrium at {:.3f} of the weight, displacement {:.4f} m\n", mesh.name, F,
             model.world->time, o.displacement);
  return o;
}

/// Bisection to 0.02. A slope stands if it is in equilibrium and has moved no more than `jump` times as far as with its
/// whole strength; as `berm factor_of_safety`.
double factor_of_safety(const Mesh& mesh, double jump) {
  const Outcome whole = carry(mesh, 1.0);
  EXPECT_TRUE(whole.equilibrium);
  double low = 1.0, high = 2.25;
  while (high - low > 0.04) {
    const double middle = 0.5 * (low + high);
    const Outcome o = carry(mesh, middle);
    (o.equilibrium && o.displacement < jump * whole.displacement ? low : high) = middle;
  }
  EXPECT_LT(high, 2.25);
  return 0.5 * (low + high);
}

constexpr double three_times = 3.0;

void slope_row(const std::string& quantity, double F, double least, double most, const std::string& demanded) {
  EXPECT_GT(F, least) << quantity;
  EXPECT_LT(F, most) << quantity;
  record({"Slopes (V23)", fmt::format("2:1, {}: factor of safety, within 0.02", quantity), F, "1.4",
          fmt::format("{}{} to {}", demanded, least, most),
          "Griffiths and Lane 1999, quad8; charts of Bishop and Morgenstern 1960: 1.380"});
}

TEST(Slope, FactorOfSafetyOfQuadraticElements) {
  for (const double size : {2.0, 1.0}) {
    const std::string name = fmt::format("fem, quad8 of {:.0f} m", size);
    slope_row(name, factor_of_safety({name, "fem", "quads", 2, size}, three_times), 1.33, 1.45, "");
  }
}

/// Fully integrated linear functions lock: there is an equilibrium far beyond the true factor, but the displacements
/// tell where it is.
TEST(Slope, FactorOfSafetyOfLinearFunctions) {
  for (const double size : {1.0, 0.5}) {
    const std::string name = fmt::format("mpm, quads of {} m", size);
    slope_row(name, factor_of_safety({name, "mpm", "quads", 1, size}, three_times), 1.35, 1.55, "reported, ");
  }
  const std::string name = "mpm, quads of 1 m, by loss of equilibrium alone";
  slope_row(name, factor_of_safety({name, "mpm", "quads", 1, 1.0}, INFINITY), 1.35, 2.2, "reported, ");
}

/// Vertical cut, 10 m, Tresca: gravity grows until it falls; the last equilibrium gives gamma H / cu.
double vertical_cut(const Mesh& mesh) {
  constexpr double strength = 20e3, height = 10.0, density = 2000.0, most = 4.5;
  std::string text =
      common(mesh) +
      body(mesh, 40.0, 20.0, "[[0.0, 0.0], [40.0, 0.0], [40.0, 10.0], [20.0, 10.0], [20.0, 20.0], [0.0, 20.0]]") +
      fmt::format(
          "[boundary.front]\nwhere.box.min = [{}, -1.0]\nux = 0.0\n"
          "[material.soil]\nlaw = \"mohr_coulomb\"\ndensity = {}\nyoungs_modulus = 1e8\npoisson_ratio = 0.3\n"
          "cohesion = {}\nfriction_angle = 0.0\n",
          40.0 - 1e-6, density, strength);
  Model model(text, {fmt::format("model.gravity=[0.0, {}]", -most * strength / (density * height)), "steps.count=20",
                     "steps.min_fraction=0.05"});
  EXPECT_FALSE(model.run());
  return most * model.world->time;
}

/// Flow without any change of volume: linear functions lock altogether and carry any weight, which is not shown here.
TEST(Slope, VerticalCut) {
  const double N = vertical_cut({"fem, quad8 of 1 m", "fem", "quads", 2, 1.0});
  EXPECT_NEAR(N, 3.78, 0.04 * 3.78);
  record({"Slopes (V23)", "vertical cut in clay, fem, quad8 of 1 m: gamma H / cu at failure", N, "3.78", "4 %",
          "limit analysis"});
}

}  // namespace
}  // namespace berm::verify
