#include "case/load.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>

#include "case/toml.hpp"

namespace berm {
namespace {

namespace fs = std::filesystem;

/// No case is larger; keeps a wrong file name (a video, say) from being parsed.
constexpr std::uintmax_t max_bytes = 4'000'000;
/// In the place of a file's identity, which begins with a /.
constexpr const char* given_text = "-";

std::optional<std::string> read_text(const std::string& path, const Place& place, Problems& problems) {
  std::error_code status;
  if (!fs::is_regular_file(path, status)) {
    problems.error(place, fmt::format("case file \"{}\" {}", path,
                                      fs::is_directory(path, status) ? "is a folder: name a file in it"
                                      : fs::exists(path, status)     ? "is not a file"
                                                                     : "does not exist"));
    return std::nullopt;
  }
  if (fs::file_size(path, status) > max_bytes) {
    problems.error(place, fmt::format("\"{}\" is too large for a case file", path));
    return std::nullopt;
  }
  std::ifstream in(path, std::ios::binary);
  const std::string why = in ? "" : fmt::format(": {}", std::strerror(errno));
  try {  // files of /proc say only here that they cannot be read
    std::string text{std::istreambuf_iterator<char>(in), {}};
    if (in) return text;
  } catch (const std::ios_base::failure&) {
  }
  problems.error(place, fmt::format("case file \"{}\" cannot be read{}", path, why));
  return std::nullopt;
}

/// Puts `over` on top of `under`. Merged tables take the place of `over`, except for overrides: an error about
/// something missing in a table belongs to the file.
void merge(Node& under, Node over) {
  if (!under.is_object() || !over.is_object()) {
    under = std::move(over);
    return;
  }
  if (over.place.override.empty()) under.place = over.place;
  for (Node::Entry& entry : over.object()) {
    Node::Entry* old = under.find(entry.key);
    if (!old) {
      under.object().push_back(std::move(entry));
      continue;
    }
    if (entry.place.override.empty()) old->place = entry.place;
    merge(old->value, std::move(entry.value));
  }
}

/// Drops "contact.top" and its like from the tree.
void remove_path(Node& root, const Node& item, Problems& problems) {
  const std::string* path = item.string();
  if (!path) {
    problems.error(item.place, "\"remove\" must be an array of strings such as \"contact.top\"");
    return;
  }
  Node* table = &root;
  std::string_view rest = *path;
  while (true) {
    const std::size_t dot = rest.find('.');
    const std::string key(rest.substr(0, dot));
    Node::Entry* entry = table->find(key);
    if (!entry) {
      std::vector<std::string> keys;
      if (table->is_object()) {
        for (const Node::Entry& other : table->object()) keys.push_back(other.key);
      }
      problems.error(item.place, fmt::format("\"remove\": the base has no \"{}\"{}", *path, suggestion(key, keys)));
      return;
    }
    if (dot == std::string_view::npos) return table->erase(key);
    table = &entry->value;
    rest.remove_prefix(dot + 1);
  }
}

void apply_remove(Node& root, const Node::Entry& remove, Problems& problems) {
  const Node::Array* items = remove.value.array();
  if (!items) {
    problems.error(remove.value.place, "\"remove\" must be an array of strings such as [\"contact.top\"]");
    return;
  }
  for (const Node& item : *items) remove_path(root, item, problems);
}

Node load_file(const std::string& path, const Place& asked_by, std::vector<std::string>& chain,
               const std::optional<std::string>& given, Problems& problems) {
  std::error_code status;
  const std::string identity = given ? given_text : fs::weakly_canonical(path, status).string();
  if (std::find(chain.begin(), chain.end(), identity) != chain.end()) {
    problems.error(asked_by,
                   fmt::format("\"base\" goes round in a circle: {} -> {}", fmt::join(chain, " -> "), identity));
    return {};
  }
  const auto text = given ? given : read_text(path, asked_by, problems);
  if (!text) return {};
  Node own = parse_toml(*text, path, problems);
  const Node::Entry* base = own.find("base");
  const Node::Entry* remove = own.find("remove");
  Node merged;
  if (base && !base->value.string()) {
    problems.error(base->value.place, fmt::format("\"base\" must be a string, not {}", base->value.type_name()));
  } else if (base) {
    chain.push_back(identity);
    const fs::path base_path = (fs::path(path).parent_path() / *base->value.string()).lexically_normal();
    merged = load_file(base_path.string(), base->value.place, chain, std::nullopt, problems);
    chain.pop_back();
    if (remove && problems.empty()) apply_remove(merged, *remove, problems);
  } else if (remove) {
    problems.error(remove->place, "\"remove\" needs a \"base\" to remove from");
  }
  own.erase("base");
  own.erase("remove");
  merge(merged, std::move(own));
  return merged;
}

}  // namespace

Node load_case(const std::string& path, const std::vector<std::string>& overrides, const std::optional<std::string>& given,
               Problems& problems) {
  std::vector<std::string> chain;
  Node root = load_file(path, {path, "", 0, 0}, chain, given, problems);
  for (const std::string& text : overrides) {
    Node change = parse_override(text, problems);
    for (const char* key : {"base", "remove"}) {
      if (change.find(key)) problems.error(change.place, fmt::format("\"{}\" cannot be overridden", key));
      change.erase(key);
    }
    merge(root, std::move(change));
  }
  return root;
}

}  // namespace berm
