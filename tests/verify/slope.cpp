/// Slopes that fail under their own weight: factor of safety by reduction of the strength (Griffiths and Lane 1999,
/// example 1), and the height of a vertical cut in clay without drainage.

#include <fmt/format.h>

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

/// Does it carry all of its weight?
bool stands(const Mesh& mesh, double F) {
  Model model(slope(mesh, F));
  const bool done = model.run();
  fmt::print("  {}: F = {:.4f}: {} at {:.3f} of the weight, plastic strain {:.3g}\n", mesh.name, F,
             done ? "stands" : "fails", model.world->time, model.material().max_plastic_strain());
  return done;
}

void factor_of_safety(const Mesh& mesh, double least, double most) {
  double low = 1.0, high = 2.0;
  ASSERT_TRUE(stands(mesh, low));
  ASSERT_FALSE(stands(mesh, high));
  while (high - low > 0.04) {
    const double middle = 0.5 * (low + high);
    (stands(mesh, middle) ? low : high) = middle;
  }
  const double F = 0.5 * (low + high);
  EXPECT_GT(F, least) << mesh.name;
  EXPECT_LT(F, most) << mesh.name;
  record({"Slopes (V23)", fmt::format("{}: factor of safety, within 0.016", mesh.name), F, "1.4",
          fmt::format("{} to {}", least, most),
          "Griffiths and Lane 1999, finite elements; 1.380 by the charts of Bishop and Morgenstern (1960)"});
}

TEST(Slope, FactorOfSafety) {
  factor_of_safety({"2:1 slope, fem, quad8 of 2 m", "fem", "quads", 2, 2.0}, 1.3, 1.5);
  factor_of_safety({"2:1 slope, fem, quad4 of 1 m", "fem", "quads", 1, 1.0}, 1.3, 1.5);
  factor_of_safety({"2:1 slope, mpm, quads of 2 m", "mpm", "quads", 1, 2.0}, 1.3, 1.6);
  factor_of_safety({"2:1 slope, mpm, quads of 1 m", "mpm", "quads", 1, 1.0}, 1.3, 1.5);
}

/// Vertical cut, 10 m, Tresca: gravity grows until it falls; the last equilibrium gives gamma H / cu.
double vertical_cut(const Mesh& mesh) {
  constexpr double strength = 20e3, height = 10.0, density = 2000.0, most = 6.0;
  std::string text =
      common(mesh) +
      body(mesh, 40.0, 20.0, "[[0.0, 0.0], [40.0, 0.0], [40.0, 10.0], [20.0, 10.0], [20.0, 20.0], [0.0, 20.0]]") +
      fmt::format(
          "[boundary.front]\nwhere.box.min = [{}, -1.0]\nux = 0.0\n"
          "[material.soil]\nlaw = \"mohr_coulomb\"\ndensity = {}\nyoungs_modulus = 1e8\npoisson_ratio = 0.3\n"
          "cohesion = {}\nfriction_angle = 0.0\n",
          40.0 - 1e-6, density, strength);
  Model model(text, {fmt::format("model.gravity=[0.0, {}]", -most * strength / (density * height)), "steps.count=24",
                     "steps.min_fraction=0.05"});
  EXPECT_FALSE(model.run());
  return most * model.world->time;
}

TEST(Slope, VerticalCut) {
  for (const Mesh& mesh : {Mesh{"fem, quad8 of 1 m", "fem", "quads", 2, 1.0},
                           {"fem, quad4 of 1 m", "fem", "quads", 1, 1.0},
                           {"mpm, quads of 1 m", "mpm", "quads", 1, 1.0},
                           {"mpm, quads of 0.5 m", "mpm", "quads", 1, 0.5}}) {
    const double N = vertical_cut(mesh);
    fmt::print("  {}: {:.4f}\n", mesh.name, N);
    EXPECT_GT(N, 3.6) << mesh.name;
    EXPECT_LT(N, 4.6) << mesh.name;
    record({"Slopes (V23)", fmt::format("vertical cut in clay, {}: gamma H / cu at failure", mesh.name), N, "3.78",
            "reported, 3.6 to 4.6", "limit analysis"});
  }
}

}  // namespace
}  // namespace berm::verify
