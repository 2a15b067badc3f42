/// Materials: what is common to all, and the parameters of every law in AnyLaw.

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "case/tables.hpp"
#include "case/units.hpp"

namespace berm {
namespace {

/// A crack-band length so short that what a law then refuses is wrong on every grid. The lengths of the grid's cells
/// are checked when the grid is there.
constexpr double nanometre = 1e-9;

std::vector<std::string> law_names() {
  std::vector<std::string> names;
  for_each_law([&](auto law) { names.emplace_back(law.name); });
  return names;
}

void read_crack_band(Scope& scope, Node::Entry& entry, Material& m) {
  using Band = Material::CrackBand;
  const std::string* word = entry.value.string();
  const bool is_word = word && !word->empty() && std::isalpha(static_cast<unsigned char>(word->front()));
  if (is_word) {
    const auto i = read_choice(scope, entry, {"sqrt_area", "equal_circle"});
    if (i) m.crack_band = *i == 0 ? Band::sqrt_area : Band::equal_circle;
  } else if (const auto length = read_number(scope, entry, Unit::length, positive())) {
    m.crack_band = Band::fixed;
    m.crack_band_length = *length;
  }
}

KeyInfo crack_band_info() {
  KeyInfo info =
      plain_info("crack_band", "\"sqrt_area\", \"equal_circle\" or number [m]", "string",
                 "crack-band length of a cell: edge of the square (in space: cube) that it is a part of, diameter of "
                 "the circle (sphere) of its size, or this length");
  Node either;
  either.set("anyOf", Node(Node::Array{choice_info("", {"sqrt_area", "equal_circle"}, "").json,
                                       number_info("", Unit::length, positive(), "").json}));
  info.json = std::move(either);
  return info;
}

Table<Material> common_table() {
  Table<Material> t("");
  t.custom(choice_info("law", law_names(), "constitutive law"), [](Scope&, Node::Entry&, Material&) {}).required();
  t.number("density", &Material::density, Unit::density, positive(), "mass per reference volume").required();
  t.custom(crack_band_info(), read_crack_band,
           [](Material&, int) { return std::optional<Node>(Node(std::string("sqrt_area"))); });
  return t;
}

void warn_unit(const Scope& scope, const std::string& key, Unit unit, double value) {
  const std::string doubt = unit_doubt(key, unit, value);
  if (!doubt.empty()) scope.warn(key, doubt);
}

/// Of a strength that the law must have: no solid of that stiffness is so weak, metals and stones have 1e-5 to 0.1 of it.
template <class L>
void warn_of_strengths(const Scope& scope, const L& law) {
  constexpr double weakest = 1e-6;
  for (const Parameter<L>& p : L::parameters()) {
    const double strength = law.*(p.member), ratio = strength / law.stiffness();
    const bool named = p.key == "yield_stress" || p.key == "tensile_strength";
    if (!named || p.default_value || !scope.has(p.key) || !(ratio < weakest) || !unit_doubt(p.key, p.unit, strength).empty()) continue;
    scope.warn(p.key, fmt::format("{} = {:.4g} Pa is {:.2g} of the stiffness of {:.3g} Pa: is its unit right (\"250 MPa\")?", p.key, strength, ratio, law.stiffness()));
  }
}

template <class L>
Table<Material> material_table() {
  Table<Material> t = common_table();
  for (const Parameter<L>& p : L::parameters()) {
    const auto value = [member = p.member](Material& m) -> double& { return std::get<L>(m.law).*member; };
    t.custom(
        number_info(p.key, p.unit, p.range, p.doc),
        [=](Scope& s, Node::Entry& e, Material& m) {
          if (const auto v = read_number(s, e, p.unit, p.range)) value(m) = *v;
        },
        [=](Material&, int) { return number_node(p.default_value, p.unit); });
    if (!p.default_value) t.required();
  }
  t.check([](Scope& s, Material& m) {
    warn_unit(s, "density", Unit::density, m.density);
    for (const Parameter<L>& p : L::parameters()) {
      if (s.has(p.key)) warn_unit(s, p.key, p.unit, std::get<L>(m.law).*(p.member));
    }
    warn_of_strengths(s, std::get<L>(m.law));
    const bool fixed = m.crack_band == Material::CrackBand::fixed;
    const std::string trouble = std::get<L>(m.law).check(fixed ? m.crack_band_length : nanometre);
    if (trouble.empty()) return;
    if (fixed) {
      s.explain("crack_band", trouble);
    } else {
      s.problems.error(s.place, fmt::format("[{}]: {}", s.path, trouble));
    }
  });
  return t;
}

template <class L>
void read_law(Scope& scope, Material& material) {
  static const Table<Material> table = material_table<L>();
  L law{};
  for (const Parameter<L>& p : L::parameters()) {
    if (p.default_value) law.*(p.member) = *p.default_value;
  }
  material.law = law;
  table.read(scope, material);
}

bool same_doc(const KeyInfo& a, const KeyInfo& b) {
  return a.key == b.key && a.range == b.range && a.doc == b.doc && a.default_text == b.default_text &&
         a.required == b.required;
}

}  // namespace

void read_material(Scope& scope, Material& material) {
  Node::Entry* law = scope.node.find("law");
  if (!law) return scope.missing("law", fmt::format("one of {}", fmt::join(law_names(), ", ")));
  const auto chosen = read_choice(scope, *law, law_names());
  std::size_t i = 0;
  for_each_law([&]<class L>(L) {
    if (chosen == i++) read_law<L>(scope, material);
  });
}

std::vector<KeyInfo> material_keys() {
  std::vector<KeyInfo> keys = common_table().keys();
  const std::size_t n_common = keys.size();
  for_each_law([&]<class L>(L) {
    const std::vector<KeyInfo> all = material_table<L>().keys();
    for (auto info = all.begin() + static_cast<std::ptrdiff_t>(n_common); info != all.end(); ++info) {
      const auto twin = std::find_if(keys.begin(), keys.end(), [&](const KeyInfo& k) { return same_doc(k, *info); });
      if (twin != keys.end()) {
        twin->condition += fmt::format(", \"{}\"", L::name);
      } else {
        keys.push_back(*info);
        keys.back().condition = fmt::format("with law = \"{}\"", L::name);
      }
    }
  });
  return keys;
}

std::string material_doc() {
  std::string doc = "What bodies are made of. The laws:\n";
  for_each_law([&](auto law) { doc += fmt::format("\n- `{}`: {}", law.name, law.doc); });
  return doc;
}

}  // namespace berm
