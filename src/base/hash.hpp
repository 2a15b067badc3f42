#pragma once
/// A number that stands for data: another one for other data, all but surely (FNV-1a).

#include <cstdint>
#include <string_view>

namespace berm {

class Hash {
public:
  void add(std::uint64_t value) { sum_ = (sum_ ^ value) * 1099511628211ull; }
  void add(std::string_view bytes) {
    for (const char byte : bytes) add(static_cast<std::uint64_t>(static_cast<unsigned char>(byte)));
  }
  std::uint64_t value() const { return sum_; }

private:
  std::uint64_t sum_ = 14695981039346656037ull;
};

}  // namespace berm
