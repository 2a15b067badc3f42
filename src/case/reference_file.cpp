#include "case/reference_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <iterator>
#include <optional>
#include <vector>

#include "base/utf8.hpp"
#include "case/units.hpp"

namespace berm {
namespace {

constexpr std::string_view blank = " \t\r";
constexpr std::size_t farthest_header = 50;  ///< lines of what a testing machine writes before the names of the columns

struct Column {
  std::string name, unit;  ///< "force", "kN"
  std::string text() const { return unit.empty() ? name : fmt::format("{} [{}]", name, unit); }
};

struct Line {
  std::size_t number;  ///< in the file, from 1
  std::string_view text;
};

/// An axis of a diagram, the columns of a history.csv that it shows, and the dimension of each.
struct Axis {
  std::string_view key;
  std::array<std::pair<std::string_view, Unit>, 2> columns;
  std::vector<Unit> units;
  std::string_view wanted;
};

const std::array axes = {
    Axis{"x", {{{"nominal_strain", Unit::none}, {"imposed_displacement", Unit::length}}},
         {Unit::none, Unit::length, Unit::time}, "a strain [-], [%] or [permille], a length or a time"},
    Axis{"y", {{{"nominal_stress", Unit::stress}, {"reaction", Unit::force}}}, {Unit::stress, Unit::force},
         "a stress or a force"}};

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(blank);
  if (first == std::string_view::npos) return "";
  return text.substr(first, text.find_last_not_of(blank) + 1 - first);
}

/// "force [kN]" is the column "force" in kN.
Column column_of(std::string_view header) {
  header = trimmed(header);
  const std::size_t open = header.rfind('[');
  if (!header.ends_with(']') || open == std::string_view::npos) return {std::string(header), ""};
  return {std::string(trimmed(header.substr(0, open))),
          std::string(trimmed(header.substr(open + 1, header.size() - open - 2)))};
}

/// Text that is no UTF-8 is Latin-1, as older programs of testing machines write it.
std::string as_utf8(std::string text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.erase(0, 3);
  if (is_utf8(text)) return text;
  std::string out;
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (code >= 0x80) out += static_cast<char>(0xC0 | code >> 6);
    out += code < 0x80 ? c : static_cast<char>(0x80 | (code & 0x3F));
  }
  return out;
}

/// Lines that are neither empty nor comments.
std::vector<Line> lines_of(std::string_view text) {
  std::vector<Line> lines;
  for (std::size_t number = 1, at = 0; at < text.size(); ++number) {
    const std::size_t end = std::min(text.find_first_of("\r\n", at), text.size());
    const std::string_view line = text.substr(at, end - at);
    if (!trimmed(line).empty() && line.front() != '#') lines.push_back({number, line});
    at = end + (text.substr(end).starts_with("\r\n") ? 2 : 1);
  }
  return lines;
}

/// Cells may be quoted, with "" for a quote [RFC 4180].
std::vector<std::string> cells_of(std::string_view line, char delimiter) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (std::size_t k = 0; k < line.size(); ++k) {
    if (line[k] == '"' && quoted && k + 1 < line.size() && line[k + 1] == '"')
      cells.back() += line[k++];
    else if (line[k] == '"')
      quoted = !quoted;
    else if (line[k] == delimiter && !quoted)
      cells.emplace_back();
    else
      cells.back() += line[k];
  }
  return cells;
}

/// Commas come last: they may be decimal ones, and stand in names.
char delimiter_of(std::string_view line, const std::string& given) {
  if (!given.empty()) return given[0];
  for (const char c : {'\t', ';', '|'})
    if (cells_of(line, c).size() > 1) return c;
  return ',';
}

std::vector<Column> columns_of(std::string_view line, const std::string& delimiter) {
  std::vector<Column> columns;
  for (const std::string& cell : cells_of(line, delimiter_of(line, delimiter))) columns.push_back(column_of(cell));
  return columns;
}

/// Those that a name with or without a unit may mean.
std::vector<std::size_t> matches(const std::vector<Column>& columns, const std::string& name) {
  const Column wanted = column_of(name);
  std::vector<std::size_t> found;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const bool same_unit = wanted.unit.empty() || columns[k].unit.empty() || columns[k].unit == wanted.unit;
    if (columns[k].name == wanted.name && same_unit) found.push_back(k);
  }
  return found;
}

std::optional<UnitMeaning> meaning_of(const std::string& unit) {
  if (unit == "-" || unit == "1") return UnitMeaning{Unit::none, 1.0};
  if (unit == "%") return UnitMeaning{Unit::none, 1e-2};
  if (unit == "permille" || unit == "‰") return UnitMeaning{Unit::none, 1e-3};
  return find_unit(unit);
}

