/// Volumetric locking of linear cells, F-bar and pressures at the nodes (docs/theory/formulation.md, sections 14 and 15):
/// Cook's membrane, the bearing capacity of a strip, rubber between platens.

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
std::string membrane(const Membrane& m, bool fitted, const std::string& volumetric) {
  std::string text = "[model]\nkinematics = \"small\"\n";
  text += fmt::format("plane = \"{}\"\nvolumetric = \"{}\"\n", m.plane_stress ? "stress" : "strain", volumetric);
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
  text +=
      fmt::format("[pressure.right]\nbody = \"b\"\nwhere.box.min = [47.999999, 0.0]\ntraction = [0.0, {}]\n", m.shear);
  text += "[gauge.corner]\nfrom = [1.0, 22.0]\nto = [47.999999, 59.999999]\n";
  text += "[gauge.edge]\nfrom = [1.0, 22.0]\nto = [47.999999, 52.0]\n";
  return text + "[steps]\ncount = 1\nadaptive = false\n";
}

struct Deflection {
  double corner, edge;
};

Deflection deflection(const Membrane& m, bool fitted, const std::string& volumetric) {
  Model model(membrane(m, fitted, volumetric));
  model.advance(1.0);
  return {model.gauge_end(0).y(), model.gauge_end(1).y()};
}

const char* const cook = "Cook's membrane (V13)";
const char* const cook_source = "quadratic mixed FEM, 64 x 64 elements";

const char* name_of(const std::string& volumetric) { return volumetric == "f_bar" ? "F-bar" : "mixed u-p"; }

/// More than 95 % of the deflection, 16 cells a side.
void expect_unlocked(const Membrane& m, const Deflection& exact, bool fitted, const std::string& volumetric) {
  const Deflection found = deflection(m, fitted, volumetric);
  EXPECT_GT(found.corner, 0.95 * exact.corner);
  EXPECT_GT(found.edge, 0.95 * exact.edge);
  EXPECT_LT(found.corner, 1.02 * exact.corner);
  EXPECT_LT(found.edge, 1.02 * exact.edge);
  const std::string variant =
      fmt::format("{}, E = {}, nu = {}, {} grid", name_of(volumetric), m.youngs, m.poisson, fitted ? "fitted" : "cut");
  record({cook, variant + ": corner", found.corner, fmt::format("{}", exact.corner), "-5 %, +2 %", cook_source});
  record(
      {cook, variant + ": middle of the edge", found.edge, fmt::format("{}", exact.edge), "-5 %, +2 %", cook_source});
}

void expect_all_unlocked(const std::string& volumetric) {
  for (const bool fitted : {true, false}) {
    expect_unlocked({240.565, 0.4999, 6.25}, {8.07, 7.69}, fitted, volumetric);
    expect_unlocked({70.0, 0.4999, 1.0 / 16.0}, {0.2773, 0.2643}, fitted, volumetric);
    expect_unlocked({70.0, 0.33, 1.0 / 16.0}, {0.3235, 0.3081}, fitted, volumetric);
  }
}

TEST(CooksMembrane, FBarDoesNotLock) { expect_all_unlocked("f_bar"); }
TEST(CooksMembrane, PressuresOfNodesDoNotLock) { expect_all_unlocked("mixed"); }

/// The contrast: without it less than half of the deflection.
TEST(CooksMembrane, StandardCellsLock) {
  for (const bool fitted : {true, false}) {
    const Deflection found = deflection({240.565, 0.4999, 6.25}, fitted, "standard");
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
    const double found = deflection({1.0, 1.0 / 3.0, 1.0 / 16.0, true}, fitted, "standard").edge;
    EXPECT_GT(found, 0.95 * 23.965);
    EXPECT_LT(found, 1.02 * 23.965);
    record({cook, fmt::format("standard, plane stress, {} grid: middle of the edge", fitted ? "fitted" : "cut"), found,
            "23.965", "-5 %, +2 %", cook_source});
  }
}

// ---- bearing capacity of a strip

struct Ground {
  double friction = 0.0, poisson = 0.49;  ///< friction: also the dilatancy angle [deg]
  double settlement = 0.005;              ///< of the strip at the end
};

