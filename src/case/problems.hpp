#pragma once
/// Everything wrong with a case, collected so that the user sees all of it at once.

#include <string>
#include <string_view>
#include <vector>

#include "case/node.hpp"

namespace berm {

class Problems {
public:
  void error(const Place& place, const std::string& text);
  void warn(const Place& place, const std::string& text);
  bool empty() const { return errors_.empty(); }
  std::size_t count() const { return errors_.size(); }

  /// Throws one InputError with a line per error (ordered: the case file, its bases, overrides), if there is any.
  void throw_if_any(const std::string& main_file) const;
  std::vector<std::string> warnings() const;

private:
  struct Problem {
    Place place;
    std::string text;
  };
  std::vector<Problem> errors_, warnings_;
};

/// ` (did you mean "x"?)`, or the list of what is valid if nothing is near.
std::string suggestion(std::string_view word, const std::vector<std::string>& valid);

}  // namespace berm
