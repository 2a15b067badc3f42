#include "case/units.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <numbers>

namespace berm {
namespace {

constexpr double degree = std::numbers::pi / 180.0;

struct Name {
  Unit unit;
  std::string_view text;
  double factor;  ///< SI value of one
};

constexpr std::array names = {
    Name{Unit::length, "m", 1.0},
    Name{Unit::length, "km", 1e3},
    Name{Unit::length, "dm", 1e-1},
    Name{Unit::length, "cm", 1e-2},
    Name{Unit::length, "mm", 1e-3},
    Name{Unit::length, "um", 1e-6},
    Name{Unit::stress, "Pa", 1.0},
    Name{Unit::stress, "kPa", 1e3},
    Name{Unit::stress, "MPa", 1e6},
    Name{Unit::stress, "GPa", 1e9},
    Name{Unit::stress, "bar", 1e5},
    Name{Unit::stress, "N/m2", 1.0},
    Name{Unit::stress, "kN/m2", 1e3},
    Name{Unit::stress, "MN/m2", 1e6},
    Name{Unit::stress, "N/mm2", 1e6},
    Name{Unit::stress, "kN/mm2", 1e9},
    Name{Unit::density, "kg/m3", 1.0},
    Name{Unit::density, "t/m3", 1e3},
    Name{Unit::density, "g/cm3", 1e3},
    Name{Unit::energy_per_area, "N/m", 1.0},
    Name{Unit::energy_per_area, "J/m2", 1.0},
    Name{Unit::energy_per_area, "kN/m", 1e3},
    Name{Unit::energy_per_area, "kJ/m2", 1e3},
    Name{Unit::energy_per_area, "N/mm", 1e3},
    Name{Unit::velocity, "m/s", 1.0},
    Name{Unit::velocity, "cm/s", 1e-2},
    Name{Unit::velocity, "mm/s", 1e-3},
    Name{Unit::velocity, "km/h", 1.0 / 3.6},
    Name{Unit::acceleration, "m/s2", 1.0},
    Name{Unit::acceleration, "cm/s2", 1e-2},
    Name{Unit::acceleration, "mm/s2", 1e-3},
    Name{Unit::angle, "deg", degree},
    Name{Unit::angle, "rad", 1.0},
    Name{Unit::angle, "°", degree},
    Name{Unit::force, "N", 1.0},
    Name{Unit::force, "kN", 1e3},
    Name{Unit::force, "MN", 1e6},
    Name{Unit::time, "s", 1.0},
    Name{Unit::time, "ms", 1e-3},
    Name{Unit::time, "min", 60.0},
    Name{Unit::time, "h", 3600.0},
    Name{Unit::minutes, "min", 1.0},
    Name{Unit::minutes, "s", 1.0 / 60.0},
    Name{Unit::minutes, "h", 60.0},
    Name{Unit::rate, "1/s", 1.0},
    Name{Unit::rate, "1/min", 1.0 / 60.0},
    Name{Unit::rate, "1/h", 1.0 / 3600.0},
    Name{Unit::stress_per_length, "Pa/m", 1.0},
    Name{Unit::stress_per_length, "kPa/m", 1e3},
    Name{Unit::stress_per_length, "MPa/m", 1e6},
    Name{Unit::stress_per_length, "GPa/m", 1e9},
    Name{Unit::stress_per_length, "N/m3", 1.0},
    Name{Unit::stress_per_length, "kN/m3", 1e3},
    Name{Unit::stress_per_length, "MN/m3", 1e6},
    Name{Unit::stress_per_length, "N/mm3", 1e9},
    Name{Unit::viscosity, "Pa s", 1.0},
    Name{Unit::viscosity, "mPa s", 1e-3},
    Name{Unit::viscosity, "kPa s", 1e3},
    Name{Unit::viscosity, "N s/m2", 1.0},
    Name{Unit::viscosity, "kg/(m s)", 1.0},
    Name{Unit::area, "m2", 1.0},
    Name{Unit::area, "dm2", 1e-2},
    Name{Unit::area, "cm2", 1e-4},
    Name{Unit::area, "mm2", 1e-6},
};

void replace_all(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = text.find(from); at != std::string::npos; at = text.find(from, at + to.size())) {
    text.replace(at, from.size(), to);
  }
}

/// "kg/m^3", "kg/m³" and "kg / m3" are all "kg/m3".
std::string plain_unit(std::string_view text) {
  std::string unit(text);
  replace_all(unit, " ", "");
  replace_all(unit, "^", "");
  replace_all(unit, "²", "2");
  replace_all(unit, "³", "3");
  replace_all(unit, "µ", "u");  // micro sign
  replace_all(unit, "μ", "u");  // Greek mu
  return unit;
}

std::string with_article(Unit unit) {
  const std::string_view name = unit_name(unit);
  return fmt::format("{} {}", name.find_first_of("ae") == 0 ? "an" : "a", name);
}

std::string example(Unit unit) {
  if (unit == Unit::none) return "a plain number is needed";
  return fmt::format("{} is needed, such as \"1 {}\"", with_article(unit), file_unit(unit));
}

Parsed failure(std::string text) { return {0.0, std::move(text)}; }

}  // namespace

