#pragma once
/// The list of laws. One line here and the case reader, the manual, the solvers and the law tests know the law.

#include <variant>

#include "law/linear_elastic.hpp"
#include "law/simo_ju.hpp"

namespace berm {

using AnyLaw = std::variant<LinearElastic, SimoJu>;

}  // namespace berm
