/// A specimen whose outline cuts the cells of the grid anywhere: stiffness and Newton's method must not notice.

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>

#include "../support/dense.hpp"
#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr double h = 0.0125, youngs = 35.5e9;

/// Offsets of the grid in cells.
const std::vector<double> offsets = {0.0, 1e-9, 1e-6, 1e-3, 0.01, 0.1, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999, 1.0 - 1e-6};

std::string common(double offset, double width, double height, const std::string& law) {
  return fmt::format(R"(
[model]
plane = "stress"
[grid]
origin = [{}, {}]
cell_size = {}
cells = [12, 20]
[material.m]
density = 2400.0
youngs_modulus = {}
poisson_ratio = 0.2
{}
[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0], max = [{}, {}] }}
[gauge.height]
from = [0.05, 0.05]
to = [0.05, 0.15]
)",
                     -2 * h - offset * h, -2 * h - offset * h, h, youngs, law, width, height);
}

const std::string elastic = "law = \"linear_elastic\"";

struct Reached {
  double modulus = 0.0;  ///< nominal stress over gauge strain
  int iterations = 0;
  double damage = 0.0;
  double noise = 0.0;  ///< root mean square of the error of the stress at points, over the stress
};

/// Uniaxial pull by equal pressures on top and base: the exact strain is uniform.
Reached pulled(double offset, const std::vector<std::string>& overrides = {}) {
  constexpr double stress = 1e6;
  Model model(common(offset, 8 * h, 16 * h, elastic) + fmt::format(R"(
[pressure.top]
body = "b"
where.box = {{ min = [-1.0, {0}], max = [1.0, {1}] }}
value = {2}
[pressure.base]
body = "b"
where.box = {{ min = [-1.0, -1e-6], max = [1.0, 1e-6] }}
value = {2}
[pin.low]
body = "b"
at = [0.05, 0.05]
fix = "xy"
[pin.high]
body = "b"
at = [0.05, 0.15]
fix = "x"
[steps]
count = 2
adaptive = false
)",
                                                                   16 * h - 1e-6, 16 * h + 1e-6, -stress),
              overrides);
  Reached r;
  for (int k = 0; k < 2; ++k) r.iterations = std::max(r.iterations, model.advance(0.5).iterations);
  r.modulus = stress / (model.world->boundary->gauges()[0].elongation() / 0.1);
  Voigt exact = Voigt::Zero();
  exact[YY] = stress;
  double squares = 0.0;
  for (const Voigt& s : model.material().stress) squares += (s - exact).squaredNorm();
  r.noise = std::sqrt(squares / model.material().size()) / stress;
  return r;
}

TEST(CutCells, UniaxialStiffnessIsExact) {
  double worst = 0.0;
  int most = 0;
  for (const double offset : offsets) {
    const Reached r = pulled(offset);
    fmt::print("  offset {}: E {:.8g}, {} linear solves\n", offset, r.modulus, r.iterations);
    worst = std::max(worst, relative(r.modulus, youngs));
    most = std::max(most, r.iterations);
  }
  EXPECT_LT(worst, 1e-4);  // the strain is 2.8e-5: finite strain is that much stiffer
  EXPECT_LE(most, 6);
  record({"Cut cells", fmt::format("uniaxial pull, {} grid offsets: largest error of Young's modulus", offsets.size()),
          worst, "0", "1e-4", "uniform stress"});
  record({"Cut cells", "the same: most linear solves in a step", double(most), "few", "<= 6", "Newton's method"});
}

