#include <fmt/format.h>

#include <cctype>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include "base/error.hpp"
#include "mesh/msh_contents.hpp"

namespace berm {

namespace {

using Numbers = std::vector<long long>;

class MshText {
public:
  explicit MshText(const std::string& path)
      : path_(path), file_(path), contents_([this](const std::string& what) { fail(what); }) {}

  void check() {
    if (!next() || line_ != "$MeshFormat")
      fail("is not a Gmsh mesh (it does not begin with $MeshFormat; export it as .msh 4.1 or 2.2)");
    next();
    version_ = line_.substr(0, line_.find(' '));
    if (version_ != "2.2" && version_ != "4.1")
      fail(fmt::format("version {} of the .msh format is not supported (export it as 4.1 or 2.2)", version_));
    if (line_.compare(version_.size(), 3, " 1 ") == 0) return check_binary_msh(path_, version_ == "2.2");
    while (next()) {
      if (line_ == "$Nodes") nodes();
      if (line_ == "$Elements") elements();
    }
    if (!contents_.has_nodes()) fail("has no nodes ($Nodes is missing or empty)");
    if (!has_elements_) fail("has no plane cells and no volume cells ($Elements is missing)");
  }

private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(number_ == 0 ? fmt::format("{}: {}", path_, what)
                                  : fmt::format("{}:{}: {}", path_, number_, what));
  }

  /// The next line that is not blank, without blanks around it.
  bool next() {
    while (std::getline(file_, line_)) {
      ++number_;
      const std::size_t first = line_.find_first_not_of(" \t\r"), last = line_.find_last_not_of(" \t\r");
      if (first == std::string::npos) continue;
      line_ = line_.substr(first, last - first + 1);
      return true;
    }
    line_.clear();
    return false;
  }

  void need_line() {
    if (!next()) fail("the file ends too early");
  }

  /// The next line as at least `count` whole numbers.
  Numbers numbers(std::size_t count) {
    need_line();
    Numbers values;
    const char *at = line_.data(), *end = at + line_.size();
    while (at < end) {
      while (at < end && (*at == ' ' || *at == '\t')) ++at;
      long long value = 0;
      const auto [stop, error] = std::from_chars(at, end, value);
      if (error != std::errc() || value < 0 || (stop < end && *stop != ' ' && *stop != '\t'))
        fail("positive whole numbers are expected here");
      values.push_back(value);
      at = stop;
    }
    if (values.size() < count) fail(fmt::format("{} numbers are expected here", count));
    return values;
  }

  void end_of(const char* section) {
    need_line();
    if (line_ != section) fail(fmt::format("{} is expected here (the counts before are wrong)", section));
  }

  /// Three numbers, at least, from there to the end of the line.
  void coordinates(const char* from) {
    const char* const end = line_.data() + line_.size();
    for (int i = 0; i < 3; ++i) {
      while (from < end && (*from == ' ' || *from == '\t')) ++from;
      double x = 0.0;
      const auto [stop, error] = std::from_chars(from + (from < end && *from == '+'), end, x);
      if (error != std::errc() || !std::isfinite(x) || (stop < end && std::isspace(static_cast<unsigned char>(*stop)) == 0))
        fail("three coordinates are expected here, numbers with a decimal point");
      from = stop;
    }
  }

  void nodes() {
    if (version_ == "2.2") {
      for (long long n = numbers(1)[0]; n > 0; --n) {
        need_line();
        long long tag = 0;
        const auto [stop, error] = std::from_chars(line_.data(), line_.data() + line_.size(), tag);
        if (error != std::errc() || tag < 1 || *stop != ' ') fail("a node's number and coordinates are expected here");
        contents_.add_node(tag);
        coordinates(stop);
      }
    } else {
      const Numbers head = numbers(4);
      for (long long b = 0; b < head[0]; ++b) {
        const long long n = numbers(4)[3];
        for (long long i = 0; i < n; ++i) contents_.add_node(numbers(1)[0]);
        for (long long i = 0; i < n; ++i) need_line(), coordinates(line_.data());
      }
      contents_.check_nodes(static_cast<unsigned long long>(head[1]), head[2], head[3]);
    }
    end_of("$EndNodes");
  }

  /// Checks an element whose nodes are the numbers from `first` on.
  void element(long long type, const Numbers& values, std::size_t first) {
    const std::size_t nodes = contents_.nodes_of(type);
    if (values.size() != first + nodes) fail(fmt::format("an element of type {} has {} nodes, here are {}: the line is wrong, or the file ends too early", type, nodes,
                                                         std::max(0LL, static_cast<long long>(values.size()) - static_cast<long long>(first))));
    for (std::size_t i = first; i < values.size(); ++i) contents_.check_use(values[i]);
  }

  void elements() {
    has_elements_ = true;
    if (version_ == "2.2") {
      for (long long n = numbers(1)[0]; n > 0; --n) {
        const Numbers values = numbers(3);
        if (values[2] > static_cast<long long>(values.size())) fail("the number of the element's tags is wrong");
        element(values[1], values, 3 + static_cast<std::size_t>(values[2]));
      }
    } else {
      const Numbers head = numbers(4);
      for (long long b = 0; b < head[0]; ++b) {
        const Numbers block = numbers(4);
        for (long long i = 0; i < block[3]; ++i) element(block[2], numbers(2), 1);
      }
    }
    end_of("$EndElements");
  }

  const std::string& path_;
  std::ifstream file_;
  std::string line_, version_;
  long long number_ = 0;
  MshContents contents_;
  bool has_elements_ = false;
};

}  // namespace

void check_msh(const std::string& path) {
  if (!std::filesystem::exists(path)) throw InputError(path + ": there is no such file");
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(path) || std::filesystem::file_size(path, ignored) == 0)
    throw InputError(path + ": is not a file, or is empty");
  MshText(path).check();
}

}  // namespace berm
