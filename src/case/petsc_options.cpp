#include "case/petsc_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <sstream>
#include <string_view>

namespace berm {
namespace {

/// Of solvers and of the solvers inside them. "newton_" and "fallback_" are berm's own (src/la).
constexpr std::array prefixes = {"ksp_", "pc_",         "mat_",       "snes_",      "mg_",       "sub_",
                                 "esteig_", "fieldsplit_", "redundant_", "telescope_", "fallback_", "newton_"};
/// Parts of names whose value is a file, a folder or a program.
constexpr std::array writing_names = {"file", "dump", "tmpdir", "ooc_", "python", "shell", "saws", "socket", "draw", "icntl_22"};
/// Kinds of viewer that need no ":FILE" to write one, or to open a window or a connection.
constexpr std::array writing_values = {"binary", "draw", "socket", "matlab", "hdf5", "glvis", "vtk", "saws", "python", "string"};

constexpr std::size_t most_digits_of_blocks = 3;

constexpr const char* how = "; berm run --allow-petsc-files lets it";

/// As PETSc tells them from values: -1 is none.
bool is_name(std::string_view word) {
  const std::size_t dashes = word.starts_with("--") ? 2 : 1;
  return word.starts_with('-') && word.size() > dashes && std::isalpha(static_cast<unsigned char>(word[dashes]));
}

std::string lower(std::string_view word) {
  std::string out(word);
  std::transform(out.begin(), out.end(), out.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return out;
}

std::string problem_of_name(const std::string& word) {
  const std::string name = lower(word).substr(word.find_first_not_of('-'));
  if (std::none_of(prefixes.begin(), prefixes.end(), [&](const char* p) { return name.starts_with(p); }))
    return fmt::format("\"{}\" is no option of a solver (those begin with -{}){}", word, fmt::join(prefixes, ", -"), how);
  if (std::any_of(writing_names.begin(), writing_names.end(), [&](const char* p) { return name.find(p) != name.npos; }))
    return fmt::format("\"{}\" may write files or run programs{}", word, how);
  if (name.ends_with("pc_mg_levels")) return fmt::format("\"{}\": the levels of -pc_type mg are none of berm's; -pc_type gamg makes its own", word);
  return "";
}

/// A viewer is KIND:FILE:FORMAT; ascii, or none, without a file is the terminal.
std::string problem_of_value(const std::string& name, const std::string& word) {
  const std::string value = lower(word), kind = value.substr(0, value.find(':'));
  const bool file = kind.size() + 1 < value.size() && value[kind.size() + 1] != ':';
  if (file || value.find_first_of("/\\") != value.npos ||
      std::find(writing_values.begin(), writing_values.end(), kind) != writing_values.end())
    return fmt::format("\"{} {}\" may write a file{}", name, word, how);
  if (lower(name).ends_with("_blocks") && word.size() > most_digits_of_blocks)
    return fmt::format("\"{} {}\": PETSc makes a solver of every block: take fewer than 1000{}", name, word, how);
  return "";
}

}  // namespace

std::string problem_of_petsc(const std::string& options, bool files) {
  // PETSc takes quotes away from words, and what follows #.
  if (!files && options.find_first_of("\"#") != options.npos) return fmt::format("quotes and # hide options from this check{}", how);
  std::istringstream words(options);
  std::string word, name, problem;
  while (problem.empty() && words >> word) {
    if (is_name(word)) {
      name = word;
      if (!files) problem = problem_of_name(word);
    } else if (name.empty()) {
      problem = fmt::format("\"{}\" is a value without an option before it (options begin with -)", word);
    } else if (!files) {
      problem = problem_of_value(name, word);
    }
  }
  return problem;
}

}  // namespace berm
