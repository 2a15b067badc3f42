#pragma once
/// Which bytes are text in UTF-8.

#include <string>
#include <string_view>

namespace berm {

/// Bytes of the character that begins at k; 0: none does.
inline std::size_t utf8_length(std::string_view text, std::size_t k) {
  const auto byte = [&](std::size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const unsigned lead = byte(k);
  const std::size_t more = lead < 0x80 ? 0 : lead >= 0xC2 && lead < 0xE0 ? 1 : lead >= 0xE0 && lead < 0xF0 ? 2 : 3;
  if (more == 3 && (lead < 0xF0 || lead > 0xF4)) return 0;
  for (std::size_t i = 1; i <= more; ++i)
    if ((byte(k + i) & 0xC0u) != 0x80) return 0;
  return more + 1;
}

inline bool is_utf8(std::string_view text) {
  for (std::size_t k = 0; k < text.size();) {
    const std::size_t n = utf8_length(text, k);
    if (n == 0) return false;
    k += n;
  }
  return true;
}

/// Names of files may hold any bytes: U+FFFD in the place of those that are no text.
inline std::string as_text(std::string_view bytes) {
  std::string text;
  for (std::size_t k = 0; k < bytes.size();) {
    const std::size_t n = utf8_length(bytes, k);
    text += n == 0 ? "\xEF\xBF\xBD" : bytes.substr(k, n);
    k += n == 0 ? 1 : n;
  }
  return text;
}

}  // namespace berm
