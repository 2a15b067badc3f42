#include "case/petsc_options.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "case/problems.hpp"

namespace berm {
namespace {

enum class Value { none, word, whole, real };

/// What follows an option: nothing, one of the words, or a number in the range.
struct Option {
  std::string name;
  Value value = Value::none;
  double low = 0.0, high = 0.0;
  std::vector<std::string> words = {};

  Option(std::string n) : name(std::move(n)) {}
  Option(std::string n, std::vector<std::string> w) : name(std::move(n)), value(Value::word), words(std::move(w)) {}
  Option(std::string n, int from, int to) : name(std::move(n)), value(Value::whole), low(from), high(to) {}
  Option(std::string n, double from, double to) : name(std::move(n)), value(Value::real), low(from), high(to) {}
};

/// Those for which PETSc's and MUMPS's manuals give a use in the systems of this program. Of the thousands of others some write files, load
/// libraries, run programs or wait, and a wrong value of some ends the process.
const std::vector<Option>& options_of_solvers() {
  static const std::vector<Option> all = {
      Option("ksp_view"),
      Option("ksp_monitor"),
      Option("ksp_monitor_true_residual"),
      Option("ksp_monitor_singular_value"),
      Option("ksp_converged_reason"),
      Option("snes_view"),
      Option("snes_monitor"),
      Option("snes_converged_reason"),
      {"ksp_type", {"cg", "fcg", "gmres", "fgmres", "lgmres", "gcr", "bcgs", "tfqmr", "minres", "richardson", "chebyshev"}},
      {"ksp_rtol", 1e-15, 0.1},
      {"ksp_atol", 0.0, 1e30},
      {"ksp_max_it", 1, 1000000},
      {"ksp_gmres_restart", 1, 1000},
      {"ksp_norm_type", {"preconditioned", "unpreconditioned", "natural"}},
      {"ksp_pc_side", {"left", "right"}},
      {"ksp_richardson_scale", 1e-6, 10.0},
      {"ksp_chebyshev_esteig_steps", 1, 1000},
      {"pc_type", {"none", "jacobi", "pbjacobi", "sor", "bjacobi", "asm", "ilu", "icc", "lu", "cholesky", "gamg", "hypre"}},
      {"pc_sor_its", 1, 100},
      {"pc_sor_omega", 0.01, 1.99},
      {"pc_asm_overlap", 0, 10},
      {"pc_factor_levels", 0, 10},
      {"pc_factor_mat_solver_type", {"mumps", "petsc"}},
      {"pc_factor_mat_ordering_type", {"natural", "nd", "1wd", "rcm", "qmd"}},
      {"pc_factor_shift_type", {"none", "nonzero", "positive_definite", "inblocks"}},
      {"pc_factor_shift_amount", 0.0, 1e30},
      {"pc_gamg_threshold", -1.0, 1.0},
      {"pc_gamg_threshold_scale", 0.0, 1.0},
      {"pc_gamg_agg_nsmooths", 0, 10},
      {"pc_gamg_square_graph", 0, 10},
      {"pc_gamg_coarse_eq_limit", 1, 100000},
      {"pc_gamg_process_eq_limit", 1, 1000000},
      {"pc_gamg_reuse_interpolation", {"true", "false"}},
      {"pc_mg_cycle_type", {"v", "w"}},
      {"pc_hypre_type", {"boomeramg"}},
      {"pc_hypre_boomeramg_strong_threshold", 0.0, 1.0},
      {"pc_hypre_boomeramg_max_iter", 1, 100},
      {"pc_hypre_boomeramg_nodal_coarsen", 0, 6},
      {"pc_hypre_boomeramg_agg_nl", 0, 20},
      {"pc_hypre_boomeramg_coarsen_type", {"CLJP", "Ruge-Stueben", "Falgout", "PMIS", "HMIS"}},
      {"pc_hypre_boomeramg_interp_type", {"classical", "direct", "multipass", "ext+i", "standard"}},
      {"pc_hypre_boomeramg_relax_type_all", {"Jacobi", "SOR/Jacobi", "symmetric-SOR/Jacobi", "l1scaled-SOR/Jacobi"}},
      {"mat_mumps_icntl_4", 0, 3},
      {"mat_mumps_icntl_6", 0, 7},
      {"mat_mumps_icntl_7", 0, 7},
      {"mat_mumps_icntl_8", 0, 77},
      {"mat_mumps_icntl_10", 0, 10},
      {"mat_mumps_icntl_13", 0, 1},
      {"mat_mumps_icntl_14", 5, 1600},
      {"mat_mumps_icntl_24", 0, 1},
      {"mat_mumps_icntl_28", 0, 2},
      {"mat_mumps_icntl_29", 0, 2},
      {"mat_mumps_icntl_35", 0, 2},
      {"mat_mumps_cntl_1", 0.0, 1.0},
      {"mat_mumps_cntl_7", 0.0, 0.1},
      {"matptap_via", {"scalable", "nonscalable", "allatonce", "allatonce_merged", "backend"}},
  };
  return all;
}

/// Solvers inside of solvers; "newton_" and "fallback_" are berm's own (src/la).
constexpr std::array<std::string_view, 7> prefixes = {"newton_", "fallback_", "mg_levels_", "mg_coarse_", "sub_", "redundant_", "esteig_"};

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

std::string without_prefixes(std::string name) {
  for (bool cut = true; cut;) {
    cut = false;
    for (const std::string_view prefix : prefixes)
      if (name.starts_with(prefix)) name.erase(0, prefix.size()), cut = true;
  }
  return name;
}

const Option* find_option(const std::string& word) {
  const std::string name = without_prefixes(lower(word).substr(word.find_first_not_of('-')));
  const auto& all = options_of_solvers();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Option& o) { return o.name == name; });
  return found == all.end() ? nullptr : &*found;
}

