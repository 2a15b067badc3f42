#pragma once
/// Reference curves are read before a run, so that its report does not find out at the end that they cannot be drawn.
/// The report reads them by the same rules (python/berm/results.py).

#include <string>

#include "base/reference_curve.hpp"

namespace berm {

/// What is wrong with the file, "FILE:LINE: what and what to do", or "".
std::string reference_fault(const ReferenceCurve& curve);

}  // namespace berm
