#pragma once
/// Descriptors of the numbers that a law (or any other plain struct) takes from the case file.
/// One table parses the key, checks its range, and prints its line of the manual.

#include <limits>
#include <optional>
#include <string>
#include <vector>

namespace berm {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Physical dimension of a value; the case reader accepts strings such as "35.5 GPa" for it.
enum class Unit {
  none,
  length,
  stress,
  density,
  energy_per_area,
  velocity,
  acceleration,
  angle,
  force,
  stress_per_length,
  time,
  minutes,  ///< a time too, whose bare number counts minutes
  rate,
  viscosity,
  area
};

/// Admissible interval of a value; open ends exclude the bound itself.
struct Range {
  double min = -infinity;
  double max = infinity;
  bool min_open = false;
  bool max_open = false;
};

inline Range positive() { return {0.0, infinity, true, false}; }
inline Range non_negative() { return {0.0, infinity, false, false}; }

/// One number of the struct T: its key in the case file, where it is stored, and what the manual says.
template <class T>
struct Parameter {
  std::string key;
  double T::*member;
  Unit unit;
  Range range;
  std::optional<double> default_value;  ///< no value: the key is required
  std::string doc;
};

}  // namespace berm
