#pragma once
/// What several checks find wrong with the input, so that the user is told all of it at once.

#include <functional>
#include <string>

#include "base/error.hpp"

namespace berm {

class Findings {
public:
  /// Does the check; what it throws as InputError is kept for later.
  void look(const std::function<void()>& check) {
    try {
      check();
    } catch (const InputError& error) {
      if (!text_.empty()) text_ += '\n';
      text_ += error.what();
    }
  }
  bool any() const { return !text_.empty(); }
  /// One InputError with a line for each finding.
  void throw_if_any() const {
    if (any()) throw InputError(text_);
  }

private:
  std::string text_;
};

}  // namespace berm
