/// Volumetric locking of linear cells and F-bar (docs/theory/formulation.md, section 14): Cook's membrane and the bearing
/// capacity of a strip.

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "driver.hpp"

namespace berm::verify {
namespace {

// ---- Cook's membrane

constexpr int sides = 16;

/// The membrane (0,0) (48,44) (48,60) (0,44) as n x n quads, MSH 2.2.
std::string membrane_mesh(int n) {
  const std::string path = scratch_file("cook.msh");
  std::ofstream out(path);
  out << "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n" << (n + 1) * (n + 1) << "\n";
  for (int j = 0, k = 1; j <= n; ++j)
    for (int i = 0; i <= n; ++i, ++k) {
      const double x = 48.0 * i / n, low = 44.0 * i / n, high = 44.0 + 16.0 * i / n;
      out << fmt::format("{} {:.16g} {:.16g} 0\n", k, x, low + (high - low) * j / n);
    }
  out << "$EndNodes\n$Elements\n" << n * n << "\n";
  for (int j = 0, k = 1; j < n; ++j)
    for (int i = 0; i < n; ++i, ++k) {
      const int a = j * (n + 1) + i + 1;
      out << fmt::format("{} 3 2 1 1 {} {} {} {}\n", k, a, a + 1, a + n + 2, a + n + 1);
    }
  out << "$EndElements\n";
  return path;
}

struct Membrane {
  double youngs, poisson, shear;
  bool plane_stress = false;
};

/// fitted: the grid is a mesh of the membrane; else square cells that its slanted edges cut.
std::string membrane(const Membrane& m, bool fitted, bool f_bar) {
  std::string text = "[model]\nkinematics = \"small\"\n";
  text += fmt::format("plane = \"{}\"\nvolumetric = \"{}\"\n", m.plane_stress ? "stress" : "strain",
                      f_bar ? "f_bar" : "standard");
  text += fmt::format(
      "[material.m]\nlaw = \"linear_elastic\"\ndensity = 1.0\nyoungs_modulus = {}\npoisson_ratio = {:.17g}\n", m.youngs,
      m.poisson);
  text += "[body.b]\nmaterial = \"m\"\n";
  if (fitted) {
    const std::string path = membrane_mesh(sides);
    text += fmt::format("file = \"{}\"\npoints = {{ per_element = 4 }}\n[grid]\nfile = \"{}\"\n", path, path);
  } else {
    text += "shape.polygon = [[0.0, 0.0], [48.0, 44.0], [48.0, 60.0], [0.0, 44.0]]\n";
    text += fmt::format("[grid]\ncell_size = {}\ncells = [{}, {}]\n", 48.0 / sides, sides, 60 * sides / 48);
  }
  text += "[boundary.left]\nwhere.box.max = [1e-6, 100.0]\nux = 0.0\nuy = 0.0\n";
  text += fmt::format(
      "[pressure.right]\nbody = \"b\"\nwhere.box.min = [47.999999, 0.0]\ntraction = [0.0, {}]\n", m.shear);
  text += "[gauge.corner]\nfrom = [1.0, 22.0]\nto = [47.999999, 59.999999]\n";
  text += "[gauge.edge]\nfrom = [1.0, 22.0]\nto = [47.999999, 52.0]\n";
  return text + "[steps]\ncount = 1\nadaptive = false\n";
}

struct Deflection {
  double corner, edge;
};

Deflection deflection(const Membrane& m, bool fitted, bool f_bar) {
  Model model(membrane(m, fitted, f_bar));
  model.advance(1.0);
  return {model.gauge_end(0).y(), model.gauge_end(1).y()};
}

const char* const cook = "Cook's membrane (V13)";
const char* const cook_source = "quadratic mixed FEM, 64 x 64 elements";

/// With F-bar more than 95 % of the deflection, 16 cells a side.
void expect_unlocked(const Membrane& m, const Deflection& exact, bool fitted) {
  const Deflection found = deflection(m, fitted, true);
  EXPECT_GT(found.corner, 0.95 * exact.corner);
  EXPECT_GT(found.edge, 0.95 * exact.edge);
  EXPECT_LT(found.corner, 1.02 * exact.corner);
  EXPECT_LT(found.edge, 1.02 * exact.edge);
  const std::string variant =
      fmt::format("F-bar, E = {}, nu = {}, {} grid", m.youngs, m.poisson, fitted ? "fitted" : "cut");
  record({cook, variant + ": corner", found.corner, fmt::format("{}", exact.corner), "-5 %, +2 %", cook_source});
  record({cook, variant + ": middle of the edge", found.edge, fmt::format("{}", exact.edge), "-5 %, +2 %", cook_source});
}

TEST(CooksMembrane, FBarDoesNotLock) {
  for (const bool fitted : {true, false}) {
    expect_unlocked({240.565, 0.4999, 6.25}, {8.07, 7.69}, fitted);
    expect_unlocked({70.0, 0.4999, 1.0 / 16.0}, {0.2773, 0.2643}, fitted);
    expect_unlocked({70.0, 0.33, 1.0 / 16.0}, {0.3235, 0.3081}, fitted);
  }
}

/// The contrast: without it less than half of the deflection.
TEST(CooksMembrane, StandardCellsLock) {
  for (const bool fitted : {true, false}) {
    const Deflection found = deflection({240.565, 0.4999, 6.25}, fitted, false);
    const char* grid = fitted ? "fitted" : "cut";
    if (fitted) {
      EXPECT_LT(found.corner, 0.5 * 8.07);
      EXPECT_LT(found.edge, 0.5 * 7.69);
    }
    const char* const demanded = fitted ? "< 50 %" : "reported";
    record({cook, fmt::format("standard, E = 240.565, nu = 0.4999, {} grid: corner", grid), found.corner, "8.07",
            demanded, cook_source});
    record({cook, fmt::format("standard, E = 240.565, nu = 0.4999, {} grid: middle of the edge", grid), found.edge,
            "7.69", demanded, cook_source});
  }
}

/// Plane stress needs no cure.
TEST(CooksMembrane, PlaneStress) {
  for (const bool fitted : {true, false}) {
    const double found = deflection({1.0, 1.0 / 3.0, 1.0 / 16.0, true}, fitted, false).edge;
    EXPECT_GT(found, 0.95 * 23.965);
    EXPECT_LT(found, 1.02 * 23.965);
    record({cook, fmt::format("standard, plane stress, {} grid: middle of the edge", fitted ? "fitted" : "cut"), found,
            "23.965", "-5 %, +2 %", cook_source});
  }
}

}  // namespace
}  // namespace berm::verify
