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

constexpr double depth = 1.0, youngs = 12e6, poisson = 0.2;
/// The load that bends a beam of any length alike; it stands on the last fortieth.
double load_of(double length) { return 100e3 * std::pow(10.0 / length, 2); }
double strip_of(double length) { return length / 40.0; }
constexpr const char* group = "Cantilever, load at its end (V12)";

/// strip = 0: a force at the very end. Without shear and extension: the elastica.
ExactBeam beam(double length, double force, double over, bool shear) {
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
      const ExactBeam::Tip tip = beam(10.0, e.force, 0.0, shear).tip(), known = shear ? e.reissner : e.elastica;
      EXPECT_NEAR(tip.down, known.down, 1e-4) << e.force << shear;
      EXPECT_NEAR(tip.in, known.in, 1e-4) << e.force << shear;
    }
}

struct Variant {
  std::string name, method, formulation;
  int order, cells;  ///< cells over the depth
  double length = 10.0;
  int steps = 50;
  std::string functions = "linear";  ///< mpm
  int per_direction = 2;
};

std::string case_text(const Variant& v) {
  const double h = depth / v.cells;
  // Nodes of B-splines do not lie on the axis.
  const char *node = "[boundary.pin]\nwhere.box = { min = [-1e-6, -1e-6], max = [1e-6, 1e-6] }\nuy = 0.0",
             *point = "[pin.root]\nbody = \"beam\"\nat = [1e-9, 0.0]\nfix = \"y\"";
  std::string text = fmt::format(R"(
method = "{}"
[model]
formulation = "{}"
[grid]
origin = [0.0, -10.0]
cell_size = {}
cells = [{}, {}]
shape_functions = "{}"
[material.m]
law = "linear_elastic"
density = 1000.0
youngs_modulus = {}
poisson_ratio = {}
[body.beam]
material = "m"
shape.box = {{ min = [0.0, -0.5], max = [{}, 0.5] }}
points.per_direction = {}
mesh = {{ kind = "quads", size = {}, order = {}, structured = true }}
[boundary.wall]
where.box = {{ min = [-1e-6, -20.0], max = [1e-6, 20.0] }}
ux = 0.0
{}
[gauge.tip]
from = [5.0, 0.0]
to = [{}, 0.0]
[steps]
count = {}
adaptive = false
)",
                                 v.method, v.formulation, h, std::lround(1.1 * v.length) * v.cells, 12 * v.cells, v.functions,
                                 youngs, poisson, v.length, v.per_direction, h, v.order,
                                 v.functions == "linear" ? node : point, v.length - 1e-6, v.steps);
  const double strip = strip_of(v.length);
  for (const int side : {-1, 1})
    text +=
        fmt::format("[pressure.{}]\nbody = \"beam\"\nwhere.box = {{ min = [{}, {}], max = [1e3, {}] }}\nvalue = {}\ndirection = \"dead\"\n",
                    side > 0 ? "top" : "bottom", v.length - strip, 0.5 * side - 1e-6, 0.5 * side + 1e-6,
                    side * 0.5 * load_of(v.length) / strip);
  return text;
}

struct Bent {
  double share = 0.0;         ///< of the load, with the last equilibrium
  ExactBeam::Tip fifth, end;  ///< at a fifth of the load, at the end
};

Bent bend(const Variant& v) {
  Model model(case_text(v));
  Bent bent{0.0, {NAN, NAN}, {NAN, NAN}};
  for (int k = 1; k <= v.steps; ++k) {
    if (!model.step.attempt(1.0 / v.steps, Integration::implicit).converged) break;
    model.step.accept();
    bent.share = k / double(v.steps);
    double applied = 0.0;
    for (const Vec3& f : model.step.balance().pressure_force) applied -= f.y();
    EXPECT_NEAR(applied, load_of(v.length) * bent.share, 1e-6 * load_of(v.length));
    bent.end = {-model.gauge_end().y(), -model.gauge_end().x()};
    if (5 * k == v.steps) bent.fifth = bent.end;
  }
  fmt::print("  {}: to {:.2f} of the load; a fifth: down {:.5f}, in {:.5f}; end: down {:.5f}, in {:.5f}\n", v.name,
             bent.share, bent.fifth.down, bent.fifth.in, bent.end.down, bent.end.in);
  return bent;
}

ExactBeam::Tip reissner(double length, double share) {
  return beam(length, share * load_of(length), strip_of(length), true).tip();
}

/// Distance between two places of the tip, over the deflection.
double off(const ExactBeam::Tip& a, const ExactBeam::Tip& b) {
  return std::hypot(a.down - b.down, a.in - b.in) / b.down;
}

void row(const std::string& quantity, double reached, const std::string& should_be, const std::string& demanded,
         const std::string& source) {
  record({group, quantity, reached, should_be, demanded, source});
}

