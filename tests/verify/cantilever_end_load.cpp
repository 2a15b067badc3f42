/// Cantilever bent by a load at its end to a deflection of 80 % of its length (Molstad 1977; AMPLE): 10 m x 1 m,
/// E = 12 MPa, nu = 0.2, plane strain, Hencky's solid, 100 kN. The root slides on a wall and is pinned at mid-depth.
///
/// The load is a dead pressure on the last quarter of a metre of the top and an equal pull on the bottom: its resultant
/// is vertical and acts at mid-depth, 0.125 m from the end. The reference is a geometrically exact beam under that very
/// load.

#include <fmt/format.h>

#include <cmath>

#include "driver.hpp"
#include "exact_beam.hpp"

namespace berm::verify {
namespace {

constexpr double length = 10.0, depth = 1.0, youngs = 12e6, poisson = 0.2, load = 100e3, strip = 0.25;
constexpr int steps = 50;
constexpr const char* group = "Cantilever, load at its end (V12)";

/// strip = 0: a force at the very end. Without shear and extension: the elastica.
ExactBeam beam(double force, double over, bool shear) {
  const double plane = youngs / (1.0 - poisson * poisson), G = youngs / (2.0 * (1.0 + poisson));
  ExactBeam b;
  b.length = length;
  b.bending = plane * std::pow(depth, 3) / 12.0;
  b.tension_compliance = shear ? 1.0 / (plane * depth) : 0.0;
  b.shear_compliance = shear ? 1.0 / (5.0 / 6.0 * G * depth) : 0.0;
  b.outer_force = [=](double s) { return over > 0.0 && s > length - over ? -force * (length - s) / over : -force; };
  return b;
}

/// The reference itself, against values computed elsewhere (elastica: also the tables of Mattiasson 1981).
TEST(CantileverEndLoad, Reference) {
  struct Entry {
    double force;
    ExactBeam::Tip elastica, reissner;
  };
  for (const Entry& e : {Entry{10e3, {2.9167, 0.5262}, {2.9377, 0.5300}},
                         {20e3, {4.8179, 1.5237}, {4.8522, 1.5325}},
                         {40e3, {6.6119, 3.1820}, {6.6661, 3.1956}},
                         {60e3, {7.3805, 4.2420}, {7.4544, 4.2579}},
                         {80e3, {7.7979, 4.9522}, {7.8914, 4.9697}},
                         {100e3, {8.0624, 5.4613}, {8.1754, 5.4804}}})
    for (const bool shear : {false, true}) {
      const ExactBeam::Tip tip = beam(e.force, 0.0, shear).tip(), known = shear ? e.reissner : e.elastica;
      EXPECT_NEAR(tip.down, known.down, 1e-4) << e.force << shear;
      EXPECT_NEAR(tip.in, known.in, 1e-4) << e.force << shear;
    }
}

struct Variant {
  std::string name, method, formulation;
  int order, cells;  ///< cells over the depth
};

std::string case_text(const Variant& v) {
  const double h = depth / v.cells;
  std::string text =
      fmt::format(R"(
method = "{}"
[model]
formulation = "{}"
[grid]
origin = [0.0, -10.0]
cell_size = {}
cells = [{}, {}]
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = {}
poisson_ratio = {}
[body.beam]
material = "m"
shape.box = {{ min = [0.0, -0.5], max = [10.0, 0.5] }}
mesh = {{ kind = "quads", size = {}, order = {}, structured = true }}
[boundary.wall]
where.box = {{ min = [-1e-6, -20.0], max = [1e-6, 20.0] }}
ux = 0.0
[boundary.pin]
where.box = {{ min = [-1e-6, -1e-6], max = [1e-6, 1e-6] }}
uy = 0.0
[gauge.tip]
from = [5.0, 0.0]
to = [9.999999, 0.0]
[steps]
count = {}
adaptive = false
)",
                  v.method, v.formulation, h, 11 * v.cells, 12 * v.cells, youngs, poisson, h, v.order, steps);
  for (const int side : {-1, 1})
    text += fmt::format(
        "[pressure.{}]\nbody = \"beam\"\nwhere.box = {{ min = [{}, {}], max = [11.0, {}] }}\nvalue = {}\n",
        side > 0 ? "top" : "bottom", length - strip, 0.5 * side - 1e-6, 0.5 * side + 1e-6, side * 0.5 * load / strip);
  return text;
}

/// Tip at 20, 60 and 100 kN; `most`: what the test demands of the deflection at all three, relative.
void bend(const Variant& v, double most) {
  Model model(case_text(v));
  for (int k = 1; k <= steps; ++k) {
    ASSERT_TRUE(model.advance(1.0 / steps).converged) << v.name << ", step " << k;
    if (k != 10 && k != 30 && k != 50) continue;
    const double force = load * k / steps;
    double applied = 0.0;
    for (const Vec3& f : model.step.balance().pressure_force) applied -= f.y();
    EXPECT_NEAR(applied, force, 1e-6 * force);
    const ExactBeam::Tip exact = beam(force, strip, true).tip();
    const double down = -model.gauge_end().y(), in = -model.gauge_end().x();
    fmt::print("  {}: {:.0f} kN: down {:.5f} ({:+.3f} %), in {:.5f} ({:+.3f} %)\n", v.name, force / 1e3, down,
               100 * (down / exact.down - 1), in, 100 * (in / exact.in - 1));
    EXPECT_NEAR(down, exact.down, most * exact.down) << v.name << ", " << force;
    EXPECT_NEAR(in, exact.in, 2.0 * most * exact.in) << v.name << ", " << force;
    if (k == 30) continue;
    record({group, fmt::format("{}, {:.0f} kN: tip down [m]", v.name, force * 1e-3), down,
            fmt::format("{:.5f}", exact.down), fmt::format("{:.2g} %", 100 * most), "Reissner's beam, kappa = 5/6"});
    record({group, fmt::format("{}, {:.0f} kN: tip in [m]", v.name, force * 1e-3), in, fmt::format("{:.5f}", exact.in),
            fmt::format("{:.2g} %", 200 * most), "Reissner's beam, kappa = 5/6"});
  }
}

TEST(CantileverEndLoad, Fem) {
  bend({"fem, quad8, h = d/4", "fem", "updated_lagrangian", 2, 4}, 0.005);
  bend({"fem, quad4, h = d/4", "fem", "updated_lagrangian", 1, 4}, 0.03);
  bend({"fem, quad4, h = d/8", "fem", "updated_lagrangian", 1, 8}, 0.01);
}

TEST(CantileverEndLoad, TotalLagrangian) {
  bend({"mpm, total Lagrangian, h = d/4", "mpm", "total_lagrangian", 1, 4}, 0.03);
  bend({"mpm, total Lagrangian, h = d/8", "mpm", "total_lagrangian", 1, 8}, 0.01);
}

TEST(CantileverEndLoad, UpdatedLagrangian) {
  bend({"mpm, updated Lagrangian, h = d/4", "mpm", "updated_lagrangian", 1, 4}, 0.2);
  bend({"mpm, updated Lagrangian, h = d/8", "mpm", "updated_lagrangian", 1, 8}, 0.2);
}

}  // namespace
}  // namespace berm::verify