/// Half of a rigid, rough strip of width 1 on weightless ground of unit cohesion. Its edge is half-way between nodes.
std::string strip(const Ground& ground, const std::string& volumetric, int cells_per_width, int steps) {
  const double h = 1.0 / cells_per_width;
  std::string text = "[model]\nplane = \"strain\"\nkinematics = \"small\"\n";
  text += fmt::format("volumetric = \"{}\"\n", volumetric);
  text += fmt::format("[grid]\ncell_size = {:.17g}\ncells = [{}, {}]\n", h, 5 * cells_per_width, 3 * cells_per_width);
  text += fmt::format(
      "[material.m]\nlaw = \"mohr_coulomb\"\ndensity = 1.0\nyoungs_modulus = 1e4\npoisson_ratio = {}\ncohesion = 1.0\n"
      "friction_angle = {}\ndilatancy_angle = {}\n",
      ground.poisson, ground.friction, ground.friction);
  text += "[body.b]\nmaterial = \"m\"\nshape.box = { min = [0.0, 0.0], max = [5.0, 3.0] }\n";
  text += fmt::format(
      "[boundary.strip]\nwhere.box = {{ min = [-1.0, 2.9999], max = [0.4999, 3.0001] }}\nux = 0.0\nuy = {}\n",
      -ground.settlement);
  text += "[boundary.axis]\nwhere.box = { min = [-1.0, 0.0], max = [1e-6, 2.9999] }\nux = 0.0\n";
  text += "[boundary.side]\nwhere.box = { min = [4.9999, 0.0], max = [6.0, 4.0] }\nux = 0.0\n";
  text += "[boundary.base]\nwhere.box = { min = [-1.0, -1.0], max = [6.0, 1e-6] }\nux = 0.0\nuy = 0.0\n";
  return text + fmt::format("[steps]\ncount = {}\n", steps);
}

struct Bearing {
  double last = 0.0, rise = 0.0, energy_error = 0.0;
};

/// Mean stress under the strip at the end, over c, and how much of it came in the last 40 % of the settlement.
Bearing bearing(const Ground& ground, const std::string& volumetric, int cells_per_width = 11, int steps = 25) {
  Model model(strip(ground, volumetric, cells_per_width, steps));
  double at_60 = 0.0;
  Bearing found;
  int iterations = 0, taken = 0;
  const bool done = model.run([&](const StepResult& result) {
    found.last = 2.0 * -model.step.balance().reactions.boundary[0].y();
    if (model.world->time < 0.6 + 1e-9) at_60 = found.last;
    iterations += result.iterations;
    ++taken;
  });
  EXPECT_TRUE(done);
  const MaterialState& m = model.material();
  const double work = model.step.balance().external_work;
  found.energy_error = std::abs(work - m.stored_energy() - m.dissipated_energy()) / work;
  found.rise = 1.0 - at_60 / found.last;
  fmt::print("  q/c = {:.5f}, at 60 %: {:.5f}; {} steps, {} iterations, energy error {:.2g}\n", found.last, at_60,
             taken, iterations, found.energy_error);
  return found;
}

const char* const footing = "Strip footing (V22)";
const char* const prandtl_source = "Prandtl 1920";

/// (Nq - 1) cot(phi), Nq = e^(pi tan phi) tan^2(45 + phi/2); 2 + pi without friction.
double prandtl(double degrees) {
  const double pi = std::numbers::pi, phi = degrees * pi / 180.0;
  if (degrees == 0.0) return 2.0 + pi;
  const double root = std::tan(0.25 * pi + 0.5 * phi);
  return (std::exp(pi * std::tan(phi)) * root * root - 1.0) / std::tan(phi);
}

void expect_plateau(const Ground& ground, int cells_per_width, double tolerance, double most_rise,
                    const std::string& volumetric = "f_bar") {
  const double exact = prandtl(ground.friction);
  const Bearing found = bearing(ground, volumetric, cells_per_width);
  EXPECT_LT(relative(found.last, exact), tolerance);
  EXPECT_LT(found.rise, most_rise);
  EXPECT_LT(found.energy_error, 0.01);
  const std::string variant =
      fmt::format("{}, friction angle {:g} deg, {} cells over B", name_of(volumetric), ground.friction, cells_per_width);
  record({footing, variant + ": q / c", found.last, fmt::format("{:.5f}", exact), fmt::format("{} relative", tolerance),
          prandtl_source});
  record({footing, variant + ": rise on the plateau", found.rise, "0", fmt::format("{}", most_rise), prandtl_source});
}

TEST(StripFooting, TrescaReachesItsPlateau) { expect_plateau({}, 11, 0.03, 0.001); }
TEST(StripFooting, TrescaConverges) { expect_plateau({}, 21, 0.01, 0.001); }
TEST(StripFooting, TrescaWithPressuresOfNodes) { expect_plateau({}, 11, 0.03, 0.003, "mixed"); }

/// Associated flow dilates: one dilatation a cell cannot follow shear that differs from point to point, and the load
/// goes on rising slowly after the knee, the less the smaller the cells.
TEST(StripFooting, FrictionAngle20) { expect_plateau({20.0, 0.3}, 11, 0.05, 0.1); }

/// The contrast: standard cells carry more and more.
TEST(StripFooting, StandardCellsKeepRising) {
  const Bearing found = bearing({}, "standard");
  EXPECT_GT(found.last, 1.1 * prandtl(0.0));
  EXPECT_GT(found.rise, 0.02);
  record({footing, "standard, friction angle 0 deg, 11 cells over B: q / c", found.last, "5.14159", "> 10 % more",
          prandtl_source});
  record({footing, "standard, friction angle 0 deg, 11 cells over B: rise on the plateau", found.rise, "0", "> 0.02",
          prandtl_source});
}

// ---- large strain

