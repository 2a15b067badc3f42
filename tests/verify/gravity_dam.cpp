/// Triangular gravity dam with full water (Levy; V16): the stresses are linear in x and y. In MPM both faces cut the
/// cells. The base is moved as in the exact solution.

#include <fmt/format.h>

#include <cmath>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double height = 100.0, slope = 0.8, concrete = 24e3, water = 9.81e3, gravity = 9.81, youngs = 30e9,
                 poisson = 0.2;

/// The crest is the origin, y points up. Stresses: xx = a y, yy = b x + c y, xy = d x.
constexpr double a = water, b = concrete / slope - 2.0 * water / (slope * slope * slope),
                 c = concrete - water / (slope * slope), d = water / (slope * slope);
constexpr double k = (1.0 + poisson) / youngs;  ///< strain xx = k ((1 - nu) s_xx - nu s_yy), plane strain

// Integrals of the strains xx = p x + q y, yy = r x + s y, xy = 2 k d x (engineering).
constexpr double p = -k * poisson * b, q = k * ((1.0 - poisson) * a - poisson * c), r = k * (1.0 - poisson) * b,
                 s = k * ((1.0 - poisson) * c - poisson * a);

std::string displacement_x() { return fmt::format("t*({:.17g}*x^2+{:.17g}*x*y+{:.17g}*y^2)", p / 2.0, q, -r / 2.0); }
std::string displacement_y() {
  return fmt::format("t*({:.17g}*x*y+{:.17g}*y^2+{:.17g}*x^2)", r, s / 2.0, (2.0 * k * d - q) / 2.0);
}
Vec3 displacement(const Vec3& x) {
  return {p / 2.0 * x.x() * x.x() + q * x.x() * x.y() - r / 2.0 * x.y() * x.y(),
          r * x.x() * x.y() + s / 2.0 * x.y() * x.y() + (2.0 * k * d - q) / 2.0 * x.x() * x.x(), 0.0};
}
Voigt stress(const Vec3& x) {
  Voigt v = Voigt::Zero();
  v[XX] = a * x.y();
  v[YY] = b * x.x() + c * x.y();
  v[ZZ] = poisson * (v[XX] + v[YY]);
  v[XY] = d * x.x();
  return v;
}

/// n cells over the height.
std::string dam(const std::string& method, int n, int order, const std::string& functions) {
  const double h = height / n;
  std::string text = fmt::format("method = \"{}\"\n[model]\nplane = \"strain\"\nkinematics = \"small\"\n", method);
  text += fmt::format("gravity = [0.0, -{}]\n", gravity);
  text += fmt::format(
      "[material.m]\nlaw = \"linear_elastic\"\ndensity = {:.15g}\nyoungs_modulus = {}\npoisson_ratio = {}\n",
      concrete / gravity, youngs, poisson);
  // The upstream face cuts its cells by a third.
  text +=
      fmt::format("[grid]\norigin = [{}, {}]\ncell_size = {}\ncells = [{}, {}]\nshape_functions = \"{}\"\n", -h / 3.0,
                  -height, h, n + 1, n + 1, functions);
  text += fmt::format("[body.dam]\nmaterial = \"m\"\nshape.polygon = [[0.0, 0.0], [0.0, -{0}], [{1}, -{0}]]\n", height,
                      slope * height);
  text +=
      fmt::format("mesh = {{ kind = \"{}\", size = {}, order = {} }}\n", order == 2 ? "triangles" : "quads", h, order);
  text += fmt::format("[pressure.water]\nbody = \"dam\"\nwhere.box.max = [1e-6, 1.0]\nvalue = \"-{}*y*t\"\n", water);
  text += fmt::format("[boundary.base]\nwhere.box = {{ max = [1000.0, {}] }}\nux = \"{}\"\nuy = \"{}\"\n",
                      -height + 1e-6, displacement_x(), displacement_y());
  return text + "[steps]\ncount = 1\nadaptive = false\n";
}

FieldErrors solve(const std::string& method, int n, int order, const std::string& functions) {
  Model model(dam(method, n, order, functions));
  model.advance(1.0);
  // Forces: weight and water pressure are carried by the base.
  const Vec3 base = model.step.balance().reactions.boundary[0];
  EXPECT_LT(relative(base.y(), 0.5 * concrete * slope * height * height), 1e-3);
  EXPECT_LT(relative(base.x(), -0.5 * water * height * height), 1e-3);
  return field_errors(model, displacement, stress);
}

void study(const std::string& name, const std::string& method, int order, double most_stress, double order_s,
           const std::string& functions = "linear") {
  std::vector<FieldErrors> e;
  for (const int n : {8, 16, 32, 64}) {
    e.push_back(solve(method, n, order, functions));
    fmt::print("  {}: H/{}, u {:.3e}, stress {:.3e}\n", name, n, e.back().displacement, e.back().stress);
  }
  EXPECT_LT(e[2].stress, most_stress);
  const double reached = std::log2(e[0].stress / e[3].stress) / 3.0;
  EXPECT_GT(reached, order_s);
  const double of_u = std::log2(e[0].displacement / e[3].displacement) / 3.0;
  EXPECT_GT(of_u, order_s + 0.7);
  record({"Triangular gravity dam (V16)", name + ": L2 error of the stress, H/32", e[2].stress, "0",
          fmt::format("{}", most_stress), "Levy 1898"});
  record({"Triangular gravity dam (V16)", name + ": order of the stress, H/8 to H/64", reached, "1 or more",
          fmt::format("> {}", order_s), "linear shape functions"});
  record({"Triangular gravity dam (V16)", name + ": order of the displacement, H/8 to H/64", of_u, "2 or more",
          fmt::format("> {}", order_s + 0.7), "linear shape functions"});
}

// Raw stresses at the points of linear cells: of first order, 1 % at H/32 and half of it at H/64.
TEST(GravityDam, Mpm) { study("mpm, faces cut the cells", "mpm", 1, 0.011, 0.9); }
/// Domains fill the dam up to its faces: 1 % at H/32. B-splines at points come to it on coarse grids only.
TEST(GravityDam, SmoothFunctions) {
  for (const char* f : {"ugimp", "cpdi"}) study(fmt::format("mpm, {}, faces cut the cells", f), "mpm", 1, 0.01, 0.9, f);
  study("mpm, b2gimp, faces cut the cells", "mpm", 1, 0.005, 0.5, "b2gimp");
  study("mpm, quadratic_bspline, faces cut the cells", "mpm", 1, 0.012, 0.6, "quadratic_bspline");
}
TEST(GravityDam, FemLinear) { study("fem, quad4", "fem", 1, 0.025, 0.9); }

/// The exact displacement is quadratic: quadratic elements have it, but for the pressure's midpoint rule on their
/// edges.
TEST(GravityDam, FemQuadratic) {
  const FieldErrors e = solve("fem", 8, 2, "linear");
  EXPECT_LT(e.displacement, 1e-4);
  EXPECT_LT(e.stress, 1e-3);
  record(
      {"Triangular gravity dam (V16)", "fem, tri6: L2 error of the stress, H/8", e.stress, "0", "0.001", "Levy 1898"});
}

}  // namespace
}  // namespace berm::verify
