/// The command line: run | check | schema | report | sweep | version.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "case/read_case.hpp"
#include "comm/comm.hpp"
#include "la/newton.hpp"
#include "mpiexec.hpp"
#include "sim/preflight.hpp"
#include "sim/run.hpp"
#include "sim/world.hpp"

namespace {

constexpr int exit_done = 0, exit_failed = 1, exit_bad_input = 2;

/// Replaces this process by the Python tool `module` with the given arguments. Returns only if Python is missing.
int python(const std::string& module, const std::vector<std::string>& arguments) {
  const char* path = std::getenv("PYTHONPATH");
  const std::string python_path = std::string(BERM_PYTHON_DIR) + (path ? std::string(":") + path : "");
  setenv("PYTHONPATH", python_path.c_str(), 1);
  // Debian's own interpreter has matplotlib and VTK; another one first in the PATH may not.
  const char* chosen = std::getenv("BERM_PYTHON");
  const char* interpreter = chosen ? chosen : "/usr/bin/python3";
  // Python looks for its packages beside the name it is called by.
  std::vector<std::string> words = {interpreter, "-m", module};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  execv(interpreter, argv.data());
  fmt::print(stderr, "berm: cannot start {}: {}\n", interpreter,
             chosen ? "BERM_PYTHON must be the path of a Python interpreter"
                    : "install python3, python3-matplotlib and python3-vtk9");
  return exit_failed;
}

/// Errors are the same on all processes, or else the one that has it ends them all.
int guarded(const std::function<void()>& work) {
  const bool alone = ranks_of_launcher() == 1;
  const auto fail = [&](const std::string& text, int code) {
    if (alone || berm::Comm::world().is_root()) fmt::print(stderr, "{}\n", text);
    return code;
  };
  try {
    work();
    return exit_done;
  } catch (const berm::InputError& error) {
    return fail(error.what(), exit_bad_input);
  } catch (const berm::RunError& error) {
    return fail(fmt::format("berm: {}", error.what()), exit_failed);
  } catch (const std::bad_alloc&) {
    return fail("berm: no memory left: take larger cells or fewer points (`berm check` estimates what a run needs)", exit_failed);
  } catch (const std::exception& error) {
    if (alone) return fail(fmt::format("berm: {}", error.what()), exit_failed);
    fmt::print(stderr, "berm: process {}: {}\n", berm::Comm::world().rank(), error.what());
    berm::Comm::world().abort(exit_failed);
  }
}

/// What is wrong with a case that could be read may have no place: it names the file at least.
void in_case(const std::string& file, const std::function<void()>& work) {
  try {
    work();
  } catch (const berm::InputError& error) {
    const std::string text = error.what();
    if (text.find(file) != std::string::npos) throw;
    throw berm::InputError(fmt::format("{}: {}", file, text));
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"berm: material point method for civil engineering"};
  app.require_subcommand(1);
  std::string file, out, restart, format = "markdown";
  std::vector<std::string> overrides, words;
  int ranks = 1;
  bool quiet = false;

  CLI::App* run = app.add_subcommand("run", "run a case file");
  run->add_option("case", file, "case file (TOML)")->required();
  run->add_option("--out", out, "output folder (default: out/<name of the case>)");
  run->add_option("--set", overrides, "override a key: --set solver.integration=impl_ex")->take_all();
  run->add_option("-n", ranks, "number of processes; the same as mpiexec -n N berm run")->check(CLI::Range(1, 100000));
  run->add_option("--restart", restart, "checkpoint.h5 to go on from, on any number of processes");
  run->add_flag("--quiet", quiet, "only warnings and errors");

  CLI::App* check = app.add_subcommand("check", "build everything, run nothing, say what was found");
  check->add_option("case", file, "case file (TOML)")->required();
  check->add_option("--set", overrides, "override a key")->take_all();

  CLI::App* schema = app.add_subcommand("schema", "print the reference of all case keys");
  schema->add_option("--format", format, "markdown or json")->check(CLI::IsMember({"markdown", "json"}));

  CLI::App* report = app.add_subcommand("report", "draw curves and maps of one or more output folders");
  report->prefix_command();
  CLI::App* sweep = app.add_subcommand("sweep", "run the variants of a sweep file and compare them");
  sweep->prefix_command();
  CLI::App* safety = app.add_subcommand("factor_of_safety", "reduce the strength of a case until it fails");
  safety->prefix_command();
  CLI::App* version = app.add_subcommand("version", "print the version");

  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error) == 0 ? exit_done : exit_bad_input;
  }

  if (version->parsed()) {
    fmt::print("berm {}\n", BERM_VERSION);
    return exit_done;
  }
  if (schema->parsed()) {
    fmt::print("{}\n", format == "json" ? berm::schema_json() : berm::schema_markdown());
    return exit_done;
  }
  if (report->parsed()) return python("berm.report", report->remaining());
  for (const auto& [command, module] : {std::pair{sweep, "berm.sweep"}, {safety, "berm.factor_of_safety"}})
    if (command->parsed()) {
      std::vector<std::string> arguments = command->remaining();
      arguments.insert(arguments.end(), {"--berm", std::filesystem::read_symlink("/proc/self/exe").string()});
      return python(module, arguments);
    }
  if (check->parsed())
    return guarded([&] {
      if (ranks_of_launcher() > 1) berm::start_petsc();
      const berm::Comm comm = berm::Comm::world();
      berm::Case spec = berm::read_case(file, overrides);
      in_case(file, [&] {
        auto world = berm::build_world(std::move(spec), comm);
        berm::refuse_free_bodies(*world);
        const std::string text = berm::describe(*world);
        if (comm.is_root()) fmt::print("{}", text);
      });
    });
  if (ranks > 1 && ranks_of_launcher() == 1) return run_under_mpiexec(ranks, {argv + 1, argv + argc});
  return guarded([&] {
    if (ranks_of_launcher() > 1) berm::start_petsc();  // so that errors of the case are told once
    berm::RunOptions options;
    options.restart = restart;
    options.folder =
        out.empty() ? std::filesystem::path("out") / std::filesystem::path(file).stem() : std::filesystem::path(out);
    options.quiet = quiet;
    // mpiexec gives the processes a terminal of its own, wherever their words go in the end.
    if (ranks_of_launcher() > 1) options.is_interactive = user_sees_terminal();
    berm::Case spec = berm::read_case(file, overrides);
    in_case(file, [&] { berm::run_case(std::move(spec), options); });
  });
}
