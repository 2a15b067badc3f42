/// A deposit of soil, 10 m deep, under its own weight between smooth walls, and the oedometer: closed forms of stress
/// and settlement in small and logarithmic strain, the oscillation of the stress, and gravity in one step against many.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "driver.hpp"
#include "lambert_w.hpp"
#include "sim/local_fit.hpp"

namespace berm::verify {
namespace {

constexpr double depth = 10.0, density = 2000.0, gravity = 9.81, poisson = 0.29;
constexpr double weight = density * gravity * depth;  // vertical stress at the base [Pa]
constexpr double at_rest = poisson / (1.0 - poisson);
double constrained(double youngs) { return youngs * (1.0 - poisson) / ((1.0 + poisson) * (1.0 - 2.0 * poisson)); }

struct Deposit {
  std::string method = "mpm", kinematics = "small", formulation = "updated_lagrangian";
  double youngs = 50e6;
  int cells = 40;  ///< over the depth
  int steps = 1, order = 1;
  double cohesion = -1.0, friction = 0.0;  ///< [Pa], [deg]; negative: elastic
  double surcharge = 0.0;                  ///< on the top, with no gravity [Pa]
};

Model model_of(const Deposit& d) {
  const double h = depth / d.cells;
  std::string law = "linear_elastic", keys;
  if (d.cohesion >= 0.0) {
    law = "mohr_coulomb";
    keys = fmt::format("cohesion = {}\nfriction_angle = {}\n", d.cohesion, d.friction);
  }
  std::string text =
      fmt::format(R"(
method = "{}"
[model]
kinematics = "{}"
formulation = "{}"
gravity = [0.0, {}]
[grid]
cells = [2, {}]
cell_size = {}
[material.soil]
law = "{}"
density = {}
youngs_modulus = {}
poisson_ratio = {}
{}[body.deposit]
material = "soil"
shape.box = {{ min = [0.0, 0.0], max = [{}, {}] }}
mesh = {{ kind = "quads", size = {}, order = {}, structured = true }}
[boundary.base]
where.box.max = [1e3, 1e-6]
uy = 0.0
[boundary.left]
where.box.max = [1e-6, 1e3]
ux = 0.0
[boundary.right]
where.box.min = [{}, -1.0]
ux = 0.0
[gauge.settlement]
from = [{}, 0.0]
to = [{}, {}]
[steps]
count = {}
adaptive = false
[solver]
relative_tolerance = 1e-11
absolute_tolerance = 1e-14
)",
                  d.method, d.kinematics, d.formulation, d.surcharge > 0.0 ? 0.0 : -gravity, d.cells, h, law, density,
                  d.youngs, poisson, keys, 2 * h, depth, h, d.order, 2 * h - 1e-6, h, h, depth, d.steps);
  if (d.surcharge > 0.0)
    text += fmt::format("[pressure.top]\nbody = \"deposit\"\nwhere.box.min = [-1.0, {}]\nvalue = {}\n", depth - 1e-6,
                        d.surcharge);
  return Model(text);
}

/// What a deposit comes to rest at.
struct Rest {
  std::vector<Vec3> X;
  std::vector<Voigt> stress;
  double settlement = 0.0, noise = 0.0;
  double mean_error = 0.0;  ///< largest error of the mean vertical stress of a layer of cells, over that at the base
};

/// The metric `stress_noise` of docs/verification.md.
double noise_of(const Model& model) {
  const std::vector<Vec3> X = model.world->discretisation->point_origins();
  const MaterialState& m = model.material();
  const double radius = 1.5 * model.world->discretisation->cell_size();
  const PointBins bins(X, radius, 2);
  double sum = 0.0, largest = 0.0;
  for (std::size_t p = 0; p < X.size(); ++p) {
    const LocalFit fit = bins.fit(X[p], radius, m.volume);
    double off = 0.0, size = 0.0;
    for (int c : {XX, YY, XY}) {
      const double here = m.stress[p][c], factor = c == XY ? 2.0 : 1.0;
      off += factor * std::pow(here - fit.apply([&](int q) { return m.stress[q][c]; }), 2);
      size += factor * here * here;
    }
    sum += off;
    largest = std::max(largest, size);
  }
  return std::sqrt(sum / X.size() / largest);
}

Rest settle(const Deposit& d) {
  Model model = model_of(d);
  for (int k = 0; k < d.steps; ++k) model.advance(1.0 / d.steps);
  Rest r;
  r.X = model.world->discretisation->point_origins();
  r.stress = model.material().stress;
  r.settlement = -model.gauge_end().y();
  r.noise = noise_of(model);
  std::vector<double> mean(d.cells, 0.0), volume(d.cells, 0.0);
  for (std::size_t p = 0; p < r.X.size(); ++p) {
    const int layer = static_cast<int>(r.X[p].y() / depth * d.cells);
    mean[layer] += r.stress[p][YY] * model.material().volume[p];
    volume[layer] += model.material().volume[p];
  }
  for (int k = 0; k < d.cells; ++k)
    r.mean_error =
        std::max(r.mean_error, std::abs(mean[k] / volume[k] + weight * (1.0 - (k + 0.5) / d.cells)) / weight);
  return r;
}

/// Settlement of the top: small strain, or Hencky's solid, whose stretch under the Cauchy stress -s is W(s/M) M/s.
double exact_settlement(const Deposit& d) {
  const double x = weight / constrained(d.youngs), w = lambert_w(x);
  return d.kinematics == "small" ? 0.5 * depth * x : depth * (1.0 - (w + 0.5 * w * w) / x);
}

void record_row(const std::string& quantity, double reached, const std::string& reference, const std::string& tolerance,
                const std::string& source) {
  record({"Deposit of soil (V24)", quantity, reached, reference, tolerance, source});
}

double worst_ratio_error(const Rest& r) {
  double worst = 0.0;
  for (const Voigt& s : r.stress) worst = std::max(worst, std::abs(s[XX] / s[YY] - at_rest) / at_rest);
  return worst;
}

TEST(Geostatic, StressAtRest) {
  const std::string formula = "nu/(1 - nu), density times gravity times depth";
  for (const Deposit& d : {Deposit{}, Deposit{.method = "fem"}, Deposit{.kinematics = "finite"},
                           Deposit{.kinematics = "finite", .formulation = "total_lagrangian", .youngs = 1e6}}) {
    const Rest r = settle(d);
    const std::string name =
        fmt::format("{}, {} strain{}, E = {:.0f} MPa, {} cells", d.method, d.kinematics,
                    d.formulation == "total_lagrangian" ? ", total Lagrangian" : "", d.youngs * 1e-6, d.cells);
    EXPECT_LT(worst_ratio_error(r), 1e-9) << name;
    EXPECT_LT(r.mean_error, 1e-8) << name;
    EXPECT_LT(r.noise, 0.01) << name;
    record_row(name + ": horizontal over vertical stress, largest relative error", worst_ratio_error(r), "0", "1e-9",
               formula);
    record_row(name + ": vertical stress, means of cells, largest error over that at the base", r.mean_error, "0",
               "1e-8", formula);
    record_row(name + ": stress noise", r.noise, "0", "1 %", "linear stress");
    const double exact = exact_settlement(d);
    const bool nodes_exact = d.kinematics == "small";  // linear elements in one dimension are exact at their nodes
    EXPECT_NEAR(r.settlement, exact, (nodes_exact ? 1e-9 : 1e-4) * exact) << name;
    record_row(name + ": settlement [m]", r.settlement, fmt::format("{:.6g}", exact), nodes_exact ? "1e-9" : "0.01 %",
               nodes_exact ? "density gravity depth^2 / 2 M" : "Hencky's solid (Lambert's W)");
  }
}

/// Within a linear cell the vertical strain is constant and the exact stress is not: points at the Gauss places are off
/// by (cell size) / sqrt(12), over the depth. No cell oscillates against its neighbours.
TEST(Geostatic, NoiseFallsWithTheCells) {
  for (const int cells : {10, 20, 40, 80}) {
    Deposit d;
    d.cells = cells;
    const double noise = settle(d).noise, bound = 1.0 / std::sqrt(12.0) / cells;
    EXPECT_LT(noise, bound);
    EXPECT_GT(noise, 0.5 * bound);
    record_row(fmt::format("mpm, small strain, {} cells: stress noise", cells), noise, fmt::format("< {:.3g}", bound),
               "as it should be", "cell size / sqrt(12) over the depth");
  }
  const double quadratic = settle({.method = "fem", .cells = 10, .order = 2}).noise;
  EXPECT_LT(quadratic, 1e-8);
  record_row("fem, quad8, 10 cells: stress noise", quadratic, "0", "1e-8", "linear stress");
}

/// Largest difference of any component of the stress of any point, over the vertical one at the base.
double stress_difference(const Rest& a, const Rest& b) {
  double worst = 0.0;
  for (std::size_t p = 0; p < a.X.size(); ++p) {
    EXPECT_LT((a.X[p] - b.X[p]).norm(), 1e-9);
    worst = std::max(worst, (a.stress[p] - b.stress[p]).cwiseAbs().maxCoeff() / weight);
  }
  return worst;
}

/// Gravity in one step and in twenty. Equal to the tolerance of the solver where the points see the same grid all the
/// time; updated Lagrangian points have moved in their cells by up to the settlement over the cell size.
TEST(Geostatic, OneStepOfGravityAndTwenty) {
  struct Pair {
    std::string name;
    Deposit deposit;
    double demanded;  ///< of the stress; of the settlement
    std::string why;
  };
  const Deposit finite{.kinematics = "finite"}, soft{.kinematics = "finite", .youngs = 1e6};
  Deposit total = soft, total_fem = soft, weak{.cohesion = 5e3, .friction = 20.0}, weak_finite = weak, weak_total;
  total.formulation = "total_lagrangian";
  total_fem.method = "fem";
  weak_finite.kinematics = "finite";
  weak_total = weak_finite;
  weak_total.formulation = "total_lagrangian";
  for (const Pair& pair :
       {Pair{"elastic, small strain", {}, 1e-8, "same equations"},
        Pair{"elastic, fem, E = 1 MPa", total_fem, 1e-8, "same equations"},
        Pair{"elastic, total Lagrangian, E = 1 MPa", total, 1e-8, "same equations"},
        Pair{"elastic, updated Lagrangian, E = 50 MPa", finite, 5e-3, "settlement of 15 mm in cells of 250 mm"},
        Pair{"Mohr-Coulomb, small strain", weak, 1e-8, "proportional loading"},
        Pair{"Mohr-Coulomb, total Lagrangian, E = 50 MPa", weak_total, 1e-4,
             "proportional loading but for the stretch"},
        Pair{"Mohr-Coulomb, updated Lagrangian, E = 50 MPa", weak_finite, 5e-3, "as the elastic one"}}) {
    Deposit slow = pair.deposit;
    slow.steps = 20;
    const Rest once = settle(pair.deposit), ramped = settle(slow);
    const double stress = stress_difference(once, ramped), top = std::abs(ramped.settlement / once.settlement - 1.0);
    EXPECT_LT(stress, pair.demanded) << pair.name;
    EXPECT_LT(top, pair.demanded) << pair.name;
    const std::string tolerance = fmt::format("{:.0e}", pair.demanded);
    record_row(pair.name + ", 1 and 20 steps: largest difference of stress over that at the base", stress, "0",
               tolerance, pair.why);
    record_row(pair.name + ", 1 and 20 steps: difference of settlement", top, "0", tolerance, pair.why);
  }
}

/// Soil of 20 degrees and 5 kPa is weaker than the stress at rest below a certain depth: there the horizontal stress is
/// the active one.
TEST(Geostatic, YieldsToTheActivePressure) {
  constexpr double cohesion = 5e3, friction = 20.0;
  const double Ka = std::pow(std::tan((45.0 - 0.5 * friction) * std::numbers::pi / 180.0), 2);
  const double first = 2.0 * cohesion * std::sqrt(Ka) / (Ka - at_rest);  // vertical stress at yield
  for (const std::string method : {"mpm", "fem"}) {
    const Rest r = settle({.method = method, .steps = 5, .cohesion = cohesion, .friction = friction});
    double worst = 0.0;
    int active = 0;
    for (const Voigt& s : r.stress) {
      const double v = -s[YY];
      const double exact = v < first ? at_rest * v : Ka * v - 2.0 * cohesion * std::sqrt(Ka);
      active += v > first;
      worst = std::max(worst, std::abs(-s[XX] - exact) / weight);
      worst = std::max(worst, std::abs(-s[ZZ] - exact) / weight);
    }
    EXPECT_LT(worst, 1e-8);
    EXPECT_LT(r.mean_error, 1e-8);
    EXPECT_NEAR(active / double(r.stress.size()), 1.0 - first / weight, 0.03);
    record_row(method + ", 20 deg, 5 kPa: horizontal stresses, largest error over the vertical one at the base", worst,
               "0", "1e-8", "at rest above, Rankine's active pressure below");
  }
}

/// Oedometer: 100 kPa on soil of E = 1 MPa.
TEST(Geostatic, Oedometer) {
  constexpr double pressure = 100e3;
  for (const std::string kinematics : {"small", "finite"})
    for (const std::string method : {"mpm", "fem"}) {
      const Deposit d{.method = method,
                      .kinematics = kinematics,
                      .formulation = "total_lagrangian",
                      .youngs = 1e6,
                      .cells = 10,
                      .steps = 5,
                      .surcharge = pressure};
      const Rest r = settle(d);
      const double x = pressure / constrained(d.youngs);
      const double exact = depth * (kinematics == "small" ? x : 1.0 - lambert_w(x) / x);
      EXPECT_NEAR(r.settlement, exact, 1e-8 * exact);
      EXPECT_LT(worst_ratio_error(r), 1e-8);
      for (const Voigt& s : r.stress) EXPECT_NEAR(s[YY], -pressure, 1e-8 * pressure);
      record_row(fmt::format("oedometer, {}, {} strain: settlement [m]", method, kinematics), r.settlement,
                 fmt::format("{:.6g}", exact), "1e-8 relative",
                 kinematics == "small" ? "pressure over M" : "Hencky's solid (Lambert's W)");
    }
}

}  // namespace
}  // namespace berm::verify
