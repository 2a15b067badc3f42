/// The command line: run | check | schema | report | sweep | factor_of_safety | completion | version.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.hpp"
#include "base/shell_word.hpp"
#include "build.hpp"
#include "case/problems.hpp"
#include "case/read_case.hpp"
#include "comm/comm.hpp"
#include "completion.hpp"
#include "la/newton.hpp"
#include "mpiexec.hpp"
#include "python.hpp"
#include "sim/preflight.hpp"
#include "sim/run.hpp"
#include "sim/world.hpp"
#include "streams.hpp"
#include "temporary_folder.hpp"

namespace {

constexpr int exit_done = 0, exit_failed = 1, exit_bad_input = 2;
/// In the place of a case file: standard input, and what it is called then.
constexpr const char *from_input = "-", *input_name = "stdin";

/// What the user typed.
struct Words {
  std::string file, out, restart, format = "markdown", shell;
  std::vector<std::string> overrides;
  int ranks = 1;
  bool quiet = false, force = false, oversubscribe = false, petsc_files = false;
};

/// The tools in Python, by subcommand, and what they do.
const std::map<std::string, const char*> tools = {
    {"report", "draw curves and maps of one or more output folders"},
    {"sweep", "run the variants of a sweep file and compare them"},
    {"factor_of_safety", "reduce the strength of a case until it fails"}};

/// An empty word is a variable of a script that was not set: the run would be another one than was meant.
const CLI::Validator is_given([](const std::string& word) { return word.empty() ? "is empty: a variable that is not set?" : ""; }, "", "");

void add_options_of_case(CLI::App* command, Words& w) {
  command->add_option("case", w.file, "case file (TOML); - reads it from standard input")->required();
  command->add_option("--set", w.overrides, "override a key: --set solver.integration=impl_ex")->take_all()->allow_extra_args(false)->check(is_given)->type_name("KEY=VALUE");
  command->add_flag("--allow-petsc-files", w.petsc_files, "let solver.petsc write files and set any option of PETSc");
}

/// What is wrong with a command line, and where to look.
std::string words_of(const CLI::App* app, const CLI::Error& error) {
  const std::string text = error.what();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && text.find('=') != std::string::npos)
    return fmt::format("berm: {}: every override has its own --set\n", text);
  const std::vector<CLI::App*> given = app->get_subcommands();
  return fmt::format("berm: {}; see berm {}--help\n", text, given.empty() ? "" : given.front()->get_name() + " ");
}

void add_commands(CLI::App& app, Words& w) {
  app.require_subcommand(1);
  app.failure_message(words_of);
  app.set_version_flag("--version", "berm " BERM_VERSION, "print the version");

  CLI::App* run = app.add_subcommand("run", "run a case file");
  add_options_of_case(run, w);
  run->add_option("--out", w.out, "output folder (default: out/<name of the case>)")->check(is_given);
  run->add_flag("--force", w.force, "replace the results of a run that came to its end");
  run->add_option("-n", w.ranks, "number of processes; the same as mpiexec -n N berm run")->check(CLI::Range(1, 1000000));
  run->add_flag("--oversubscribe", w.oversubscribe, "more processes than cores");
  run->add_option("--restart", w.restart, "checkpoint.h5 to go on from, on any number of processes")->check(is_given);
  run->add_flag("--quiet", w.quiet, "only warnings and errors");

  add_options_of_case(app.add_subcommand("check", "build everything, run nothing, say what was found"), w);

  CLI::App* schema = app.add_subcommand("schema", "print the reference of all case keys");
  schema->add_option("--format", w.format, "markdown or json")->check(CLI::IsMember({"markdown", "json"}));

  for (const auto& [name, what] : tools) {
    CLI::App* command = app.add_subcommand(name, what);
    command->prefix_command();
    command->set_help_flag();  // --help is the tool's
  }
  CLI::App* completion = app.add_subcommand("completion", "print a script that completes the command line in a shell");
  completion->add_option("shell", w.shell, "bash")->required()->check(CLI::IsMember({"bash"}));
  app.add_subcommand("version", "print the version and the commit");
}

std::vector<std::string> names_of_commands(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) names.push_back(command->get_name());
  return names;
}

std::string completion_script(const CLI::App& app) {
  std::vector<CommandWords> commands;
  for (const std::string& name : names_of_commands(app)) {
    CommandWords words{name, {}};
    if (!tools.contains(name))
      for (const CLI::Option* option : app.get_subcommand(name)->get_options())
        for (const auto& [list, dashes] : {std::pair{option->get_lnames(), "--"}, {option->get_snames(), "-"}})
          for (const std::string& o : list) words.options.push_back(dashes + o);
    commands.push_back(words);
  }
  return bash_completion(commands);
}

/// A first word that is no subcommand, which CLI11 would complain of without a remedy; 0: there is none.
int refuse_command(const CLI::App& app, int argc, char** argv) {
  const std::vector<std::string> names = names_of_commands(app);
  if (argc < 2 || argv[1][0] == '-' || std::find(names.begin(), names.end(), argv[1]) != names.end()) return 0;
  say_error(fmt::format("berm: \"{}\" is no command{}; see berm --help", argv[1], berm::suggestion(argv[1], names)));
  return exit_bad_input;
}

