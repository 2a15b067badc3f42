#include "case/differences.hpp"

#include <cstdlib>
#include <fstream>
#include <map>
#include <regex>
#include <utility>

#include "base/hash.hpp"
#include "case/toml.hpp"

namespace berm {
namespace {

using Values = std::vector<std::pair<std::string, std::string>>;

/// Calls work with the whole key of every value in a tree, and with the value.
template <class Work>
void for_each_value(const std::string& key, const Node& node, const Work& work) {
  if (node.is_object()) {
    for (const Node::Entry& e : node.object()) for_each_value(key.empty() ? e.key : key + "." + e.key, e.value, work);
  } else if (const Node::Array* items = node.array()) {
    for (std::size_t i = 0; i < items->size(); ++i) for_each_value(key + "[" + std::to_string(i) + "]", (*items)[i], work);
  } else {
    work(key, node);
  }
}

Values values_of(const std::string& resolved) {
  Problems problems;
  Values values;
  for_each_value("", parse_toml(resolved, "resolved case", problems), [&](const std::string& key, const Node& node) {
    std::string text = write_json(node);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    values.emplace_back(key, text);
  });
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

bool Difference::of_a_motion() const {
  static const std::regex motion(R"(boundary\.[^.]+\.u[xyzn]|body\.[^.]+\.displacement(\[\d\])?)");
  return std::regex_match(key, motion);
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
  // Reference curves are for the report alone.
  static const std::regex names_a_file(R"(grid\.file|body\..*\.(file|surface))");
  Problems problems;
  std::string lines;
  for_each_value("", parse_toml(resolved, "resolved case", problems), [&](const std::string& key, const Node& node) {
    const std::string* path = node.string();
    if (!path || !std::regex_match(key, names_a_file)) return;
    std::ifstream file(*path, std::ios::binary);
    Hash hash;
    std::vector<char> piece(1 << 16);
    while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())), file.gcount() > 0)
      hash.add(std::string_view(piece.data(), static_cast<std::size_t>(file.gcount())));
    lines += key + " " + std::to_string(hash.value()) + "\n";
  });
  return lines;
}

}  // namespace berm