std::string no_column(const std::string& name, const std::vector<Column>& columns) {
  std::vector<std::string> texts;
  for (const Column& column : columns) texts.push_back(column.text());
  return fmt::format("no column \"{}\"; there {} \"{}\"", name, texts.size() == 1 ? "is" : "are",
                     fmt::join(texts, "\", \""));
}

/// A decimal comma is one. Nothing for what is no number; NaN for an empty cell, a gap of the measurement.
std::optional<double> number_of(std::string_view cell) {
  std::string text(trimmed(cell));
  if (text.empty()) return std::nan("");
  if (text.find('.') == std::string::npos && std::count(text.begin(), text.end(), ',') == 1)
    text[text.find(',')] = '.';
  const char* begin = text.data() + text.starts_with('+');
  double value = 0.0;
  const auto [end, status] = std::from_chars(begin, text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size() || std::isinf(value)) return std::nullopt;
  return value;
}

class Reader {
public:
  Reader(const ReferenceCurve& curve, const std::string& text) : curve_(curve), lines_(lines_of(text)) {}

  std::string fault() {
    if (lines_.empty()) return curve_.file + ": is empty (a header and rows of numbers are needed)";
    std::string fault = curve_.x.empty() ? find_standard_columns() : find_named_columns();
    return fault.empty() ? read_rows() : fault;
  }

private:
  std::string at(const Line& line, const std::string& text) const {
    return fmt::format("{}:{}: {}", curve_.file, line.number, text);
  }

  /// The first line with those columns; else the first of the widest ones.
  template <class Fits>
  void find_header(Fits fits) {
    std::size_t width = 0;
    for (std::size_t k = 0; k < std::min(lines_.size(), farthest_header); ++k) {
      const std::vector<Column> columns = columns_of(lines_[k].text, curve_.delimiter);
      const bool good = fits(columns);
      if (!good && columns.size() <= width) continue;
      header_ = k;
      columns_ = columns;
      width = columns.size();
      if (good) return;
    }
  }

  std::string find_named_columns() {
    const std::array names = {curve_.x, curve_.y};
    find_header([&](const auto& columns) {
      return std::all_of(names.begin(), names.end(), [&](const auto& name) { return !matches(columns, name).empty(); });
    });
    for (std::size_t k = 0; k < 2; ++k) {
      const std::vector<std::size_t> found = matches(columns_, names[k]);
      if (found.empty()) return at(lines_[header_], no_column(names[k], columns_));
      if (found.size() > 1) return more_than_one(names[k]);
      const std::string unit = column_of(names[k]).unit;
      const std::string fault = take(found[0], unit.empty() ? columns_[found[0]].unit : unit, axes[k]);
      if (!fault.empty()) return fault;
    }
    return "";
  }

  std::string more_than_one(std::string_view name) const {
    return at(lines_[header_], fmt::format("more than one column is \"{}\": rename them", name));
  }

  /// Takes the column as that axis, if it has a unit for it.
  std::string take(std::size_t column, const std::string& unit, const Axis& axis) {
    const std::string& name = columns_[column].name;
    used_.push_back(column);
    if (unit.empty())
      return at(lines_[header_], fmt::format("column \"{}\" has no unit: write it behind the name, {} = \"{} [{}]\"", name,
                                             axis.key, name, unit_in_round_brackets(name).value_or(usual_unit(axis))));
    const auto meaning = meaning_of(unit);
    if (!meaning)
      return at(lines_[header_], fmt::format("column \"{}\" has the unknown unit \"{}\"; known: {}", name, unit,
                                             known_units(axis)));
    if (std::find(axis.units.begin(), axis.units.end(), meaning->unit) != axis.units.end()) return "";
    return at(lines_[header_], fmt::format("column \"{}\" in [{}] cannot be {}, which is {}", name, unit, axis.key,
                                           axis.wanted));
  }

  /// A length or a force, where the axis may be one.
  static std::string usual_unit(const Axis& axis) {
    const Unit unit = axis.units[axis.units.size() > 1 ? 1 : 0];
    return unit == Unit::none ? "-" : std::string(file_unit(unit));
  }

  /// "Weg (mm)", as other programs write it.
  static std::optional<std::string> unit_in_round_brackets(const std::string& name) {
    const std::size_t open = name.rfind('('), close = name.rfind(')');
    if (open == std::string::npos || close == std::string::npos || close < open) return std::nullopt;
    const std::string unit = name.substr(open + 1, close - open - 1);
    return meaning_of(unit) ? std::optional(unit) : std::nullopt;
  }

