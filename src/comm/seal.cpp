#include "comm/seal.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cerrno>
#include <cstdio>
#include <memory>
#include <system_error>
#include <vector>

namespace berm {
namespace {

using File = std::unique_ptr<std::FILE, int (*)(std::FILE*)>;

[[noreturn]] void fail(const std::string& path) { throw std::system_error(errno, std::generic_category(), path); }

File open_file(const std::string& path, const char* mode) {
  File file(std::fopen(path.c_str(), mode), &std::fclose);
  if (!file) fail(path);
  return file;
}

/// The words of the seal: length and CRC-32 of what follows it.
std::string seal_of(std::FILE* file, const std::string& path) {
  std::vector<unsigned char> piece(1 << 20);
  if (std::fseek(file, seal_size, SEEK_SET) != 0) fail(path);
  unsigned long crc = crc32(0L, Z_NULL, 0);
  long long length = 0;
  while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), file)) {
    crc = crc32_z(crc, piece.data(), n);
    length += static_cast<long long>(n);
  }
  if (std::ferror(file)) fail(path);
  return fmt::format("berm checkpoint: {} bytes follow, crc32 {:08x}\n", length, crc);
}

}  // namespace

void seal_file(const std::string& path) {
  std::string head = seal_of(open_file(path, "rb").get(), path);
  head.resize(seal_size, '\0');
  File file = open_file(path, "r+b");
  if (std::fwrite(head.data(), 1, head.size(), file.get()) != head.size() || std::fflush(file.get()) != 0) fail(path);
}

std::string broken_seal(const std::string& path) {
  const File file = open_file(path, "rb");
  std::string head(seal_size, '\0');
  head.resize(std::fread(head.data(), 1, head.size(), file.get()));
  if (!head.starts_with("berm checkpoint: ")) return "it has no checksum: it is something else, or of an earlier version of berm";
  std::string expected = seal_of(file.get(), path);
  expected.resize(seal_size, '\0');
  return head == expected ? "" : "its checksum does not fit: the file has changed since it was written, or is incomplete";
}

}  // namespace berm