/// Points of cut cells integrate functions of degree p well enough if there are p + 1 a direction; domains that tile
/// the body do with two.
TEST(CutCells, StressIsUniform) {
  struct Demand {
    const char* functions;
    int per_direction;
    double most;
  };
  for (const Demand& want : {Demand{"linear", 2, 0.04},
                             {"quadratic_bspline", 3, 0.01},
                             {"cubic_bspline", 4, 0.01},
                             {"b2gimp", 2, 0.002},
                             {"cpdi", 2, 0.002}}) {
    double worst = 0.0;
    for (const double offset : offsets)
      worst = std::max(worst, pulled(offset, {fmt::format("grid.shape_functions={}", want.functions),
                                              fmt::format("body.b.points.per_direction={}", want.per_direction)})
                                  .noise);
    EXPECT_LT(worst, want.most) << want.functions;
    record({"Cut cells",
            fmt::format("uniaxial pull, {}, {} points a direction: largest stress noise", want.functions,
                        want.per_direction),
            worst, "0", fmt::format("{}", want.most), "uniform stress"});
  }
}

/// Compression between rough platens, tied at both ends: no uniform field, exact stiffness unknown, but it is one
/// number.
std::string platens(double offset, const std::string& law, double strain, int steps) {
  return common(offset, 8 * h, 16 * h, law) + fmt::format(R"(
[body.top]
rigid = true
shape.box = {{ min = [0.0, {}], max = [{}, {}] }}
displacement = [0.0, {}]
[body.base]
rigid = true
shape.box = {{ min = [0.0, -0.02], max = [{}, 0.0] }}
[contact.top]
body = "b"
rigid = "top"
[contact.base]
body = "b"
rigid = "base"
[steps]
count = {}
adaptive = false
)",
                                                          16 * h, 8 * h, 16 * h + 0.02, -strain * 16 * h, 8 * h, steps);
}

Reached between_platens(double offset, const std::string& law, double strain, int steps) {
  Model model(platens(offset, law, strain, steps));
  Reached r;
  for (int k = 0; k < steps; ++k) r.iterations = std::max(r.iterations, model.advance(1.0 / steps).iterations);
  const int top = 1;  // second body of the case
  r.damage = model.material().max_damage();
  r.modulus = -model.step.balance().reactions.rigid[top].y() / (8 * h) / strain;
  return r;
}

TEST(CutCells, StiffnessBetweenPlatensDoesNotDependOnTheOffset) {
  double low = infinity, high = 0.0;
  int most = 0;
  for (const double offset : offsets) {
    const Reached r = between_platens(offset, elastic, 1e-4, 1);
    fmt::print("  offset {}: stiffness {:.8g}, {} linear solves\n", offset, r.modulus, r.iterations);
    low = std::min(low, r.modulus);
    high = std::max(high, r.modulus);
    most = std::max(most, r.iterations);
  }
  EXPECT_LT(high / low - 1.0, 0.005);
  EXPECT_LE(most, 6);
  record({"Cut cells", fmt::format("rough platens, {} grid offsets: spread of the stiffness", offsets.size()),
          high / low - 1.0, "0", "0.5 %", "the stiffness is a property of the specimen"});
}

TEST(CutCells, DamagingStepsConvergeAtEveryOffset) {
  const std::string damage =
      "law = \"simo_ju\"\ntensile_strength = 3.05e6\nstrength_ratio = 12.3\nfracture_energy = 100.0";
  double low = infinity, high = 0.0, largest = 0.0;
  int most = 0;
  for (const double offset : offsets) {
    // To 85 % of the strain at which uniaxial compression peaks: the edges of the platens are damaged, the rest is not.
    const Reached r = between_platens(offset, damage, 0.9e-3, 20);
    largest = std::max(largest, r.damage);
    fmt::print("  offset {}: {:.6g}, damage {:.4f}, {} linear solves\n", offset, r.modulus, r.damage, r.iterations);
    low = std::min(low, r.modulus);
    high = std::max(high, r.modulus);
    most = std::max(most, r.iterations);
  }
  EXPECT_LT(high / low - 1.0, 0.005);
  EXPECT_GT(largest, 0.1);
  EXPECT_LE(most, 8);
  record({"Cut cells", "rough platens, Simo-Ju, damaged edges: spread of the secant stiffness", high / low - 1.0, "0",
          "0.5 %", "the same"});
  record({"Cut cells", "the same: most linear solves in a step", double(most), "few", "<= 8", "Newton's method"});
}