  static std::string known_units(const Axis& axis) {
    return (axis.key == "x" ? "-, %, permille, " : "") + unit_list(axis.units);
  }

  std::string find_standard_columns() {
    std::vector<std::string_view> names;
    for (const Axis& axis : axes)
      for (const auto& [name, unit] : axis.columns) names.push_back(name);
    const auto is_there = [&](const std::vector<Column>& columns, std::string_view name) {
      return std::any_of(columns.begin(), columns.end(), [&](const Column& c) { return c.name == name; });
    };
    const auto count = [&](const std::vector<Column>& columns) {
      return std::count_if(names.begin(), names.end(), [&](auto name) { return is_there(columns, name); });
    };
    find_header([&](const auto& columns) { return count(columns) >= 2; });
    if (count(columns_) < 2) {
      const std::string none = no_column(fmt::format("{}", fmt::join(names, "\" or \"")), columns_);
      return at(lines_[header_], fmt::format("{}; two are needed, or say which are meant: {{ file = \"{}\", x = \"{}\", y = "
                                             "\"{}\" }}",
                                             none, curve_.file.substr(curve_.file.rfind('/') + 1), columns_[0].text(),
                                             columns_.back().text()));
    }
    for (const Axis& axis : axes)
      for (const auto& [name, unit] : axis.columns) {
        const std::vector<std::size_t> found = matches(columns_, std::string(name));
        if (found.empty()) continue;
        if (found.size() > 1) return more_than_one(name);
        const std::string fault = take(found[0], columns_[found[0]].unit, {axis.key, axis.columns, {unit}, unit_name(unit)});
        if (!fault.empty()) return fault;
      }
    return "";
  }

  std::string read_rows() {
    const char delimiter = delimiter_of(lines_[header_].text, curve_.delimiter);
    std::size_t rows = 0;
    bool point = false, comma = false;
    for (std::size_t k = header_ + 1; k < lines_.size(); ++k) {
      const std::vector<std::string> cells = cells_of(lines_[k].text, delimiter);
      const bool more = std::any_of(cells.begin() + static_cast<std::ptrdiff_t>(std::min(cells.size(), columns_.size())), cells.end(),
                                    [](const std::string& cell) { return !trimmed(cell).empty(); });
      if (more)
        return at(lines_[k], fmt::format("{} cells, where the header has {} (decimal commas need another delimiter than a "
                                         "comma, or quotes)",
                                         cells.size(), columns_.size()));
      bool complete = true;
      for (const std::size_t column : used_) {
        if (column >= cells.size()) {
          if (k + 1 == lines_.size()) return rows > 0 ? "" : no_rows();  // cut short by a run that was killed
          return at(lines_[k], fmt::format("{} cells, where the header has {}", cells.size(), columns_.size()));
        }
        const auto number = number_of(cells[column]);
        if (!number)
          return at(lines_[k], fmt::format("\"{}\" in column \"{}\" is no number", trimmed(cells[column]),
                                           columns_[column].text()));
        complete = complete && !std::isnan(*number);
        point |= cells[column].find('.') != std::string::npos;
        comma |= cells[column].find(',') != std::string::npos;
        if (point && comma)
          return at(lines_[k], fmt::format("\"{}\" in column \"{}\": the file has decimal commas and decimal points",
                                           trimmed(cells[column]), columns_[column].text()));
      }
      rows += complete;
    }
    return rows > 0 ? "" : no_rows();
  }

  std::string no_rows() const {
    std::vector<std::string> names;
    for (const std::size_t column : used_) names.push_back(columns_[column].text());
    return at(lines_[header_], fmt::format("no row below it has numbers in the columns \"{}\"", fmt::join(names, "\", \"")));
  }

  const ReferenceCurve& curve_;
  std::vector<Line> lines_;
  std::size_t header_ = 0;
  std::vector<Column> columns_;
  std::vector<std::size_t> used_;
};

}  // namespace

std::string reference_fault(const ReferenceCurve& curve) {
  std::ifstream file(curve.file, std::ios::binary);
  if (!file) return curve.file + ": cannot be read (check the permissions)";
  const std::string text = as_utf8({std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()});
  if (text.find('\0') != std::string::npos)
    return curve.file + ": is no text in UTF-8 or Latin-1 (export it as CSV)";
  return Reader(curve, text).fault();
}

}  // namespace berm
