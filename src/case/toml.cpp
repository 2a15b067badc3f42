/// The only translation unit that sees toml++.

#include "case/toml.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <optional>
#include <sstream>
#include <tuple>

namespace berm {
namespace {

/// Deeper nesting than any case needs; keeps every recursion over the tree shallow.
constexpr int max_depth = 64;

Place place_of(const toml::source_region& region, const std::string& file) {
  return {file, "", static_cast<int>(region.begin.line), static_cast<int>(region.begin.column)};
}

struct Converter {
  const std::string& file;
  Problems& problems;

  Node convert(const toml::node& node, int depth) const {
    const Place place = place_of(node.source(), file);
    if (depth > max_depth) {
      problems.error(place, fmt::format("nested more than {} levels deep, where no key of a case is: take brackets away", max_depth));
      return Node(false, place);
    }
    if (const auto* table = node.as_table()) return Node(convert_table(*table, depth), place);
    if (const auto* array = node.as_array()) {
      Node::Array items;
      for (const toml::node& item : *array) items.push_back(convert(item, depth + 1));
      return Node(std::move(items), place);
    }
    if (const auto* b = node.as_boolean()) return Node(b->get(), place);
    if (const auto* i = node.as_integer()) return Node(i->get(), place);
    if (const auto* d = node.as_floating_point()) return Node(d->get(), place);
    if (const auto* s = node.as_string()) return Node(s->get(), place);
    return Node(Node::Date{date_text(node)}, place);
  }

  Node::Object convert_table(const toml::table& table, int depth) const {
    Node::Object entries;
    for (auto&& [key, value] : table) {
      const Place place = place_of(key.source(), file);
      entries.push_back({std::string(key.str()), place, convert(value, depth + 1)});
    }
    // toml++ sorts by name; bodies and materials are wanted in the order of the file.
    std::stable_sort(entries.begin(), entries.end(), [](const Node::Entry& a, const Node::Entry& b) {
      return std::tie(a.place.line, a.place.column) < std::tie(b.place.line, b.place.column);
    });
    return entries;
  }

  static std::string date_text(const toml::node& node) {
    std::ostringstream text;
    if (const auto* date = node.as_date()) text << date->get();
    if (const auto* time = node.as_time()) text << time->get();
    if (const auto* both = node.as_date_time()) text << both->get();
    return text.str();
  }
};

/// Keys dotted thousands of levels deep would overflow the stack inside toml++, which limits values only. Dots of comments
/// and strings do not count.
bool dotted_too_deeply(const std::string& text) {
  int dots = 0;
  std::string quote;  // that ends the present string
  bool comment = false;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\n' || (quote.empty() && !comment && (c == ',' || c == '='))) dots = 0;
    if (c == '\n' && quote.size() < 3) {
      comment = false;
      quote.clear();
    } else if (!quote.empty()) {
      if (c == '\\' && quote[0] == '"')
        ++i;
      else if (text.compare(i, quote.size(), quote) == 0) {
        i += quote.size() - 1;
        quote.clear();
      }
    } else if (!comment) {
      comment = c == '#';
      if (c == '"' || c == '\'') {
        quote = text.compare(i, 3, std::string(3, c)) == 0 ? std::string(3, c) : std::string(1, c);
        i += quote.size() - 1;
      }
      if (c == '.' && ++dots > 1000) return true;
    }
  }
  return false;
}

void mark_override(Node& node, const std::string& text) {
  node.place = {"", text, 0, 0};
  if (Node::Array* items = node.array()) {
    for (Node& item : *items) mark_override(item, text);
  } else if (node.is_object()) {
    for (Node::Entry& entry : node.object()) {
      entry.place = node.place;
      mark_override(entry.value, text);
    }
  }
}

std::string basic_string(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

bool is_whole_number(const std::string& text) {
  const std::size_t sign = text.starts_with('-') || text.starts_with('+') ? 1 : 0;
  return text.size() > sign && text.find_first_not_of("0123456789", sign) == std::string::npos;
}

/// Or what is wrong with it.
std::optional<Node> parse_assignment(const std::string& line, std::string& why) {
  if (dotted_too_deeply(line)) return std::nullopt;
  try {
    const std::string file;
    Problems ignored;
    Node node = Converter{file, ignored}.convert(toml::parse(line), 0);
    if (!ignored.empty()) return std::nullopt;
    return node;
  } catch (const toml::parse_error& error) {
    why = error.description();
    return std::nullopt;
  }
}

}  // namespace

Node parse_toml(const std::string& text, const std::string& file, Problems& problems) {
  if (dotted_too_deeply(text)) {
    problems.error({file, "", 0, 0}, "not valid TOML: a key of more than a thousand parts");
    return {};
  }
  try {
    return Converter{file, problems}.convert(toml::parse(text, file), 0);
  } catch (const toml::parse_error& error) {
    problems.error(place_of(error.source(), file), fmt::format("not valid TOML: {}", error.description()));
    return {};
  }
}

Node parse_override(const std::string& text, Problems& problems) {
  const Place place = {"", text, 0, 0};
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    problems.error(place, "must be dotted.key=value");
    return {};
  }
  const std::string key = text.substr(0, equals), value = text.substr(equals + 1);
  std::optional<Node> node;
  std::string why;
  if (text.find_first_of("\r\n") == std::string::npos) {
    node = parse_assignment(key + "=" + value, why);
    if (!node) {
      const std::string word = value.substr(std::min(value.find_first_not_of(' '), value.size()));
      const auto stays_open = [&](char open, char close) { return word.starts_with(open) && std::count(word.begin(), word.end(), open) > std::count(word.begin(), word.end(), close); };
      if ((stays_open('[', ']') || stays_open('{', '}')) && !why.empty() && parse_assignment(key + "=0", why)) {
        problems.error(place, fmt::format("not valid TOML: {}", why));
        return {};
      }
      node = parse_assignment(key + "=" + basic_string(word), why);
      if (node && is_whole_number(value)) {
        problems.error(place, fmt::format("{} is no whole number: it begins with 0 or has more than 64 bits", value));
        return {};
      }
    }
  }
  if (!node) {
    problems.error(place, "must be dotted.key=value on one line, with keys of letters, digits, _ and -");
    return {};
  }
  mark_override(*node, text);
  return std::move(*node);
}

}  // namespace berm
