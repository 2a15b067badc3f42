#include "io/file.hpp"

#include <fmt/core.h>

#include <sys/stat.h>

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
  written_ += bytes.size();
}

void OutputFile::flush() {
  if (std::fflush(file_.get()) != 0) fail();
}

void OutputFile::check_unchanged() const {
  struct stat own, there;
  if (::fstat(::fileno(file_.get()), &own) != 0 || !S_ISREG(own.st_mode)) return;  // a device
  const bool same = ::stat(path_.c_str(), &there) == 0 && there.st_ino == own.st_ino && static_cast<std::uintmax_t>(own.st_size) >= written_;
  if (!same)
    throw RunError(fmt::format("{}: something else has removed, replaced or cut this file during the run: leave the folder alone until its end, or read copies; "
                               "--restart goes on from a checkpoint",
                               path_));
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
