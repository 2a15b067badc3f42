#pragma once
/// Where in the case file something stands that a check beyond the reader's found wrong.

#include <functional>
#include <string>

#include "case/case.hpp"

namespace berm {

/// Every line that names a table ([pin.left], body "dam") begins with the place of the first one, "dam.toml:14:1: ..."; others
/// with the file of the case unless they begin with one.
std::string with_places(const Case& c, const std::string& text);

/// Does the work; an InputError from it goes on with places.
void tell_places(const Case& c, const std::function<void()>& work);

}  // namespace berm
