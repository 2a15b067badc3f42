#include "case/differences.hpp"

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
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

/// Texts of numbers may differ and mean the same: 0 and 0.0.
bool same(const std::string& a, const std::string& b) {
  if (a == b) return true;
  char *end_a = nullptr, *end_b = nullptr;
  const double x = std::strtod(a.c_str(), &end_a), y = std::strtod(b.c_str(), &end_b);
  return end_a != a.c_str() && *end_a == 0 && end_b != b.c_str() && *end_b == 0 && x == y;
}

}  // namespace

bool Difference::of_the_model() const {
  // A file may lie elsewhere now; how many points come of it is looked at too.
  static const std::regex fixed(R"(method|model\.(?!gravity|title|allow_glued).*|grid(\.(?!file).*|\[.*)?)"
                                R"(|body\.[^.]+\.(shape(?!.*\.(file|surface)).*|mesh(?!\.file).*|points.*|material|rigid|velocity.*)|material\.[^.]+\.(law|density))"
                                R"(|(boundary|pin|contact|pressure|absorbing|gauge|probe)\.[^.]+\.(body|rigid|other|kind|quantity|(at|from|to|where).*))"
                                R"(|(steps|stage\.[^.]+)\.analysis)");
  return std::regex_match(key, fixed);
}

std::vector<Difference> differences(const std::string& before, const std::string& now) {
  const Values old_values = values_of(before), new_values = values_of(now);
  const std::map<std::string, std::string> old_by_key(old_values.begin(), old_values.end()), new_by_key(new_values.begin(), new_values.end());
  std::vector<Difference> found;
  for (const auto& [key, value] : new_values) {
    const auto other = old_by_key.find(key);
    const bool there = other != old_by_key.end();
    if (!there || !same(other->second, value)) found.push_back({key, there ? other->second : "absent", value});
  }
  for (const auto& [key, value] : old_values)
    if (!new_by_key.contains(key)) found.push_back({key, value, "absent"});
  return found;
}

std::string contents_of_files(const std::string& resolved) {
  static const std::regex names_a_file(R"((.*\.)?(file|surface))");
  std::string lines;
  for (const auto& [key, value] : values_of(resolved)) {
    if (!std::regex_match(key, names_a_file) || value.size() < 2 || value.front() != '"') continue;
    std::ifstream file(value.substr(1, value.size() - 2), std::ios::binary);
    std::uint64_t hash = 14695981039346656037ull;  // FNV-1a
    for (std::istreambuf_iterator<char> byte(file), end; byte != end; ++byte) hash = (hash ^ static_cast<unsigned char>(*byte)) * 1099511628211ull;
    lines += key + " " + std::to_string(hash) + "\n";
  }
  return lines;
}

}  // namespace berm
