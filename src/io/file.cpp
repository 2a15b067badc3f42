#include "io/file.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "base/error.hpp"

namespace berm {

OutputFile::OutputFile(std::string path, bool append)
    : path_(std::move(path)), file_(std::fopen(path_.c_str(), append ? "ab" : "wb")) {
  if (!file_) fail();
}

void OutputFile::write(std::string_view bytes) {
  if (std::fwrite(bytes.data(), 1, bytes.size(), file_.get()) != bytes.size()) fail();
}

void OutputFile::flush() {
  if (std::fflush(file_.get()) != 0) fail();
}

void OutputFile::close() {
  if (std::fclose(file_.release()) != 0) fail();
}

void OutputFile::fail() const { throw RunError(fmt::format("cannot write {}: {}", path_, std::strerror(errno))); }

void replace_file(const std::string& path, std::string_view content) {
  const std::string draft = path + ".tmp";
  OutputFile file(draft);
  file.write(content);
  file.close();
  if (std::rename(draft.c_str(), path.c_str()) != 0) {
    const int reason = errno;
    std::remove(draft.c_str());
    throw RunError(fmt::format("cannot write {}: {}", path, std::strerror(reason)));
  }
}

}  // namespace berm
