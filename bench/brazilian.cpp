/// Where the time of a step goes: the Brazilian disc at three sizes, implicit and IMPL-EX. See bench/README.md.
///
///     brazilian [--csv FILE] [--steps N] [DOFS ...]      default: 5 steps of 10000, 40000 and 160000 dofs

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

#include "case/read_case.hpp"
#include "la/newton.hpp"
#include "sim/implicit_step.hpp"
#include "sim/world.hpp"

namespace {

using berm::Integration;

struct Row {
  std::string integration;
  int dofs = 0, points = 0, steps = 0, solves = 0;
  double connectivity = 0.0, laws = 0.0, assembly = 0.0, linear = 0.0, step = 0.0;  // seconds a step
};

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// The case with a cell size that gives about `dofs` unknowns: two a cell of the disc.
berm::Case disc(int dofs) {
  constexpr double radius = 0.075;
  const double h = radius * std::sqrt(2.0 * std::numbers::pi / dofs);
  const int half = static_cast<int>(std::ceil(radius / h)) + 1;
  return berm::read_case(BERM_SOURCE_DIR "/bench/brazilian.toml",
                         {fmt::format("grid.cell_size={}", h), fmt::format("grid.cells=[{0},{0}]", 2 * half),
                          fmt::format("grid.origin=[{0},{0}]", -half * h)});
}

void take(berm::ImplicitStep& step, double dt, Integration integration, int& solves) {
  const berm::StepResult result = step.attempt(dt, integration);
  if (!result.converged) throw std::runtime_error("a step of the benchmark does not converge: " + result.reason);
  solves += result.iterations;
  step.accept();
}

/// `steps` steps just before the peak load, while the centre and the edges of the jaws soften.
Row measure(int dofs, Integration integration, int steps) {
  auto world = berm::build_world(disc(dofs));
  berm::ImplicitStep step(*world);
  Row row;
  int unused = 0;
  take(step, 0.5, Integration::implicit, unused);
  take(step, 0.02, integration, unused);
  const berm::StepTimes before = step.times();
  const double start = now();
  for (int k = 0; k < steps; ++k) take(step, 0.1 / steps, integration, row.solves);
  row.step = (now() - start) / steps;
  const berm::StepTimes after = step.times();
  row.integration = integration == Integration::implicit ? "implicit" : "impl_ex";
  row.dofs = step.unknowns();
  row.points = world->discretisation->material.size();
  row.steps = steps;
  row.connectivity = (after.connectivity - before.connectivity) / steps;
  row.laws = (after.response - before.response) / steps;
  row.assembly = (after.assembly - before.assembly) / steps;
  row.linear = (after.linear - before.linear) / steps;
  return row;
}

void write_csv(const std::string& path, const std::vector<Row>& rows) {
  std::ofstream out(path);
  out << "integration,dofs [-],points [-],steps [-],linear_solves [-],connectivity [s],laws [s],assembly [s],linear "
         "[s],step [s]\n";
  for (const Row& r : rows)
    out << fmt::format("{},{},{},{},{},{},{},{},{},{}\n", r.integration, r.dofs, r.points, r.steps, r.solves,
                       r.connectivity, r.laws, r.assembly, r.linear, r.step);
  if (!out) throw std::runtime_error("cannot write " + path);
}

int run(const std::vector<std::string>& words) {
  std::string csv;
  int steps = 5;
  std::vector<int> sizes;
  for (std::size_t k = 0; k < words.size(); ++k) {
    const bool option = words[k] == "--csv" || words[k] == "--steps";
    if (option && k + 1 == words.size()) throw std::runtime_error(words[k] + " needs a value");
    if (words[k] == "--csv")
      csv = words[++k];
    else if (words[k] == "--steps")
      steps = std::stoi(words[++k]);
    else
      sizes.push_back(std::stoi(words[k]));
  }
  if (sizes.empty()) sizes = {10000, 40000, 160000};
  if (steps < 1) throw std::runtime_error("--steps must be at least 1");

  berm::start_petsc();
  std::vector<Row> rows;
  fmt::print("milliseconds a step, mean of {} steps\n", steps);
  fmt::print("{:<12}{:>8}{:>9}{:>8}{:>14}{:>8}{:>10}{:>10}{:>9}{:>9}{:>26}\n", "integration", "dofs", "points",
             "solves", "connectivity", "laws", "assembly", "linear", "rest", "step", "(laws + assembly)/linear");
  for (const Integration integration : {Integration::implicit, Integration::impl_ex})
    for (const int dofs : sizes) {
      const Row r = measure(dofs, integration, steps);
      rows.push_back(r);
      const double rest = r.step - r.connectivity - r.laws - r.assembly - r.linear;
      fmt::print("{:<12}{:>8}{:>9}{:>8.1f}{:>14.1f}{:>8.1f}{:>10.1f}{:>10.1f}{:>9.1f}{:>9.1f}{:>26.2f}\n",
                 r.integration, r.dofs, r.points, double(r.solves) / steps, 1e3 * r.connectivity, 1e3 * r.laws,
                 1e3 * r.assembly, 1e3 * r.linear, 1e3 * rest, 1e3 * r.step, (r.laws + r.assembly) / r.linear);
      std::fflush(stdout);
    }
  if (!csv.empty()) write_csv(csv, rows);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "brazilian: {}\n", error.what());
    return 1;
  }
}