std::string values_of(const Option& o) {
  switch (o.value) {
    case Value::none:
      return "no value";
    case Value::word:
      return fmt::format("one of {}", fmt::join(o.words, ", "));
    case Value::whole:
      return fmt::format("a whole number from {:.0f} to {:.0f}", o.low, o.high);
    default:
      return fmt::format("a number from {:g} to {:g}", o.low, o.high);
  }
}

template <class T>
bool is_number(const Option& o, const std::string& word) {
  T value = 0;
  const auto end = std::from_chars(word.data(), word.data() + word.size(), value);
  return end.ec == std::errc() && end.ptr == word.data() + word.size() && o.low <= value && value <= o.high;
}

bool has_value(const Option& o, const std::vector<std::string>& values) {
  if (values.size() != (o.value == Value::none ? 0 : 1)) return false;
  if (o.value == Value::whole) return is_number<int>(o, values[0]);
  if (o.value == Value::real) return is_number<double>(o, values[0]);
  return o.value == Value::none || std::find(o.words.begin(), o.words.end(), values[0]) != o.words.end();
}

std::string problem_of(const std::string& name, const std::vector<std::string>& values) {
  const Option* option = find_option(name);
  if (!option) {
    std::vector<std::string> names;
    for (const Option& o : options_of_solvers()) names.push_back("-" + o.name);
    return fmt::format("\"{}\" is none of the options that a case may set{}{}", name, suggestion(name, names), how);
  }
  if (has_value(*option, values)) return "";
  return fmt::format("\"{}{}{}\": it takes {}{}", name, values.empty() ? "" : " ", fmt::join(values, " "), values_of(*option), how);
}

}  // namespace

std::string problem_of_petsc(const std::string& options, bool files) {
  // PETSc takes quotes away from words, and what follows #.
  if (!files && options.find_first_of("\"#") != options.npos) return fmt::format("quotes and # hide options from this check{}", how);
  std::vector<std::pair<std::string, std::vector<std::string>>> found;
  std::istringstream words(options);
  for (std::string word; words >> word;) {
    if (is_name(word))
      found.push_back({word, {}});
    else if (found.empty())
      return fmt::format("\"{}\" is a value without an option before it (options begin with -)", word);
    else
      found.back().second.push_back(word);
  }
  for (const auto& [name, values] : found)
    if (const std::string problem = files ? "" : problem_of(name, values); !problem.empty()) return problem;
  return "";
}

}  // namespace berm
