/// Newton's method in space, and the iterative linear solver inside it: order of convergence, agreement with the direct
/// solver, and the way out when the iterations stagnate.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "driver.hpp"

namespace berm::verify {
namespace {

constexpr int steps = 10;

/// A block of 4 x 4 x 4 cells whose lower side is clamped along its left half and whose upper side is pulled up without
/// sideways motion.
std::string case_text(const std::string& method, const std::string& law, const std::string& kinematics) {
  std::string keys = fmt::format("law = \"{}\"\n", law);
  if (law == "simo_ju") keys += "strength_ratio = 12.3\n";
  if (law != "linear_elastic") keys += "tensile_strength = 3.05e6\nfracture_energy = 4000.0\n";
  return fmt::format(R"(
method = "{}"
[model]
dimension = 3
kinematics = "{}"
[grid]
cells = [4, 4, 4]
cell_size = 0.025
[material.m]
density = 2400.0
youngs_modulus = 35.5e9
poisson_ratio = 0.2
{}
[body.b]
material = "m"
shape.box = {{ min = [0.0, 0.0, 0.0], max = [0.1, 0.1, 0.1] }}
mesh = {{ kind = "hexahedra", size = 0.025 }}
[boundary.base]
where.box = {{ min = [-1.0, -1e-6, -1.0], max = [0.050001, 1e-6, 1.0] }}
ux = 0.0
uy = 0.0
uz = 0.0
[boundary.top]
where.box = {{ min = [-1.0, 0.099999, -1.0], max = [1.0, 0.100001, 1.0] }}
ux = 0.0
uy = 2.4e-5
uz = 0.0
[steps]
count = {}
adaptive = false
[solver]
relative_tolerance = 1e-9
absolute_tolerance = 1e-14
)",
                     method, kinematics, keys, steps);
}

TEST(SolidNewton, QuadraticInDamagingSteps) {
  for (const std::string method : {"mpm", "fem"})
    for (const std::string law : {"simo_ju", "rankine"})
      for (const std::string kinematics : {"small", "finite"}) {
        Model model(case_text(method, law, kinematics));
        std::vector<double> found = newton_orders(model, steps);
        ASSERT_GE(found.size(), 3u) << method << " " << law << " " << kinematics;
        EXPECT_GT(model.material().max_damage(), 0.05);
        std::nth_element(found.begin(), found.begin() + found.size() / 2, found.end());
        const double median = found[found.size() / 2];
        EXPECT_GT(median, 1.7) << method << " " << law << " " << kinematics;
        record({"Newton in space",
                fmt::format("{}, {}, {} strain: median order in damaging steps", method, law, kinematics), median, "2",
                "> 1.7", "quadratic convergence of Newton's method"});
      }
}

struct Outcome {
  std::vector<Vec3> u;
  LinearCount count;
  double damage = 0.0;
};

Outcome solve(const std::string& method, const std::string& law, const std::string& linear,
              const std::string& integration) {
  Model model(case_text(method, law, "small"),
              {fmt::format("solver.linear=\"{}\"", linear), fmt::format("solver.integration=\"{}\"", integration),
               "solver.linear_tolerance=1e-10"});
  for (int k = 0; k < steps; ++k)
    if (!model.advance(1.0 / steps).converged) break;
  return {model.world->discretisation->point_displacements(), model.step.linear_count(), model.material().max_damage()};
}

double difference(const Outcome& a, const Outcome& b) {
  double most = 0.0, size = 0.0;
  for (std::size_t p = 0; p < a.u.size(); ++p) {
    most = std::max(most, (a.u[p] - b.u[p]).norm());
    size = std::max(size, b.u[p].norm());
  }
  return most / size;
}

void expect_agreement(const std::string& method, const std::string& law, const std::string& integration) {
  const std::string name = fmt::format("{}, {}, {}", method, law, integration);
  SCOPED_TRACE(name);
  const Outcome direct = solve(method, law, "direct", integration),
                iterative = solve(method, law, "iterative", integration);
  fmt::print("  {}: damage {:.3f}, {} solves, {} iterations\n", name, iterative.damage, iterative.count.solves,
             iterative.count.iterations);
  EXPECT_EQ(iterative.count.fallbacks, 0);
  EXPECT_GT(iterative.count.iterations, iterative.count.solves);
  EXPECT_GT(direct.damage, law == "linear_elastic" ? -1.0 : 0.05);
  const double gap = difference(iterative, direct);
  EXPECT_LT(gap, 1e-7);
  record({"Newton in space", name + ": difference of the displacements, multigrid and direct solver", gap, "0", "1e-7",
          "the same equations"});
}

TEST(SolidNewton, IterativeAndDirectSolversAgree) {
  for (const std::string method : {"mpm", "fem"}) {
    expect_agreement(method, "linear_elastic", "implicit");
    expect_agreement(method, "simo_ju", "impl_ex");
    expect_agreement(method, "simo_ju", "implicit");  // unsymmetric
  }
}

/// Sets a PETSc option for the time being; `after` is what the program would take without it.
struct PetscOption {
  PetscOption(const std::string& now, std::string after) : after_(std::move(after)) { start_petsc(now); }
  ~PetscOption() { start_petsc(after_); }
  std::string after_;
};

TEST(SolidNewton, StagnatingIterationsFallBackOnTheDirectSolver) {
  for (const std::string law : {"linear_elastic", "simo_ju"}) {
    SCOPED_TRACE(law);
    const Outcome direct = solve("mpm", law, "direct", "implicit");
    Outcome stuck;
    {
      const PetscOption one("-ksp_max_it 1", "-ksp_max_it 500");
      stuck = solve("mpm", law, "iterative", "implicit");
    }
    EXPECT_EQ(stuck.count.fallbacks, stuck.count.solves);
    EXPECT_LE(stuck.count.iterations, 3);  // given up after three systems that it did not solve
    const double gap = difference(stuck, direct);
    EXPECT_LT(gap, 1e-7);
    record(
        {"Newton in space",
         fmt::format("mpm, {}: difference of the displacements, one Krylov iteration allowed, and direct solver", law),
         gap, "0", "1e-7", "the same equations"});
    record({"Newton in space", fmt::format("mpm, {}: systems that fell back on the direct solver, of all", law),
            double(stuck.count.fallbacks) / stuck.count.solves, "1", "1", "counted"});
  }
}

}  // namespace
}  // namespace berm::verify
