/// The key reference as Markdown and as a JSON Schema.

#include <fmt/format.h>

#include "case/read_case.hpp"
#include "case/tables.hpp"
#include "case/units.hpp"

namespace berm {
namespace {

/// A bar would end the cell of a Markdown table.
std::string cell(std::string text) {
  for (std::size_t at = text.find('|'); at != std::string::npos; at = text.find('|', at + 2))
    text.replace(at, 1, "\\|");
  return text;
}

std::string default_cell(const KeyInfo& info) {
  if (info.required) return "required";
  return info.default_text;
}

void write_rows(const std::vector<KeyInfo>& keys, const std::string& prefix, std::string& out) {
  for (const KeyInfo& info : keys) {
    std::string value = info.type + (info.range.empty() ? "" : ", " + info.range);
    std::string meaning = info.doc;
    if (meaning.ends_with('.')) meaning.pop_back();
    if (!info.condition.empty()) meaning += "; only " + info.condition;
    out += fmt::format("| `{}` | {} | {} | {} |\n", prefix + info.key, cell(value), cell(default_cell(info)),
                       cell(meaning));
    write_rows(info.children, prefix + info.key + ".", out);
  }
}

void write_section(const std::string& title, const std::string& doc, const std::vector<KeyInfo>& keys,
                   std::string& out) {
  out += fmt::format("\n## {}\n", title);
  if (!doc.empty()) out += doc + "\n";
  out += "\n| key | value | default | meaning |\n|---|---|---|---|\n";
  write_rows(keys, "", out);
}

std::string unit_rows() {
  std::string out;
  for (const Unit unit : {Unit::length, Unit::stress, Unit::density, Unit::energy_per_area, Unit::velocity, Unit::acceleration,
                          Unit::angle, Unit::force, Unit::stress_per_length, Unit::area, Unit::time, Unit::rate,
                          Unit::viscosity}) {
    out += fmt::format("| {} | {} | {} |\n", unit_name(unit), file_unit(unit), unit_list(unit));
  }
  return out;
}

constexpr std::string_view introduction = R"md(# Case file reference

Printed by `berm schema` from the table that parses case files.

A case is a TOML file. Tables such as `[material.NAME]` may be given many times with names of your own, made of letters,
digits, `_` and `-`. Unknown keys are errors. Paths are relative to the file that contains them, those of command-line
overrides to the current folder.

Places and vectors have two numbers, `[x, y]`, in plane and axisymmetric models, and three, `[x, y, z]`, in models in
space (`dimension = 3` in `[model]`); below they are `[x, y(, z)]`. In axisymmetric models x is the radius and y the axis.

Numbers are in SI units, **angles in degrees**. A string carries its unit: `"35.5 GPa"`, `"20 deg"`, `"5 mm"`.

**Loads and motions** are functions of the time t, which runs from 0 through all stages. A number is reached linearly at the end
of the first stage (of the run, if it has one) and held; gravity and pressures hold from the start if that stage is dynamic. A
string that is no number with a unit is an expression, in SI units: `"9.81*min(t/0.5, 1)"`, for pressures of the
place too: `"9810*max(0, 5*t - y)"`. Operators: `+ - * / ^`, comparisons, `&& ||`, `a ? b : c`; functions: `sin cos tan asin acos
atan sinh cosh tanh exp ln log10 sqrt abs sign rint min max sum avg`; constant: `pi`.

| quantity | bare number | units in strings |
|---|---|---|
)md";

}  // namespace

std::string schema_markdown() {
  std::string out(introduction);
  out += unit_rows();
  std::vector<KeyInfo> top;
  std::string sections;
  for (const KeyInfo& info : case_table().keys()) {
    if (info.children.empty()) {
      top.push_back(info);
    } else {
      write_section(fmt::format("[{}{}]", info.key, info.named ? ".NAME" : ""), info.doc, info.children, sections);
    }
  }
  write_section("Top level", "", top, out);
  return out + sections;
}

std::string schema_json() {
  Node schema;
  schema.set("$schema", Node(std::string("https://json-schema.org/draft/2020-12/schema")));
  schema.set("title", Node(std::string("berm case file")));
  Node all = object_schema(case_table().keys());
  for (Node::Entry& entry : all.object()) schema.set(entry.key, std::move(entry.value));
  Node definitions;
  definitions.set("shape", shape_schema());
  schema.set("$defs", std::move(definitions));
  return write_json(schema);
}

}  // namespace berm
