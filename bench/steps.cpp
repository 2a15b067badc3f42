/// Takes the steps of a case without output on the way: what a step costs, and where its points go. See
/// bench/README.md.
///
///     steps CASE.toml RESULT.json FRAMES
///
/// The steps have equal length. FRAMES points of time, evenly spaced, get the positions of all material points. Seconds
/// are the processor's, of the steps alone; the phases among them are of the clock on the wall.

#include <fmt/format.h>

#include <ctime>
#include <string>
#include <vector>

#include "case/read_case.hpp"
#include "io/file.hpp"
#include "la/newton.hpp"
#include "sim/implicit_step.hpp"
#include "sim/world.hpp"

namespace {

double processor_seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

std::string listed(const auto& values, auto text) {
  std::string out;
  for (const auto& value : values) out += (out.empty() ? "" : ", ") + text(value);
  return "[" + out + "]";
}

std::string numbers(const auto& values) {
  return listed(values, [](auto v) { return fmt::format("{}", v); });
}

std::string places(const berm::World& world) {
  return listed(world.discretisation->point_positions(),
                [](const berm::Vec3& x) { return fmt::format("[{}, {}]", x.x(), x.y()); });
}

int run(const std::string& case_file, const std::string& result_file, int frames) {
  auto world = berm::build_world(berm::read_case(case_file));
  const berm::Stage& stage = world->present_stage();
  berm::start_petsc(stage.solver.petsc);
  berm::ImplicitStep step(*world);
  const int count = stage.steps.count;
  const double dt = world->spec.duration() / count;
  const std::string start = places(*world);
  std::vector<double> seconds;
  std::vector<int> iterations;
  std::vector<std::string> taken;
  for (int k = 1; k <= count; ++k) {
    const double before = processor_seconds();
    const berm::StepResult result = step.attempt(dt, berm::Integration::implicit);
    if (!result.converged) throw std::runtime_error(fmt::format("step {} does not converge: {}", k, result.reason));
    step.accept();
    seconds.push_back(processor_seconds() - before);
    iterations.push_back(result.iterations);
    if (k * frames / count > (k - 1) * frames / count)
      taken.push_back(fmt::format(R"({{"time": {}, "position": {}}})", k * dt, places(*world)));
  }
  const berm::StepTimes t = step.times();
  berm::replace_file(
      result_file,
      fmt::format(
          "{{\"dofs\": {}, \"points\": {}, \"solver\": \"{}\", \"seconds\": {}, \"iterations\": {},\n \"phases\": "
          "{{\"connectivity\": {}, \"laws\": {}, \"assembly\": {}, \"linear\": {}}},\n \"start\": {},\n \"frames\": "
          "{}}}\n",
          step.unknowns(), world->n_points(), step.solver_choice(), numbers(seconds), numbers(iterations),
          t.connectivity, t.response, t.assembly, t.linear, start,
          listed(taken, [](const std::string& frame) { return frame; })));
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    if (argc != 4) throw std::runtime_error("usage: steps CASE.toml RESULT.json FRAMES");
    return run(argv[1], argv[2], std::stoi(argv[3]));
  } catch (const std::exception& error) {
    fmt::print(stderr, "steps: {}\n", error.what());
    return 1;
  }
}
