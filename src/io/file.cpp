#include "io/file.hpp"

#include <fmt/core.h>

#include <cerrno>
#include <utility>

#include "base/error.hpp"
#include "base/system_file.hpp"

namespace berm {

OutputFile::OutputFile(std::string path, bool append)
    : path_(std::move(path)) {
  const int descriptor = append ? open_to_append(path_) : open_new_file(path_);
  if (descriptor < 0) fail();
  file_.reset(::fdopen(descriptor, append ? "ab" : "wb"));
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

void OutputFile::fail() const { throw RunError(fmt::format("cannot write {}: {}", path_, system_reason(errno))); }

void replace_file(const std::string& path, std::string_view content) {
  const std::string draft = path + ".tmp";
  try {
    OutputFile file(draft);
    file.write(content);
    file.close();
    if (std::rename(draft.c_str(), path.c_str()) != 0)
      throw RunError(fmt::format("cannot write {}: {}", path, system_reason(errno)));
  } catch (const RunError&) {
    std::remove(draft.c_str());
    throw;
  }
}

}  // namespace berm
