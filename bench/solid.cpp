/// Where the time of a step goes in space: a cube of concrete between rough platens at several sizes. See bench/README.md.
///
///     solid [--csv FILE] [--steps N] [--memory POINTS] [--petsc OPTIONS] [DOFS ...]
///     mpiexec -n 2 solid ...
///
/// Default: 2 implicit steps of 30000, 150000 and 500000 unknowns while the edges soften. --memory: builds a cube of that
/// many points, takes no step, and reports what it holds.

#include <fmt/format.h>
#include <malloc.h>

#include <chrono>
#include <cmath>
#include <fstream>
#include <string>
#include <vector>

#include "case/read_case.hpp"
#include "la/newton.hpp"
#include "sim/implicit_step.hpp"
#include "sim/world.hpp"

namespace {

using berm::Integration;

struct Row {
  long dofs = 0, points = 0;
  int processes = 1, solves = 0;
  double connectivity = 0.0, laws = 0.0, assembly = 0.0, linear = 0.0, step = 0.0;  // seconds a linear solve
  double krylov = 0.0;                                                             // iterations a linear solve
  double bytes_per_point = 0.0, bytes_per_dof = 0.0;
};

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

/// Bytes of memory in use ("VmRSS") or at most so far ("VmHWM") by this process.
double memory(const char* key) {
  std::ifstream status("/proc/self/status");
  std::string word;
  while (status >> word)
    if (word == std::string(key) + ":") {
      double kilobytes = 0.0;
      status >> kilobytes;
      return 1024.0 * kilobytes;
    }
  return 0.0;
}

berm::Case cube(int cells, const std::string& petsc) {
  return berm::read_case(BERM_SOURCE_DIR "/bench/solid.toml",
                         {fmt::format("grid.cells=[{0},{0},{0}]", cells), "solver.petsc=\"" + petsc + "\""});
}

void take(berm::ImplicitStep& step, double dt, int& solves) {
  const berm::StepResult result = step.attempt(dt, Integration::implicit);
  if (!result.converged) throw std::runtime_error("a step of the benchmark does not converge: " + result.reason);
  solves += result.iterations;
  step.accept();
}

Row measure(int dofs, int steps, const std::string& petsc, const berm::Comm& comm) {
  const int cells = static_cast<int>(std::lround(std::cbrt(dofs / 3.0))) - 1;
  malloc_trim(0);  // what the size before this one has freed is not to hide what this one takes
  const double before = memory("VmRSS");
  auto world = berm::build_world(cube(cells, petsc), comm);
  malloc_trim(0);
  const double built = memory("VmRSS");
  berm::ImplicitStep step(*world);
  int unused = 0;
  take(step, 0.6, unused);  // close to the first damage at the edges
  const berm::StepTimes start = step.times();
  const long krylov = step.linear_count().iterations;
  const double began = now();
  Row row;
  for (int k = 0; k < steps; ++k) take(step, 0.02, row.solves);
  const double n = row.solves;
  row.step = (now() - began) / n;
  const berm::StepTimes end = step.times();
  row.processes = comm.size();
  row.dofs = step.unknowns();
  row.points = world->n_points();
  row.krylov = (step.linear_count().iterations - krylov) / n;
  row.connectivity = (end.connectivity - start.connectivity) / n;
  row.laws = (end.response - start.response) / n;
  row.assembly = (end.assembly - start.assembly) / n;
  row.linear = (end.linear - start.linear) / n;
  row.bytes_per_point = comm.sum(built - before) / row.points;
  malloc_trim(0);
  row.bytes_per_dof = comm.sum(memory("VmRSS") - built) / row.dofs;
  return row;
}

void report_memory(int points, const berm::Comm& comm) {
  const int cells = static_cast<int>(std::lround(std::cbrt(points / 8.0)));
  auto world = berm::build_world(cube(cells, ""), comm);
  const long n = world->n_points();
  const double held = comm.sum(memory("VmRSS")), most = comm.sum(memory("VmHWM"));
  if (comm.is_root())
    fmt::print("{} points: {:.0f} MB held after the set-up, {:.0f} MB at most during it, {:.0f} bytes a point\n", n,
               held / 1e6, most / 1e6, held / n);
}

void print(const Row& r) {
  fmt::print("{:>9}{:>8}{:>9}{:>8}{:>14.3f}{:>8.3f}{:>10.3f}{:>9.3f}{:>9.3f}{:>9.1f}{:>13.0f}{:>11.0f}\n", r.processes,
             r.dofs, r.points, r.solves, r.connectivity, r.laws, r.assembly, r.linear, r.step, r.krylov,
             r.bytes_per_point, r.bytes_per_dof);
  std::fflush(stdout);
}

void write_csv(const std::string& path, const std::vector<Row>& rows) {
  std::ofstream out(path);
  out << "processes [-],dofs [-],points [-],linear_solves [-],connectivity [s],laws [s],assembly [s],linear [s],all [s],"
         "krylov [-],bytes_per_point [-],bytes_per_dof [-]\n";
  for (const Row& r : rows)
    out << fmt::format("{},{},{},{},{},{},{},{},{},{},{},{}\n", r.processes, r.dofs, r.points, r.solves, r.connectivity,
                       r.laws, r.assembly, r.linear, r.step, r.krylov, r.bytes_per_point, r.bytes_per_dof);
  if (!out) throw std::runtime_error("cannot write " + path);
}

int run(const std::vector<std::string>& words) {
  std::string csv, petsc;
  int steps = 2, points = 0;
  std::vector<int> sizes;
  for (std::size_t k = 0; k < words.size(); ++k) {
    if (words[k].starts_with("--") && k + 1 == words.size()) throw std::runtime_error(words[k] + " needs a value");
    if (words[k] == "--csv")
      csv = words[++k];
    else if (words[k] == "--steps")
      steps = std::stoi(words[++k]);
    else if (words[k] == "--memory")
      points = std::stoi(words[++k]);
    else if (words[k] == "--petsc")
      petsc = words[++k];
    else
      sizes.push_back(std::stoi(words[k]));
  }
  if (sizes.empty()) sizes = {30000, 150000, 500000};
  if (steps < 1) throw std::runtime_error("--steps must be at least 1");

  berm::start_petsc(petsc);
  const berm::Comm comm = berm::Comm::world();
  if (points > 0) {
    report_memory(points, comm);
    return 0;
  }
  if (comm.is_root())
    fmt::print("seconds a linear solve (Newton iteration)\n{:>9}{:>8}{:>9}{:>8}{:>14}{:>8}{:>10}{:>9}{:>9}{:>9}{:>13}{:>11}\n",
               "processes", "dofs", "points", "solves", "connectivity", "laws", "assembly", "linear", "all", "krylov",
               "bytes/point", "bytes/dof");
  std::vector<Row> rows;
  for (const int dofs : sizes) {
    rows.push_back(measure(dofs, steps, petsc, comm));
    if (comm.is_root()) print(rows.back());
  }
  if (!csv.empty() && comm.is_root()) write_csv(csv, rows);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    fmt::print(stderr, "solid: {}\n", error.what());
    return 1;
  }
}
