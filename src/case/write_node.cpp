/// Node trees as text: TOML for the resolved case, JSON for the schema.

#include <fmt/format.h>

#include <cmath>

#include "case/node.hpp"

namespace berm {
namespace {

/// Both TOML basic strings and JSON strings understand these escapes.
std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      out += '\\';
      out += c;
    } else if (byte < 0x20 || byte == 0x7f) {
      out += fmt::format("\\u{:04X}", byte);
    } else {
      out += c;
    }
  }
  return out + '"';
}

/// Shortest text that reads back to the same number, and as a floating-point one.
std::string number_text(double x) {
  if (std::isnan(x)) return "nan";
  if (std::isinf(x)) return x > 0 ? "inf" : "-inf";
  std::string text = fmt::format("{}", x);
  if (text.find_first_of(".e") == std::string::npos) text += ".0";
  return text;
}

bool is_bare(std::string_view key) {
  return !key.empty() && key.find_first_not_of("abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-") ==
                             std::string_view::npos;
}

std::string key_text(std::string_view key) { return is_bare(key) ? std::string(key) : quoted(key); }

std::string scalar_text(const Node& node) {
  if (const bool* b = std::get_if<bool>(&node.value)) return *b ? "true" : "false";
  if (const std::int64_t* i = std::get_if<std::int64_t>(&node.value)) return fmt::format("{}", *i);
  if (const double* d = std::get_if<double>(&node.value)) return number_text(*d);
  if (const Node::Date* date = std::get_if<Node::Date>(&node.value)) return date->text;
  return quoted(*node.string());
}

std::string inline_toml(const Node& node) {
  std::string out;
  if (const Node::Array* items = node.array()) {
    for (const Node& item : *items) out += (out.empty() ? "" : ", ") + inline_toml(item);
    return "[" + out + "]";
  }
  if (!node.is_object()) return scalar_text(node);
  for (const Node::Entry& entry : node.object()) {
    out += (out.empty() ? "" : ", ") + key_text(entry.key) + " = " + inline_toml(entry.value);
  }
  return out.empty() ? "{}" : "{ " + out + " }";
}

/// Tables above this depth get a [header] of their own.
constexpr int header_depth = 2;

bool has_header(const Node& node, int depth) { return node.is_object() && depth < header_depth; }

void write_table(const Node& table, const std::string& path, int depth, std::string& out) {
  std::string own;
  bool only_tables = !table.object().empty();
  for (const Node::Entry& entry : table.object()) {
    if (has_header(entry.value, depth)) continue;
    only_tables = false;
    own += key_text(entry.key) + " = " + inline_toml(entry.value) + "\n";
  }
  if (depth > 0 && !only_tables) out += fmt::format("\n[{}]\n", path);
  out += own;
  for (const Node::Entry& entry : table.object()) {
    if (!has_header(entry.value, depth)) continue;
    write_table(entry.value, (path.empty() ? "" : path + ".") + key_text(entry.key), depth + 1, out);
  }
}

void write_json(const Node& node, int indent, std::string& out) {
  const std::string pad(static_cast<std::size_t>(indent) + 2, ' ');
  const std::string end(static_cast<std::size_t>(indent), ' ');
  const char* separator = "\n";
  if (const Node::Array* items = node.array()) {
    out += "[";
    for (const Node& item : *items) {
      out += separator + pad;
      write_json(item, indent + 2, out);
      separator = ",\n";
    }
    out += items->empty() ? "]" : "\n" + end + "]";
  } else if (node.is_object()) {
    out += "{";
    for (const Node::Entry& entry : node.object()) {
      out += separator + pad + quoted(entry.key) + ": ";
      write_json(entry.value, indent + 2, out);
      separator = ",\n";
    }
    out += node.object().empty() ? "}" : "\n" + end + "}";
  } else {
    out += scalar_text(node);
  }
}

}  // namespace

std::string write_toml(const Node& root) {
  std::string out;
  write_table(root, "", 0, out);
  return out;
}

std::string write_json(const Node& root) {
  std::string out;
  write_json(root, 0, out);
  return out + "\n";
}

}  // namespace berm
