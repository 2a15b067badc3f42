#include "io/history.hpp"

#include <fmt/format.h>

#include <iterator>
#include <stdexcept>

namespace berm {
namespace {

/// RFC 4180: names with separators or quotes are quoted.
std::string csv_cell(const std::string& name) {
  if (name.find_first_of(",\"\n\r") == std::string::npos) return name;
  std::string out = "\"";
  for (const char c : name) {
    if (c == '"') out += '"';
    out += c;
  }
  return out + '"';
}

}  // namespace

std::vector<std::string> standard_history_columns() {
  return {"step [-]",
          "time [s]",
          "imposed_displacement [m]",
          "reaction [N]",
          "nominal_stress [Pa]",
          "nominal_strain [-]",
          "load_factor [-]",
          "max_damage [-]",
          "external_work [J]",
          "elastic_energy [J]",
          "dissipated_energy [J]",
          "energy_error [-]",
          "newton_iterations [-]",
          "residual [-]",
          "extrapolation_error [-]",
          "integration [-]"};
}

HistoryWriter::HistoryWriter(const std::string& path, const std::vector<std::string>& columns)
    : file_(path), n_columns_(columns.size()) {
  std::string line;
  for (const std::string& column : columns) {
    if (!line.empty()) line += ',';
    line += csv_cell(column);
  }
  file_.write(line + '\n');
  file_.flush();
}

void HistoryWriter::append(const std::vector<double>& row) {
  if (row.size() != n_columns_)
    throw std::invalid_argument(
        fmt::format("{}: a row of {} values for {} columns", file_.path(), row.size(), n_columns_));
  file_.check_unchanged();
  file_.write(fmt::format("{}\n", fmt::join(row, ",")));
  file_.flush();
}

}  // namespace berm
