#include "io/summary.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string_view>

#include "base/utf8.hpp"
#include "io/file.hpp"

namespace berm {
namespace {

std::string quoted(std::string_view text) {
  std::string out = "\"";
  for (const char c : as_text(text)) {
    switch (c) {
      case '"':
        out += "\\\"";
        break;
      case '\\':
        out += "\\\\";
        break;
      case '\n':
        out += "\\n";
        break;
      case '\t':
        out += "\\t";
        break;
      default:
        if (static_cast<unsigned char>(c) < 0x20)
          out += fmt::format("\\u{:04x}", static_cast<int>(c));
        else
          out += c;
    }
  }
  return out + '"';
}

std::string number(double value) { return std::isfinite(value) ? fmt::format("{}", value) : "null"; }

template <class Container, class ToText>
std::string listed(const Container& items, std::string_view separator, ToText to_text) {
  std::string out;
  for (const auto& item : items) {
    if (!out.empty()) out += separator;
    out += to_text(item);
  }
  return out;
}

std::string ring_json(const std::vector<Vec2>& ring) {
  return "[" + listed(ring, ", ", [](const Vec2& x) { return fmt::format("[{}, {}]", number(x[0]), number(x[1])); }) +
         "]";
}

std::string body_json(const std::pair<const std::string, std::vector<std::vector<Vec2>>>& body) {
  return fmt::format("    {}: [{}]", quoted(body.first), listed(body.second, ", ", ring_json));
}

/// The name of a file alone where nothing is said about its columns.
std::string reference_json(const ReferenceCurve& r) {
  if (r.x.empty() && r.delimiter.empty() && r.label.empty()) return quoted(r.file);
  return fmt::format("{{\"file\": {}, \"x\": {}, \"y\": {}, \"delimiter\": {}, \"label\": {}}}", quoted(r.file), quoted(r.x),
                     quoted(r.y), quoted(r.delimiter), quoted(r.label));
}

std::string object(const std::string& content) { return content.empty() ? "{}" : "{\n" + content + "\n  }"; }

}  // namespace

std::string summary_json(const Summary& s) {
  std::string out = "{\n";
  const auto line = [&](std::string_view key, const std::string& value) {
    out += fmt::format("  \"{}\": {},\n", key, value);
  };
  line("title", quoted(s.title));
  line("method", quoted(s.method));
  line("case", quoted(s.case_file));
  line("status", quoted(s.status));
  line("reason", quoted(s.reason));
  line("dofs", std::to_string(s.dofs));
  line("points", std::to_string(s.points));
  line("steps", std::to_string(s.steps));
  line("cut_steps", std::to_string(s.cut_steps));
  line("newton_iterations", std::to_string(s.newton_iterations));
  line("wall_seconds", number(s.wall_seconds));
  line("thickness", number(s.thickness));
  line("dimension", std::to_string(s.dimension));
  line("axisymmetric", s.axisymmetric ? "true" : "false");
  line("processes", std::to_string(s.processes));
  line("version", quoted(s.origin.version));
  line("commit", quoted(s.origin.commit));
  line("host", quoted(s.origin.host));
  line("command", quoted(s.origin.command));
  line("references", "[" + listed(s.references, ", ", reference_json) + "]");
  line("body_rings", object(listed(s.body_rings, ",\n", body_json)));
  const auto surface = [](const auto& body) { return fmt::format("    {}: {}", quoted(body.first), quoted(body.second)); };
  line("body_surfaces", object(listed(s.body_surfaces, ",\n", surface)));
  const auto instant = [](const auto& m) {
    return fmt::format("[{}, {}, {}, {}]", number(m[0]), number(m[1]), number(m[2]), number(m[3]));
  };
  const auto motion = [&](const auto& body) {
    return fmt::format("    {}: [{}]", quoted(body.first), listed(body.second, ", ", instant));
  };
  line("rigid_motion", object(listed(s.rigid_motion, ",\n", motion)));
  const auto metric = [](const auto& m) { return fmt::format("    {}: {}", quoted(m.first), number(m.second)); };
  return out + "  \"metrics\": " + object(listed(s.metrics, ",\n", metric)) + "\n}\n";
}

void write_summary(const std::string& path, const Summary& summary) { replace_file(path, summary_json(summary)); }

}  // namespace berm