// ---- with and without stabilisation, by shape function: V3

/// Ratio of the largest to the smallest eigenvalue of the matrix of the first step, ties included.
double condition_of(Model& model) {
  Discretisation& d = *model.world->discretisation;
  BoundaryConditions& boundary = *model.world->boundary;
  LawSettings settings;
  settings.space = Space::plane_stress;
  settings.kinematics = Kinematics::finite;
  d.move_points(1.2);
  boundary.move_anchors(d);
  d.begin_step(boundary.anchors());
  boundary.begin_step(d);
  NodalVector du(d.n_nodes(), Vec3::Zero()), f = du;
  EXPECT_EQ(d.evaluate(du, settings), Status::ok);
  BlockAssembler assembler;
  assembler.build(d.blocks, d.n_nodes(), d.dimension());
  assembler.zero(boundary.fixed(), d.halo.n_owned, 1.0);
  d.add_tangent(settings, assembler);
  d.add_stabilisation(du, f, &assembler);
  boundary.add_forces(d, du, 0.0, 1.0, f, &assembler);
  const Eigen::MatrixXd K = dense_of(assembler.matrix());
  const Eigen::VectorXd values =
      Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(0.5 * (K + K.transpose()), Eigen::EigenvaluesOnly).eigenvalues();
  return values.maxCoeff() / std::max(values.minCoeff(), 1e-30 * values.maxCoeff());
}

TEST(CutCells, ConditionDoesNotDependOnTheOffset) {
  constexpr const char* group = "Cut cells, 40 grid offsets between 0 and h, rough platens (V3)";
  std::vector<double> cuts = {1e-9, 1e-6, 1e-3, 1.0 - 1e-3, 1.0 - 1e-6};
  for (int k = 0; k < 35; ++k) cuts.push_back(k / 35.0);
  for (const char* functions : {"linear", "quadratic_bspline", "b2gimp", "cpdi"})
    for (const bool stabilised : {true, false}) {
      double low = infinity, high = 0.0, worst = 0.0;
      int failed = 0, fewest = 1000, most = 0;
      for (const double offset : cuts) {
        const std::string text = platens(offset, elastic, 1e-4, 1);
        std::vector<std::string> overrides = {fmt::format("grid.shape_functions={}", functions)};
        if (!stabilised) overrides.push_back("solver.ghost_penalty=0");
        Model matrix(text, overrides);
        worst = std::max(worst, condition_of(matrix));
        Model model(text, overrides);
        const StepResult r = model.step.attempt(1.0, Integration::implicit);
        if (!r.converged) {
          ++failed;
          continue;
        }
        model.step.accept();
        const double stiffness = -model.step.balance().reactions.rigid[1].y();
        low = std::min(low, stiffness);
        high = std::max(high, stiffness);
        fewest = std::min(fewest, r.iterations);
        most = std::max(most, r.iterations);
      }
      const std::string name = fmt::format("{}, {}: ", functions, stabilised ? "stabilised" : "not stabilised");
      fmt::print("  {} spread {:.2e}, {} to {} solves, {} failed, condition {:.2e}\n", name, high / low - 1.0, fewest,
                 most, failed, worst);
      record({group, name + "largest condition number", worst, stabilised ? "bounded" : "",
              stabilised ? "< 1e8" : "reported", "the smallest cut is 1e-9 h"});
      record({group, fmt::format("{}steps without solution, of {}", name, cuts.size()), double(failed),
              stabilised ? "0" : "", stabilised ? "0" : "reported", ""});
      if (!stabilised) continue;
      EXPECT_EQ(failed, 0) << functions;
      EXPECT_LT(worst, 1e8) << functions;
      EXPECT_LT(high / low - 1.0, 0.005) << functions;
      EXPECT_LE(most, std::max(fewest + 1, int(1.3 * fewest))) << functions;
      record({group, name + "spread of the stiffness", high / low - 1.0, "0", "0.5 %",
              "the stiffness is a property of the specimen"});
      record({group, name + "most linear solves in a step", double(most), fmt::format("{}", fewest),
              "fewest, and 1 or 30 %", "Newton's method"});
    }
}

