/// The command line: run | check | schema | report | sweep | version.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "case/read_case.hpp"
#include "la/newton.hpp"
#include "sim/run.hpp"
#include "sim/world.hpp"

namespace {

constexpr int exit_done = 0, exit_failed = 1, exit_bad_input = 2;

/// Replaces this process by the Python tool `module` with the given arguments. Returns only if Python is missing.
int python(const std::string& module, const std::vector<std::string>& arguments) {
  const char* path = std::getenv("PYTHONPATH");
  const std::string python_path = std::string(BERM_PYTHON_DIR) + (path ? std::string(":") + path : "");
  setenv("PYTHONPATH", python_path.c_str(), 1);
  std::vector<std::string> words = {"python3", "-m", module};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  // Debian's own interpreter has matplotlib and VTK; another one first in the PATH may not.
  execv("/usr/bin/python3", argv.data());
  fmt::print(stderr, "berm: cannot start /usr/bin/python3: install python3, python3-matplotlib and python3-vtk9\n");
  return exit_failed;
}

int guarded(const std::function<void()>& work) {
  try {
    work();
    return exit_done;
  } catch (const berm::InputError& error) {
    fmt::print(stderr, "{}\n", error.what());
    return exit_bad_input;
  } catch (const std::exception& error) {
    fmt::print(stderr, "berm: {}\n", error.what());
    return exit_failed;
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"berm: material point method for civil engineering"};
  app.require_subcommand(1);
  std::string file, out, format = "markdown";
  std::vector<std::string> overrides, words;
  int ranks = 1;
  bool quiet = false;

  CLI::App* run = app.add_subcommand("run", "run a case file");
  run->add_option("case", file, "case file (TOML)")->required();
  run->add_option("--out", out, "output folder (default: out/<name of the case>)");
  run->add_option("--set", overrides, "override a key: --set solver.integration=impl_ex")->take_all();
  run->add_option("-n", ranks, "number of processes (this version: 1)")->check([](const std::string& n) {
    return n == "1" ? std::string() : "this version runs on one process: leave -n out, or give -n 1";
  });
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
  if (sweep->parsed()) {
    std::vector<std::string> arguments = sweep->remaining();
    arguments.insert(arguments.end(), {"--berm", std::filesystem::read_symlink("/proc/self/exe").string()});
    return python("berm.sweep", arguments);
  }
  if (check->parsed())
    return guarded([&] {
      auto world = berm::build_world(berm::read_case(file, overrides));
      fmt::print("{}", berm::describe(*world));
    });
  return guarded([&] {
    berm::RunOptions options;
    options.folder =
        out.empty() ? std::filesystem::path("out") / std::filesystem::path(file).stem() : std::filesystem::path(out);
    options.quiet = quiet;
    berm::run_case(berm::read_case(file, overrides), options);
  });
}