void against_the_beam(const Variant& v, const Bent& b, double most) {
  ASSERT_EQ(b.share, 1.0) << v.name;
  const std::string demanded = fmt::format("{:.2g} % of the deflection", 100.0 * most);
  const std::string source = "Reissner's beam, kappa = 5/6";
  for (const double share : {0.2, 1.0}) {
    const ExactBeam::Tip exact = reissner(v.length, share), tip = share == 1.0 ? b.end : b.fifth;
    EXPECT_LT(off(tip, exact), most) << v.name << ", share " << share;
    const std::string name = fmt::format("{}, {:.0f} kN: ", v.name, share * load_of(v.length) * 1e-3);
    row(name + "tip down [m]", tip.down, fmt::format("{:.5f}", exact.down), demanded, source);
    row(name + "tip in [m]", tip.in, fmt::format("{:.5f}", exact.in), demanded, source);
  }
}

/// The beam knows no finite strain (20 % at the root): the solid bends further, by a share that goes with (depth over
/// length) squared.
TEST(CantileverEndLoad, QuadraticElements) {
  const Variant stout{"fem, quad8, h = d/4", "fem", "updated_lagrangian", 2, 4},
      slender{"fem, quad8, h = d/4, 20 m long", "fem", "updated_lagrangian", 2, 4, 20.0, 25};
  const Bent a = bend(stout), b = bend(slender);
  against_the_beam(stout, a, 0.02);
  against_the_beam(slender, b, 0.005);
  const double ratio = off(a.end, reissner(10.0, 1.0)) / off(b.end, reissner(20.0, 1.0));
  EXPECT_NEAR(ratio, 4.0, 0.4);
  row("quad8, distance of the tip from the beam's: 10 m over 20 m long", ratio, "4", "0.4",
      "(depth over length) squared");
}

/// Linear functions, total Lagrangian, against the quadratic elements too. Bilinear elements are the same equations.
TEST(CantileverEndLoad, LinearFunctions) {
  const Bent reference = bend({"fem, quad8, h = d/4", "fem", "updated_lagrangian", 2, 4, 10.0, 10});
  for (const int cells : {4, 8}) {
    const double most = cells == 4 ? 0.015 : 0.005;
    const Variant v{fmt::format("mpm, total Lagrangian, h = d/{}", cells), "mpm", "total_lagrangian", 1, cells};
    const Bent b = bend(v);
    against_the_beam(v, b, 0.025);
    EXPECT_LT(off(b.end, reference.end), most) << v.name;
    row(v.name + ", 100 kN: distance of the tip from that of quad8, over the deflection", off(b.end, reference.end),
        "0", fmt::format("{:.2g} %", 100.0 * most), "FEM of this program");
    if (cells == 8) continue;
    const Bent fem = bend({"fem, quad4, h = d/4", "fem", "updated_lagrangian", 1, cells});
    EXPECT_LT(off(b.end, fem.end), 1e-6);
    row(v.name + ", 100 kN: the same from that of quad4", off(b.end, fem.end), "0", "1e-6", "FEM of this program");
  }
}

/// Functions whose gradients do not jump carry updated Lagrangian points through the cells, to the end.
TEST(CantileverEndLoad, SmoothFunctions) {
  const Bent reference = bend({"fem, quad8, h = d/4", "fem", "updated_lagrangian", 2, 4, 10.0, 10});
  struct Demand {
    const char* functions;
    int per_direction;
    double quarter, eighth;  ///< most, with h = d/4 and d/8
  };
  for (const Demand& want : {Demand{"quadratic_bspline", 3, 0.005, 0.005}, {"cubic_bspline", 3, 0.005, 0.005},
                             {"cpgimp", 3, 0.005, 0.005}, {"b2gimp", 2, 0.01, 0.005}, {"cpdi", 2, 0.005, 0.005}})
    for (const int cells : {4, 8}) {
      const double most = cells == 4 ? want.quarter : want.eighth;
      const Variant v{fmt::format("mpm, updated Lagrangian, {}, {} points a direction, h = d/{}", want.functions,
                                  want.per_direction, cells),
                      "mpm", "updated_lagrangian", 1, cells, 10.0, 50, want.functions, want.per_direction};
      const Bent b = bend(v);
      ASSERT_EQ(b.share, 1.0) << v.name;
      EXPECT_LT(off(b.end, reference.end), most) << v.name;
      row(v.name + ", 100 kN: distance of the tip from that of quad8, over the deflection", off(b.end, reference.end), "0",
          fmt::format("{:.2g} %", 100.0 * most), "FEM of this program");
    }
}

/// With linear functions updated Lagrangian points leave their places in the cells and cross them: the beam is too soft, and no equilibrium
/// is found from about half of the load on.
TEST(CantileverEndLoad, UpdatedLagrangianBreaks) {
  for (const int cells : {4, 8}) {
    const Variant v{fmt::format("mpm, updated Lagrangian, h = d/{}", cells), "mpm", "updated_lagrangian", 1, cells};
    const Bent b = bend(v);
    const double error = off(b.fifth, reissner(10.0, 0.2));
    EXPECT_GE(b.share, 0.2) << v.name;
    EXPECT_LT(error, 0.1) << v.name;
    row(v.name + ", 20 kN: distance of the tip from the beam's, over the deflection", error, "0", "reported, < 10 %",
        "Reissner's beam, kappa = 5/6");
    row(v.name + ": share of the load at the last equilibrium", b.share, "1", "reported, >= 0.2",
        "linear functions, points cross cells");
  }
}

}  // namespace
}  // namespace berm::verify