std::string_view unit_name(Unit unit) {
  switch (unit) {
    case Unit::none:
      return "plain number";
    case Unit::length:
      return "length";
    case Unit::stress:
      return "stress";
    case Unit::density:
      return "density";
    case Unit::energy_per_area:
      return "energy per area";
    case Unit::velocity:
      return "velocity";
    case Unit::acceleration:
      return "acceleration";
    case Unit::angle:
      return "angle";
    case Unit::force:
      return "force";
    case Unit::stress_per_length:
      return "stress per length";
    case Unit::time:
      return "time";
    case Unit::minutes:
      return "duration";
    case Unit::rate:
      return "rate";
    case Unit::viscosity:
      return "viscosity";
    case Unit::area:
      return "area";
  }
  return "quantity";
}

std::string_view file_unit(Unit unit) {
  for (const Name& name : names) {
    if (name.unit == unit) return name.text;
  }
  return "";
}

double file_factor(Unit unit) { return unit == Unit::angle ? degree : 1.0; }

std::string unit_list(Unit unit) {
  std::string list;
  for (const Name& name : names) {
    if (name.unit == unit) list += (list.empty() ? "" : ", ") + std::string(name.text);
  }
  return list;
}

std::string unit_list(const std::vector<Unit>& units) {
  std::string list;
  for (const Unit unit : units) list += (list.empty() ? "" : ", ") + unit_list(unit);
  return list;
}

std::optional<UnitMeaning> find_unit(std::string_view name) {
  const std::string plain = plain_unit(name);
  for (const Name& known : names)
    if (plain_unit(known.text) == plain) return UnitMeaning{known.unit, known.factor};
  return std::nullopt;
}

Parsed parse_quantity(std::string_view text, Unit unit) {
  const std::string_view whole = text;
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  if (text.starts_with('+')) text.remove_prefix(1);
  double number = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (status != std::errc() || !std::isfinite(number)) {
    return failure(fmt::format("\"{}\" is not a number with a unit; {}", whole, example(unit)));
  }
  const std::string name = plain_unit(text.substr(static_cast<std::size_t>(end - text.data())));
  if (name.empty()) return {number * file_factor(unit), ""};
  const Name* other = nullptr;
  for (const Name& known : names) {
    if (plain_unit(known.text) != name) continue;
    if (known.unit == unit) return {number * known.factor, ""};
    if (!other) other = &known;
  }
  if (other) {
    return failure(fmt::format("\"{}\" has the unit of {}; {}", whole, with_article(other->unit), example(unit)));
  }
  const std::string list = unit_list(unit);
  return failure(
      fmt::format("\"{}\" has the unknown unit \"{}\"; {}", whole, name,
                  list.empty() ? example(unit) : "known units of " + std::string(unit_name(unit)) + ": " + list));
}

std::string unit_doubt(std::string_view key, Unit unit, double value) {
  const double size = std::abs(value);
  if (size == 0.0) return "";
  const auto doubt = [&](std::string_view remedy) {
    return fmt::format("{} = {} {}: did you mean {}?", key, value / file_factor(unit), file_unit(unit), remedy);
  };
  if (key == "youngs_modulus") {
    if (size < 1e3) return doubt("GPa");
    if (size < 1e4) return doubt("kPa or MPa");
    if (size > 1e14) return doubt("a smaller unit");
  } else if (unit == Unit::stress && size < 100.0) {
    return doubt("kPa or MPa");
  } else if (unit == Unit::density) {
    if (size < 10.0) return doubt("t/m3 or g/cm3");
    if (size < 50.0) return doubt("a unit weight in kN/m3, of which 20 are a density of 2039 kg/m3");
    if (size > 3e4) return doubt("a smaller number");
  } else if (unit == Unit::angle && size < degree) {
    return doubt("rad");
  } else if (unit == Unit::energy_per_area && size < 1.0) {
    return doubt("N/mm");
  }
  return "";
}

std::string range_text(const Range& range, Unit unit) {
  const auto bound = [&](double value) { return fmt::format("{:.6g}", value / file_factor(unit)); };
  const bool lower = std::isfinite(range.min), upper = std::isfinite(range.max);
  if (!lower && !upper) return "";
  if (!upper) return (range.min_open ? "> " : ">= ") + bound(range.min);
  if (!lower) return (range.max_open ? "< " : "<= ") + bound(range.max);
  return bound(range.min) + (range.min_open ? " < " : " <= ") + "value" + (range.max_open ? " < " : " <= ") +
         bound(range.max);
}

bool in_range(const Range& range, double value) {
  const bool low = range.min_open ? value > range.min : value >= range.min;
  const bool high = range.max_open ? value < range.max : value <= range.max;
  return low && high;
}

}  // namespace berm
