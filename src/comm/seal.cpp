#include "comm/seal.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cerrno>
#include <fstream>
#include <system_error>
#include <vector>

namespace berm {
namespace {

std::ifstream open_file(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::system_error(errno, std::generic_category(), path);
  return file;
}

std::string head_of(const std::string& path) {
  std::string head(seal_size, '\0');
  open_file(path).read(head.data(), seal_size);
  return head;
}

}  // namespace

std::string seal_of(const std::string& path) {
  std::ifstream file = open_file(path);
  std::vector<unsigned char> piece(1 << 20);
  unsigned long crc = crc32(0L, Z_NULL, 0);
  long long length = 0;
  file.seekg(seal_size);
  while (file) {
    file.read(reinterpret_cast<char*>(piece.data()), static_cast<std::streamsize>(piece.size()));
    crc = crc32_z(crc, piece.data(), static_cast<std::size_t>(file.gcount()));
    length += file.gcount();
  }
  if (!file.eof()) throw std::system_error(errno, std::generic_category(), path);
  std::string words = fmt::format("berm checkpoint: {} bytes follow, crc32 {:08x}\n", length, crc);
  words.resize(seal_size, '\0');
  return words;
}

std::string broken_seal(const std::string& path) {
  const std::string head = head_of(path);
  if (!head.starts_with("berm checkpoint: ")) return "it has no checksum: it is something else, or of an earlier version of berm";
  return head == seal_of(path) ? "" : "its checksum does not fit: the file has changed since it was written, or is incomplete";
}

}  // namespace berm
