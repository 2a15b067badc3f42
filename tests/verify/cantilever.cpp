/// Cantilever bent by its own weight (8 m x 1 m, E = 90 MPa, nu = 0, 1000 kg/m3) in one load step: MPM against FEM
/// (both with the increment of F from gradients on the configuration at t_n), both against a geometrically exact beam,
/// and the order of convergence.

#include <fmt/format.h>

#include <cmath>

#include "driver.hpp"
#include "exact_beam.hpp"

namespace berm::verify {
namespace {

constexpr double length = 8.0, depth = 1.0, youngs = 90e6, density = 1000.0, gravity = 9.81;

/// Tip deflection of the geometrically exact beam under dead weight (kappa = 5/6, nu = 0).
double exact_beam() {
  ExactBeam beam;
  beam.length = length;
  beam.bending = youngs * std::pow(depth, 3) / 12.0;
  beam.tension_compliance = 1.0 / (youngs * depth);
  beam.shear_compliance = 1.0 / (5.0 / 6.0 * 0.5 * youngs * depth);
  beam.outer_force = [](double s) { return -density * gravity * depth * (length - s); };
  return beam.tip().down;
}

std::string case_text(const std::string& method, double h, double grid_shift) {
  return fmt::format(R"(
method = "{}"
[model]
plane = "strain"
gravity = [0.0, {}]
[grid]
origin = [0.0, {}]
cell_size = {}
cells = [{}, {}]
[material.m]
law = "linear_elastic"
density = {}
youngs_modulus = {}
poisson_ratio = 0.0
[body.beam]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [{}, {}] }}
mesh = {{ kind = "quads", size = {}, structured = true }}
[boundary.clamp]
where.box = {{ min = [-1e-6, -10.0], max = [1e-6, 10.0] }}
ux = 0.0
uy = 0.0
[gauge.tip]
from = [4.0, 0.5]
to = [7.999999, 0.5]
[steps]
count = 1
adaptive = false
)",
                     method, -gravity, -2.0 + grid_shift, h, std::lround(8.5 / h), std::lround(4.0 / h), density,
                     youngs, length, depth, h);
}

double deflection(const std::string& method, double h, double grid_shift = 0.0, int steps = 1, int order = 1,
                  const std::string& formulation = "updated_lagrangian") {
  Model model(case_text(method, h, grid_shift),
              {fmt::format("steps.count={}", steps), fmt::format("body.beam.mesh.order={}", order),
               fmt::format("model.formulation=\"{}\"", formulation)});
  for (int k = 0; k < steps; ++k)
    if (!model.advance(1.0 / steps).converged) return NAN;
  return -model.gauge_end().y();
}

TEST(Cantilever, OneStepMpmEqualsFem) {
  const double fem = deflection("fem", 0.1), mpm = deflection("mpm", 0.1);
  // With points at Gauss positions and one step from the undeformed state both methods are the same equations.
  EXPECT_NEAR(mpm, fem, 1e-7 * fem);
  record({"Cantilever, self-weight", "80 x 10 quads, one step: MPM over FEM - 1", mpm / fem - 1.0, "0", "1e-7",
          "FEM of this program, total Lagrangian"});
  const double exact = exact_beam();
  EXPECT_NEAR(mpm, exact, 0.005 * exact);
  record({"Cantilever, self-weight", "80 x 10 quads, one step: MPM tip deflection [m]", mpm,
          fmt::format("{:.5f}", exact), "0.5 %", "geometrically exact beam (Reissner), kappa = 5/6"});
  const double quadratic = deflection("fem", 0.1, 0.0, 1, 2);
  EXPECT_NEAR(quadratic, exact, 0.001 * exact);
  record({"Cantilever, self-weight", "80 x 10 quad8, one step: FEM tip deflection [m]", quadratic,
          fmt::format("{:.5f}", exact), "0.1 %", "the same beam"});
}

TEST(Cantilever, CutCellsAndManySteps) {
  const double fem = deflection("fem", 0.1);
  for (const double shift : {0.25, 0.5, 0.9}) {
    const double mpm = deflection("mpm", 0.1, shift * 0.1);
    EXPECT_NEAR(mpm, fem, 0.005 * fem);
    record({"Cantilever, self-weight", fmt::format("80 x 10 quads shifted by {} h: MPM tip deflection [m]", shift), mpm,
            fmt::format("{:.5f}", fem), "0.5 %", "quad4 FEM of this program, one step"});
  }
  for (const int steps : {5, 20}) {
    const double mpm = deflection("mpm", 0.1, 0.0, steps);
    EXPECT_NEAR(mpm, fem, 0.02 * fem);
    record({"Cantilever, self-weight", fmt::format("80 x 10 quads, {} steps: MPM tip deflection [m]", steps), mpm,
            fmt::format("{:.5f}", fem), "2 %", "quad4 FEM of this program, one step"});
  }
}

TEST(Cantilever, TotalLagrangianDoesNotDependOnTheNumberOfSteps) {
  const double fem = deflection("fem", 0.1), mpm = deflection("mpm", 0.1, 0.0, 20, 1, "total_lagrangian");
  EXPECT_NEAR(mpm, fem, 1e-7 * fem);
  record({"Cantilever, self-weight", "80 x 10 quads, 20 steps, total Lagrangian: MPM over FEM - 1", mpm / fem - 1.0,
          "0", "1e-7", "quad4 FEM of this program, one step"});
}

TEST(Cantilever, SecondOrderInCellSize) {
  for (const std::string method : {"fem", "mpm"})
    for (const double shift : {0.0, 0.5}) {
      if (method == "fem" && shift > 0.0) continue;
      double w[4], h = 0.5;
      for (double& value : w) {
        value = deflection(method, h, shift * h);
        fmt::print("  {} h = {}: {:.6f}\n", method, h, value);
        h *= 0.5;
      }
      const double order = std::log2((w[2] - w[1]) / (w[3] - w[2]));
      EXPECT_NEAR(order, 2.0, 0.3);
      record({"Cantilever, self-weight",
              fmt::format("{}{}: order of the tip deflection, h = 1/4, 1/8, 1/16", method,
                          shift > 0.0 ? ", beam faces in mid-cell" : ""),
              order, "2", "0.3", "bilinear functions"});
    }
}

}  // namespace
}  // namespace berm::verify