/// One side of a slot of one cell, or of one and a half, moves into it by a part of a thousand: stabilisation tied it to the other side
/// (0.26 to 0.9 of the deflection, by the number of steps).
TEST(CutCells, SidesOfSlotsAreNotTied) {
  const std::string text = R"toml(
grid = {{ origin = [-0.5, -0.5], cell_size = 0.1, cells = [20, 20] }}
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = 1e8
poisson_ratio = 0.2
[body.a]
material = "m"
shape.difference = [ {{ box = {{ min = [0.0, 0.0], max = [1.0, 0.9] }} }}, {{ box = {{ min = [0.3, {}], max = [1.1, {}] }} }} ]
mesh = {{ kind = "quads", size = 0.05, order = 2, structured = true }}
[boundary.base]
where.box.max = [9.0, 1e-6]
ux = 0.0
uy = 0.0
[pressure.top]
body = "a"
where.box.min = [0.4999, 0.8999]
value = 1000.0
[gauge.tip]
from = [0.1, 0.02]
to = [0.98, 0.88]
[steps]
count = 1
)toml";
  for (const auto& [low, high] : {std::pair(0.4, 0.5), std::pair(0.45, 0.6)}) {
    const std::string slot = fmt::format(fmt::runtime(text), low, high);
    Model fem(case_by_default(slot, {"method=\"fem\""}));
    ASSERT_TRUE(fem.run());
    for (const int count : {1, 5, 20}) {
      Model m(case_by_default(slot, {fmt::format("steps.count={}", count)}));
      ASSERT_TRUE(m.run());
      EXPECT_LT(relative(m.gauge_end().y(), fem.gauge_end().y()), low < 0.42 ? 0.1 : 0.2) << count;  // 4 linear cells through an arm, or 3.5
    }
  }
}

/// Corners of domains that had moved a hair's breadth into a triangle which touches the body at a vertex gave it nodes that hung on
/// nothing: surface points flew hundreds of metres, or the matrix was singular.
TEST(CutCells, BodiesWhoseEdgesAreLinesOfTriangles) {
  const std::string text = R"toml(
grid = { origin = [-0.5, -0.5], cell_size = 0.1, cells = [25, 20], kind = "triangles_right" }
[material.m]
law = "linear_elastic"
density = 2000.0
youngs_modulus = "10 MPa"
poisson_ratio = 0.3
[body.a]
material = "m"
shape.box = { min = [0.0, 0.0], max = [1.0, 0.5] }
[boundary.left]
where.box.max = [1e-6, 9.0]
ux = 0.0
[boundary.bottom]
where.box = { min = [-1.0, -1.0], max = [1e-6, 1e-6] }
uy = 0.0
[boundary.right]
body = "a"
where.box.min = [0.9999, -9.0]
ux = 0.1
[steps]
count = 10
)toml";
  // Hencky's law in plane strain: stress over J = E / (1 - nu2) ln(l), height l^(-nu / (1 - nu)) of the old one.
  const double stretch = 1.1, nu = 0.3;
  const double expected = 0.5 * 1e7 / (1.0 - nu * nu) * std::log(stretch) / stretch;
  for (const std::string kind : {"triangles_right", "triangles_left", "union_jack"}) {
    Model m(case_by_default(text, {"grid.kind=" + kind}));
    ASSERT_TRUE(m.run()) << kind;
    EXPECT_LT(relative(m.step.balance().reactions.boundary[2].x(), expected), 0.005) << kind;
  }
}

}  // namespace
}  // namespace berm::verify
