#include "case/problems.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "base/error.hpp"

namespace berm {
namespace {

/// Optimal string alignment distance: insertions, deletions, substitutions and swaps of neighbours.
int edit_distance(std::string_view a, std::string_view b) {
  const std::size_t n = b.size() + 1;
  std::vector<int> before(n), last(n), now(n);
  std::iota(last.begin(), last.end(), 0);
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = static_cast<int>(i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const int substitution = last[j - 1] + (a[i - 1] != b[j - 1]);
      now[j] = std::min({last[j] + 1, now[j - 1] + 1, substitution});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) now[j] = std::min(now[j], before[j - 2] + 1);
    }
    std::swap(before, last);
    std::swap(last, now);
  }
  return last[b.size()];
}

}  // namespace

void Problems::error(const Place& place, const std::string& text) { errors_.push_back({place, text}); }

void Problems::warn(const Place& place, const std::string& text) { warnings_.push_back({place, text}); }

void Problems::throw_if_any(const std::string& main_file) const {
  if (errors_.empty()) return;
  std::vector<Problem> sorted = errors_;
  std::stable_sort(sorted.begin(), sorted.end(), [&](const Problem& a, const Problem& b) {
    const auto rank = [&](const Place& p) {
      return std::tuple(!p.override.empty(), p.file != main_file, p.file, p.line, p.column);
    };
    return rank(a.place) < rank(b.place);
  });
  std::vector<std::string> lines;
  for (const Problem& problem : sorted) lines.push_back(problem.place.text() + ": " + problem.text);
  throw InputError(fmt::format("{}", fmt::join(lines, "\n")));
}

std::vector<std::string> Problems::warnings() const {
  std::vector<std::string> lines;
  for (const Problem& problem : warnings_) lines.push_back(problem.place.text() + ": " + problem.text);
  return lines;
}

std::string suggestion(std::string_view word, const std::vector<std::string>& valid) {
  const int near = word.size() <= 3 ? 1 : std::max(2, static_cast<int>(word.size()) / 3);
  const std::string* best = nullptr;
  int best_distance = near + 1;
  for (const std::string& candidate : valid) {
    const int distance = edit_distance(word.substr(0, 100), candidate);
    if (distance < best_distance) {
      best = &candidate;
      best_distance = distance;
    }
  }
  if (best) return fmt::format(" (did you mean \"{}\"?)", *best);
  if (valid.empty()) return " (nothing is defined there)";
  return fmt::format(" (valid: {})", fmt::join(valid, ", "));
}

}  // namespace berm
