/// Thick-walled tube of von Mises steel under inner pressure, its ends held, against Hill's solution (The Mathematical
/// Theory of Plasticity, 1950, ch. V.2): around the axis, FEM and MPM whose walls cut cells. Hill takes the plastic
/// part as incompressible in the elastic range too, which alone is worth about 1 %.

#include <fmt/format.h>

#include <cmath>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double inner = 0.1, outer = 0.2, youngs = 210e9, poisson = 0.3, yield = 0.24e9, most = 0.18e9;
const double Y = 2.0 / std::sqrt(3.0) * yield;

/// Radius up to which the tube yields at the pressure P [m], by bisection; `inner` below the first yield.
double front(double P) {
  double low = inner, high = outer;
  while (high - low > 1e-12) {
    const double c = 0.5 * (low + high);
    (Y * std::log(c / inner) + 0.5 * Y * (1.0 - c * c / (outer * outer)) < P ? low : high) = c;
  }
  return low;
}

struct Exact {
  double u, rr, tt;  ///< u: outside of the front only
};
Exact hill(double r, double P) {
  const double c = front(P);
  const bool elastic = c <= inner * (1.0 + 1e-9);
  // Lame's constants of the elastic part.
  const double A = elastic ? P * inner * inner / (outer * outer - inner * inner) : 0.5 * Y * c * c / (outer * outer);
  const double B = A * outer * outer;
  const double u = (1.0 + poisson) / youngs * ((1.0 - 2.0 * poisson) * A * r + B / r);
  if (r >= c) return {u, A - B / (r * r), A + B / (r * r)};
  const double rr = -P + Y * std::log(r / inner);
  return {u, rr, rr + Y};
}

std::string tube(const std::string& method, double h) {
  const int n = static_cast<int>(std::lround((outer - inner) / h));
  std::string text = fmt::format("method = \"{}\"\n", method);
  text += "[model]\nplane = \"axisymmetric\"\nkinematics = \"small\"\n";
  text += fmt::format(
      "[material.m]\nlaw = \"von_mises\"\ndensity = 7850.0\nyoungs_modulus = {}\npoisson_ratio = {}\n"
      "yield_stress = {}\n",
      youngs, poisson, yield);
  // Cells cut by a quarter.
  text += fmt::format("[grid]\norigin = [{}, 0.0]\ncell_size = {}\ncells = [{}, 2]\n", inner - 0.75 * h, h, n + 2);
  text += fmt::format("[body.b]\nmaterial = \"m\"\nshape.box = {{ min = [{}, 0.0], max = [{}, {}] }}\n", inner, outer,
                      2.0 * h);
  text += fmt::format("mesh = {{ kind = \"quads\", size = {}, structured = true, order = 2 }}\n", h);
  text += fmt::format("[pressure.p]\nbody = \"b\"\nwhere.box.max = [{}, 1.0]\nvalue = \"{}*t\"\n", inner + 1e-6, most);
  text += "[boundary.ends]\nwhere.box = { min = [-1.0, -1.0], max = [1.0, 1.0] }\nuy = 0.0\n";
  return text + "[steps]\ncount = 18\nadaptive = false\n";
}

struct Errors {
  double displacement = 0.0, stress = 0.0;
};

/// Largest error of the displacement in the outer tenth, relative; mean error of rr and tt over the volume, over Y.
Errors errors(const Model& model) {
  const double P = most * model.world->time;
  const Discretisation& d = *model.world->discretisation;
  const MaterialState& m = model.material();
  const std::vector<Vec3> X = d.point_origins(), u = d.point_displacements();
  Errors e;
  double volume = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p) {
    const Exact x = hill(X[p].x(), P);
    if (X[p].x() > 0.95 * outer) e.displacement = std::max(e.displacement, relative(u[p].x(), x.u));
    e.stress += m.volume[p] * (std::abs(m.stress[p][XX] - x.rr) + std::abs(m.stress[p][ZZ] - x.tt)) / (2.0 * Y);
    volume += m.volume[p];
  }
  e.stress /= volume;
  return e;
}

void run(const std::string& method, double h, double most_displacement, double most_stress) {
  Model model(tube(method, h));
  Errors worst;
  const bool done = model.run([&](const StepResult&) {
    const Errors e = errors(model);
    worst.displacement = std::max(worst.displacement, e.displacement);
    worst.stress = std::max(worst.stress, e.stress);
  });
  ASSERT_TRUE(done);
  EXPECT_LT(worst.displacement, most_displacement);
  EXPECT_LT(worst.stress, most_stress);
  EXPECT_GT(model.material().max_plastic_strain(), 1e-3);
  const std::string variant = fmt::format("{}, {} cells over the wall", method, std::lround((outer - inner) / h));
  record({"Thick tube of von Mises steel (V21)", variant + ": outer displacement, up to 0.18 GPa", worst.displacement,
          "0", fmt::format("{}", most_displacement), "Hill 1950"});
  record({"Thick tube of von Mises steel (V21)", variant + ": mean stress error over 2 k", worst.stress, "0",
          fmt::format("{}", most_stress), "Hill 1950"});
}

// Raw stresses of material points in linear cells are of first order.
TEST(HillTube, Fem) { run("fem", inner / 10.0, 0.01, 0.005); }
TEST(HillTube, MpmWithCutCells) { run("mpm", inner / 10.0, 0.01, 0.05); }
TEST(HillTube, FinerMpmWithCutCells) { run("mpm", inner / 20.0, 0.005, 0.025); }

}  // namespace
}  // namespace berm::verify
