/// output.references: curves for the report, as files or as tables that name columns.

#include <fmt/format.h>

#include <filesystem>

#include "case/reference_file.hpp"
#include "case/tables.hpp"

namespace berm {
namespace {

Table<ReferenceCurve> reference_table() {
  Table<ReferenceCurve> t("A curve, and its columns.");
  t.custom(plain_info("file", "file", "string", "CSV with a header"), [](Scope& s, Node::Entry& e, ReferenceCurve& r) {
    if (const auto file = read_file(s, e, false)) r.file = *file;
  }).required();
  t.name("x", &ReferenceCurve::x, "name of a column with its unit",
           "e.g. \"displacement [mm]\": a length, a strain [-], [%], [permille] or a time");
  t.name("y", &ReferenceCurve::y, "name of a column with its unit", "e.g. \"force [kN]\": a force or a stress");
  t.custom(plain_info("delimiter", "\";\", \",\", \"|\" or a tab", "string", "between cells; found in the header if not given"),
           [](Scope& s, Node::Entry& e, ReferenceCurve& r) {
             const auto text = read_string(s, e);
             if (!text) return;
             r.delimiter = *text;
             if (text->size() != 1 || std::string_view(";,|\t").find(*text) == std::string_view::npos)
               s.explain("delimiter", "must be \";\", \",\", \"|\" or a tab (\"\\t\")");
           });
  t.text("label", &ReferenceCurve::label, "in legends; without it as a line \"# label: ...\" of the file says");
  t.check([](Scope& s, ReferenceCurve& r) {
    if (r.x.empty() != r.y.empty()) s.missing(r.x.empty() ? "x" : "y", "name of a column; x and y go together");
  });
  return t;
}

/// One item: the name of a file, or a table.
ReferenceCurve read_reference(Scope& scope, Node::Entry& item) {
  ReferenceCurve curve;
  const std::size_t errors_before = scope.problems.count();
  if (item.value.is_object()) {
    if (auto table = scope.child(item)) reference_table().read(*table, curve);
  } else if (!item.value.string()) {
    scope.problems.error(item.value.place, fmt::format("\"{}\"{} must be the name of a file or a table, not {}", item.key,
                                                       scope.where(), item.value.type_name()));
  } else if (const auto file = read_file(scope, item, false)) {
    curve.file = *file;
  }
  std::error_code ignored;
  if (scope.problems.count() == errors_before && std::filesystem::is_regular_file(curve.file, ignored))
    if (const std::string fault = reference_fault(curve); !fault.empty())
      scope.problems.error(item.value.place, fmt::format("\"{}\"{}: {}", item.key, scope.where(), fault));
  return curve;
}

}  // namespace

KeyInfo references_info() {
  const std::vector<KeyInfo> keys = reference_table().keys();
  KeyInfo info = plain_info("references", "array of files and tables", "array",
                            "curves for the report to compare with: files with columns named as in a history.csv, or tables "
                            "with the keys below");
  info.json = array_schema(either_schema(plain_info("", "", "string", "").json, object_schema(keys)));
  info.children = keys;
  return info;
}

std::vector<ReferenceCurve> read_references(Scope& scope, Node::Entry& entry) {
  std::vector<ReferenceCurve> curves;
  Node::Array* items = entry.value.array();
  if (!items) {
    scope.error(entry.key, fmt::format("must be an array of file names and tables, not {}", entry.value.type_name()));
    return curves;
  }
  for (std::size_t i = 0; i < items->size(); ++i) {
    Node::Entry item{fmt::format("{}[{}]", entry.key, i), (*items)[i].place, (*items)[i]};
    curves.push_back(read_reference(scope, item));
    (*items)[i] = item.value;
  }
  return curves;
}

}  // namespace berm
