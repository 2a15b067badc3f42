#include "case/places.hpp"

#include <algorithm>
#include <regex>

#include "base/error.hpp"

namespace berm {
namespace {

/// The table that a line names first and that the case has, as "pin.left"; empty if none.
std::string named_table(const Case& c, const std::string& line) {
  constexpr std::size_t most = 2000;  // std::regex goes deeper with every character
  static const std::regex names(R"re(\[([a-z_]+\.[A-Za-z0-9_-]+)[\].]|\b(body|bodies|gauge|material) "([^"]+)")re");
  for (std::sregex_iterator m(line.begin(), line.begin() + std::min(line.size(), most), names), end; m != end; ++m) {
    const std::string kind = (*m)[2] == "bodies" ? "body" : (*m)[2].str();
    const std::string table = (*m)[1].matched ? (*m)[1].str() : kind + "." + (*m)[3].str();
    if (c.places.contains(table)) return table;
  }
  return "";
}

/// "mesh.msh:12: ...", "out/a/checkpoint.h5: ..."
bool names_file(const std::string& line) {
  static const std::regex file(R"([^\s]*[A-Za-z][^\s]*\.[A-Za-z][A-Za-z0-9]*(:\d+)*:?)");
  const std::string word = line.substr(0, line.find(' '));
  return word.size() < 1000 && std::regex_match(word, file);
}

}  // namespace

std::string with_places(const Case& c, const std::string& text) {
  std::string out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin), table = named_table(c, line);
    out += !table.empty() ? c.places.at(table) + ": " : names_file(line) ? "" : c.file.string() + ": ";
    out += line;
    if (end < text.size()) out += '\n';
    begin = end + 1;
  }
  return out;
}

void tell_places(const Case& c, const std::function<void()>& work) {
  try {
    work();
  } catch (const InputError& error) {
    throw InputError(with_places(c, error.what()));
  }
}

}  // namespace berm
