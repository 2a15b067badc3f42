#include "case/differences.hpp"

#include <algorithm>
#include <regex>
#include <utility>

#include "case/toml.hpp"

namespace berm {
namespace {

using Values = std::vector<std::pair<std::string, std::string>>;

void flatten(const std::string& key, const Node& node, Values& values) {
  if (node.is_object()) {
    for (const Node::Entry& e : node.object()) flatten(key.empty() ? e.key : key + "." + e.key, e.value, values);
  } else if (const Node::Array* items = node.array()) {
    for (std::size_t i = 0; i < items->size(); ++i) flatten(key + "[" + std::to_string(i) + "]", (*items)[i], values);
  } else {
    std::string text = write_json(node);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    values.emplace_back(key, text);
  }
}

Values values_of(const std::string& resolved) {
  Problems problems;
  Values values;
  flatten("", parse_toml(resolved, "resolved case", problems), values);
  return values;
}

const std::string* find(const Values& values, const std::string& key) {
  const auto found = std::find_if(values.begin(), values.end(), [&](const auto& v) { return v.first == key; });
  return found == values.end() ? nullptr : &found->second;
}

}  // namespace

bool Difference::of_the_model() const {
  // A file may lie elsewhere now; how many points come of it is looked at too.
  static const std::regex fixed(R"(method|model\.(?!gravity|title|allow_glued).*|grid(\.(?!file).*|\[.*)?)"
                                R"(|body\.[^.]+\.(shape(?!.*\.file).*|mesh(?!\.file).*|points.*|material|rigid)|material\.[^.]+\.law)"
                                R"(|(boundary|pin|contact|pressure|absorbing|gauge)\.[^.]+\.(body|rigid|other|kind|at|from|to|where.*))");
  return std::regex_match(key, fixed);
}

std::vector<Difference> differences(const std::string& before, const std::string& now) {
  const Values old_values = values_of(before), new_values = values_of(now);
  std::vector<Difference> found;
  for (const auto& [key, value] : new_values) {
    const std::string* other = find(old_values, key);
    if (!other || *other != value) found.push_back({key, other ? *other : "absent", value});
  }
  for (const auto& [key, value] : old_values)
    if (!find(new_values, key)) found.push_back({key, value, "absent"});
  return found;
}

}  // namespace berm