/// Errors are the same on all processes, or else the one that has it ends them all.
int guarded(const std::function<int()>& work) {
  const auto alone = [] { return berm::Comm::world().size() == 1; };  // not before the work has begun
  const auto fail = [&](const std::string& text, int code) {
    if (berm::Comm::world().is_root()) say_error(text);
    return code;
  };
  try {
    return work();
  } catch (const berm::InputError& error) {
    return fail(error.what(), exit_bad_input);
  } catch (const berm::RunError& error) {
    return fail(fmt::format("berm: {}", error.what()), exit_failed);
  } catch (const std::exception& error) {
    // The others know nothing of it.
    const bool memory = dynamic_cast<const std::bad_alloc*>(&error);
    const char* text = memory ? "no memory left: take larger cells or fewer points (`berm check` estimates what a run needs)" : error.what();
    if (alone()) return fail(fmt::format("berm: {}", text), exit_failed);
    say_error(fmt::format("berm: process {}: {}", berm::Comm::world().rank(), text));
    berm::Comm::world().abort(exit_failed);
  }
}

/// mpiexec gives standard input to the first process alone.
berm::Case read_case(const Words& w) {
  berm::ReadOptions options;
  options.allow_petsc_files = w.petsc_files;
  if (w.file != from_input) return berm::read_case(w.file, w.overrides, options);
  const berm::Comm comm = berm::Comm::world();
  std::string text;
  comm.agree([&] {
    if (comm.is_root()) text = read_standard_input();
  });
  options.text = comm.broadcast(text);
  return berm::read_case(input_name, w.overrides, options);
}

int check(const Words& w) {
  if (ranks_of_launcher() > 1) berm::start_petsc();  // so that errors of the case are told once
  const berm::Comm comm = berm::Comm::world();
  auto world = berm::build_world(read_case(w), comm);
  berm::refuse_free_bodies(*world);
  std::string text = berm::describe(*world);
  for (const std::string& warning : world->warnings) text += "  warning: " + warning + "\n";
  return comm.is_root() ? print_out(text) : exit_done;
}

std::filesystem::path output_folder(const Words& w) {
  if (!w.out.empty()) return w.out;
  const std::filesystem::path name = std::filesystem::path(w.file).stem();
  if (w.file == from_input) return std::filesystem::path("out") / input_name;
  return std::filesystem::path("out") / (name == "." || name == ".." ? "case" : name);  // a file "...toml"
}

int run(const Words& w, const std::vector<std::string>& arguments) {
  const bool first = ranks_of_launcher() == 1;
  if (first) {
    check_processes(w.ranks, w.oversubscribe);
    look_for_temporary_folder(w.ranks, output_folder(w));
  }
  if (w.ranks > 1 && first)
    return run_under_mpiexec(w.ranks, arguments, w.file == from_input ? read_standard_input() : "");
  if (!first || w.file != from_input) berm::catch_signals();  // a terminal that is read may be left by Ctrl-C
  if (!first) {
    berm::start_petsc();
    if (berm::Comm::world().is_root()) say_begun();
  }
  berm::RunOptions options;
  options.listens = say_ready;
  options.restart = w.restart;
  // A named pipe would be waited for.
  if (std::error_code none; std::filesystem::exists(w.restart, none) && !std::filesystem::is_regular_file(w.restart, none))
    throw berm::InputError(w.restart + ": is not a file");
  options.folder = output_folder(w);
  options.quiet = w.quiet;
  options.replace_finished = w.force;
  options.origin = {BERM_VERSION, build_commit, "", "berm"};
  for (const std::string& word : arguments) options.origin.command += " " + berm::shell_word(word);
  // mpiexec gives the processes a terminal of its own, wherever their words go in the end.
  if (!first) options.is_interactive = user_sees_terminal();
  berm::run_case(read_case(w), options);
  return exit_done;
}

/// PETSc and MPI cannot begin where there is no folder.
void check_folder() {
  std::error_code error;
  static_cast<void>(std::filesystem::current_path(error));
  if (error) throw berm::InputError("berm: the current folder cannot be read (" + error.message() + "): go to one that exists");
}

int run_tool(const std::string& name, std::vector<std::string> arguments) {
  const bool given = std::any_of(arguments.begin(), arguments.end(), [](const std::string& word) { return word == "--berm" || word.starts_with("--berm="); });
  if (name != "report" && !given) arguments.insert(arguments.end(), {"--berm", own_path()});
  return run_python(name, arguments);
}

}  // namespace

int main(int argc, char** argv) {
  prepare_streams();
  CLI::App app{"berm: material point method for civil engineering"};
  Words w;
  add_commands(app, w);
  if (const int code = refuse_command(app, argc, argv); code != exit_done) return code;
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    std::ostringstream out;
    if (app.exit(error, out, std::cerr) != 0) return exit_bad_input;
    return print_out(out.str());
  }
  const CLI::App* command = app.get_subcommands().front();
  const std::string name = command->get_name();
  if (tools.contains(name)) return run_tool(name, command->remaining());
  return guarded([&] {
    if (name == "check" || name == "run") check_folder();
    if (name == "check") return check(w);
    if (name == "run") return run(w, {argv + 1, argv + argc});
    if (name == "schema") return print_out((w.format == "json" ? berm::schema_json() : berm::schema_markdown()) + "\n");
    if (name == "completion") return print_out(completion_script(app));
    return print_out(fmt::format("berm {}{}\n", BERM_VERSION, *build_commit ? fmt::format(" (commit {})", build_commit) : ""));
  });
}
