/// The nodes and elements of binary .msh files, before Gmsh reads them.

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>

#include "base/error.hpp"
#include "mesh/msh_contents.hpp"

namespace berm {
namespace {

class MshBytes {
public:
  MshBytes(const std::string& path, std::string content, bool old)
      : path_(path), content_(std::move(content)), old_(old), contents_([this](const std::string& what) { fail(what); }) {}

  void check() {
    check_byte_order();
    go_to("$Nodes");
    old_ ? nodes_of_2() : nodes_of_4();
    end_of("$EndNodes");
    if (!contents_.has_nodes()) fail("has no nodes");
    go_to("$Elements");
    old_ ? elements_of_2() : elements_of_4();
    end_of("$EndElements");
  }

private:
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(fmt::format("{}: byte {}: {} (save it again, or as text)", path_, at_, what));
  }

  std::string rest_of_line() {
    const std::size_t end = content_.find('\n', at_);
    if (end == std::string::npos) fail("the file ends too early");
    std::string line = content_.substr(at_, end - at_);
    at_ = end + 1;
    if (line.ends_with('\r')) line.pop_back();
    return line;
  }

  /// After the line with that word: no number of a file looks like it.
  void go_to(const std::string& word) {
    at_ = content_.find("\n" + word, at_);
    if (at_ == std::string::npos) {
      at_ = content_.size();
      fail(word + " is missing");
    }
    ++at_;
    rest_of_line();
  }

  void end_of(const std::string& word) {
    at_ = std::min(content_.find_first_not_of("\r\n", at_), content_.size());
    if (content_.compare(at_, word.size(), word) != 0) fail(word + " is expected here (the counts before are wrong)");
    at_ -= 1;  // so that the next section begins behind an end of a line
  }

  template <class T>
  T take() {
    if (content_.size() - at_ < sizeof(T)) fail("the file ends too early");
    T value;
    std::memcpy(&value, content_.data() + at_, sizeof value);
    at_ += sizeof value;
    return value;
  }
  long long take_int() { return take<std::int32_t>(); }
  unsigned long long take_size() { return take<std::uint64_t>(); }

  /// A count of things that take that many bytes at least.
  unsigned long long counted(unsigned long long count, std::size_t bytes) const {
    if (count > (content_.size() - at_) / bytes) fail(fmt::format("{} entries do not fit into the file", count));
    return count;
  }

  void skip(std::size_t bytes) { at_ += counted(bytes, 1); }

  void check_byte_order() {
    rest_of_line();
    const std::string format = rest_of_line();
    if (!format.ends_with(" 8")) fail("data of other than 8 bytes are not supported");
    if (take_int() != 1) fail("the bytes are in another order than on this machine");
  }

  void nodes_of_2() {
    for (unsigned long long n = text_count(28); n > 0; --n) {
      contents_.add_node(take_int());
      skip(24);
    }
  }

  unsigned long long text_count(std::size_t bytes) {
    const std::string line = rest_of_line();
    if (line.empty() || line.size() > 12 || line.find_first_not_of("0123456789") != std::string::npos) fail("a count is expected here");
    return counted(std::stoull(line), bytes);
  }

  void nodes_of_4() {
    const unsigned long long blocks = take_size(), announced = take_size();
    const auto first = static_cast<long long>(take_size()), last = static_cast<long long>(take_size());
    for (unsigned long long b = 0; b < blocks; ++b) {
      const long long dimension = take_int();
      take_int();
      const long long parameters = take_int();
      if (dimension < 0 || dimension > 3 || parameters < 0 || parameters > 1) fail("a block of nodes is expected here");
      const std::size_t place = 24 + 8 * static_cast<std::size_t>(parameters * dimension);
      const unsigned long long n = counted(take_size(), 8 + place);
      for (unsigned long long i = 0; i < n; ++i) contents_.add_node(static_cast<long long>(take_size()));
      skip(n * place);
    }
    contents_.check_nodes(announced, first, last);
  }

  void elements_of_2() {
    for (unsigned long long left = text_count(8); left > 0;) {
      const long long type = take_int(), n = take_int(), tags = take_int();
      const std::size_t nodes = contents_.nodes_of(type);
      if (n < 1 || static_cast<unsigned long long>(n) > left || tags < 0 || tags > 100) fail("a block of elements is expected here");
      left -= n;
      for (long long i = 0; i < n; ++i) {
        skip(4 + 4 * static_cast<std::size_t>(tags));
        for (std::size_t k = 0; k < nodes; ++k) contents_.check_use(take_int());
      }
    }
  }

  void elements_of_4() {
    const unsigned long long blocks = take_size(), announced = take_size();
    skip(16);
    unsigned long long sum = 0;
    for (unsigned long long b = 0; b < blocks; ++b) {
      skip(8);
      const std::size_t nodes = contents_.nodes_of(take_int());
      const unsigned long long n = counted(take_size(), 8 + 8 * nodes);
      sum += n;
      for (unsigned long long i = 0; i < n; ++i) {
        skip(8);
        for (std::size_t k = 0; k < nodes; ++k) contents_.check_use(static_cast<long long>(take_size()));
      }
    }
    if (sum != announced) fail("the number of elements is not the one announced");
  }

  const std::string& path_;
  std::string content_;
  bool old_;
  MshContents contents_;
  std::size_t at_ = 0;
};

}  // namespace

void check_binary_msh(const std::string& path, bool old) {
  std::ifstream file(path, std::ios::binary);
  MshBytes(path, {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()}, old).check();
}

}  // namespace berm