/// A block of a nearly incompressible solid between rough platens.
std::string rubber(const std::string& model, double shortening, const std::string& volumetric, int n) {
  const bool solid = model.find("dimension = 3") != std::string::npos;
  const char* const z = solid ? ", 1.0]" : "]";
  std::string text = fmt::format("[model]\n{}\nvolumetric = \"{}\"\n", model, volumetric);
  const double h = 1.0 / n, before = solid ? -h : 0.0;
  text += fmt::format("[grid]\norigin = [{}, 0.0{}\ncell_size = {}\ncells = [{}, {}{}]\n", before,
                      solid ? fmt::format(", {}]", before) : "]", h, 2 * n - 1, n,
                      solid ? fmt::format(", {}", 2 * n - 1) : "");
  text += "[material.m]\nlaw = \"linear_elastic\"\ndensity = 1.0\nyoungs_modulus = 1e6\npoisson_ratio = 0.4999\n";
  text += fmt::format("[body.b]\nmaterial = \"m\"\nshape.box = {{ min = [0.0, 0.0{}, max = [1.0, 1.0{} }}\n",
                      solid ? ", 0.0]" : "]", z);
  const std::string still = solid ? "ux = 0.0\nuz = 0.0\n" : "ux = 0.0\n";
  text += fmt::format("[boundary.base]\nwhere.box.max = [5.0, 1e-6{}\nuy = 0.0\n{}", solid ? ", 5.0]" : "]", still);
  text += fmt::format("[boundary.top]\nwhere.box.min = [-5.0, 0.9999{}\nuy = {}\n{}", solid ? ", -5.0]" : "]",
                      -shortening, still);
  if (!solid) text += "[boundary.axis]\nwhere.box = { min = [-1.0, 1e-6], max = [1e-6, 0.9999] }\nux = 0.0\n";
  return text + "[steps]\ncount = 10\nadaptive = false\n";
}

struct Squeezed {
  double load, energy_error;
};
Squeezed squeeze(const std::string& model_text, double shortening, const std::string& volumetric, int n = 4) {
  Model model(rubber(model_text, shortening, volumetric, n));
  EXPECT_TRUE(model.run());
  const double work = model.step.balance().external_work;
  return {-model.step.balance().reactions.boundary[1].y(), std::abs(work - model.material().stored_energy()) / work};
}

const char* const large_strain = "Nearly incompressible, large strain";

/// The forces have a potential, so no work gets lost, as long as no point crosses a cell: never in the total Lagrangian
/// form, and not for 3 % in the updated one. And they are far smaller than without a cure. `extra`: error of the balance
/// that comes with the cure.
void expect_balance(const std::string& volumetric, double extra) {
  for (const char* space : {"plane = 'strain'", "plane = 'axisymmetric'", "dimension = 3"})
    for (const char* form : {"updated", "total"}) {
      SCOPED_TRACE(std::string(space) + form);
      const bool total = form == std::string("total");
      const double shortening = total ? 0.1 : 0.03, most = extra + (total ? 0.002 : 0.005);
      const std::string model = fmt::format("{}\nformulation = \"{}_lagrangian\"", space, form);
      const Squeezed plain = squeeze(model, shortening, "standard"), cured = squeeze(model, shortening, volumetric);
      EXPECT_LT(cured.energy_error, most);
      EXPECT_LT(cured.load, 0.2 * plain.load);
      const std::string variant =
          fmt::format("{}, {}, {} Lagrangian, {:g} %", name_of(volumetric), space, form, 100.0 * shortening);
      record({large_strain, variant + ": energy error", cured.energy_error, "0", fmt::format("{:.3g}", most),
              "energy balance"});
      record({large_strain, variant + ": load over that of standard cells", cured.load / plain.load, "< 1", "< 0.2",
              "locking"});
    }
}

TEST(NearlyIncompressible, FBarKeepsTheBalance) { expect_balance("f_bar", 0.0); }

/// Stabilisation stores energy where the pressure is rough: at the corners of the platens, the less the finer the grid.
TEST(NearlyIncompressible, PressuresOfNodesKeepTheBalance) {
  expect_balance("mixed", 0.07);
  const std::string total = "plane = 'strain'\nformulation = \"total_lagrangian\"";
  const double coarse = squeeze(total, 0.1, "mixed", 8).energy_error, fine = squeeze(total, 0.1, "mixed", 16).energy_error;
  EXPECT_LT(fine, 0.7 * coarse);
  record({large_strain, "mixed u-p, plane = 'strain', total Lagrangian, 10 %: energy error on a grid twice as fine", fine,
          "0", "< 0.7 of that on the other", "energy balance"});
}

/// Points that cross cells meet others with another pressure: where the volume is all but given that costs energy.
TEST(NearlyIncompressible, CrossingCellsCosts) {
  for (const std::string volumetric : {"f_bar", "mixed"}) {
    const Squeezed crossing = squeeze("plane = \"strain\"", 0.1, volumetric);
    record({large_strain,
            fmt::format("{}, plane strain, updated Lagrangian, 10 %, points cross cells: energy error",
                        name_of(volumetric)),
            crossing.energy_error, "0", "reported", "energy balance"});
  }
}

}  // namespace
}  // namespace berm::verify
