#pragma once
/// Numbers with units, as case files write them.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "base/parameter.hpp"

namespace berm {

/// "length", "stress", ...
std::string_view unit_name(Unit unit);
/// What a bare number in a case file is measured in: "m", "Pa", ..., "deg" for angles, "" for plain numbers.
std::string_view file_unit(Unit unit);
/// Stored value of one file unit: 1, or pi/180 for angles.
double file_factor(Unit unit);
/// Units that strings may carry, e.g. "Pa, kPa, MPa, GPa".
std::string unit_list(Unit unit);

struct Parsed {
  double value = 0.0;  ///< SI, radians
  std::string error;   ///< empty if all is well
};
/// Reads "35.5 GPa" as a quantity of that dimension.
Parsed parse_quantity(std::string_view text, Unit unit);

/// What a unit by itself means, e.g. "kN". "min", "s" and "h" are times.
struct UnitMeaning {
  Unit unit;
  double factor;  ///< SI value of one
};
std::optional<UnitMeaning> find_unit(std::string_view name);
/// "N, kN, MN, Pa, ..." of several dimensions.
std::string unit_list(const std::vector<Unit>& units);

/// Remedy for a value that is legal and yet looks like a slip of unit ("did you mean ...?"), or "".
std::string unit_doubt(std::string_view key, Unit unit, double value);

/// "> 0", "0 ... 0.5", ... in file units; "" if anything goes.
std::string range_text(const Range& range, Unit unit);
bool in_range(const Range& range, double value);

}  // namespace berm
