#include "temporary_folder.hpp"

#include <fmt/format.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <string>

#include "base/error.hpp"
#include "streams.hpp"

namespace {

/// Bytes: several processes share memory there, in files of 4 MB.
std::uintmax_t needed_by(int processes) { return processes > 1 ? processes * std::uintmax_t(8'000'000) : 100'000; }

/// Why Open MPI cannot keep its files in the folder, or "".
std::string unfit(const std::string& folder, int processes) {
  std::string probe = folder + "/berm_XXXXXX";
  const int fd = mkstemp(probe.data());
  if (fd < 0) return std::strerror(errno);
  close(fd);
  unlink(probe.c_str());
  struct statvfs disk;
  if (statvfs(folder.c_str(), &disk) != 0) return std::strerror(errno);
  const std::uintmax_t room = std::uintmax_t(disk.f_bavail) * disk.f_frsize, needed = needed_by(processes);
  return room >= needed ? "" : fmt::format("{} MB left, {} are needed", room / 1'000'000, needed / 1'000'000);
}

/// Where Open MPI looks for the folder for temporary files, and in which order.
std::string temporary_folder() {
  for (const char* name : {"TMPDIR", "TEMP", "TMP"})
    if (const char* folder = std::getenv(name)) return folder;
  return "/tmp";
}

}  // namespace

void look_for_temporary_folder(int processes, const std::filesystem::path& out) {
  const std::string wanted = temporary_folder(), why = unfit(wanted, processes);
  if (why.empty()) return;
  std::error_code error;
  std::filesystem::create_directories(out, error);
  for (const std::string& folder : {std::string("/tmp"), std::string("/dev/shm"), std::filesystem::absolute(out).string()}) {
    if (!unfit(folder, processes).empty()) continue;
    say_error(fmt::format("berm: temporary files go to {}, since {} (TMPDIR) cannot take them: {}", folder, wanted, why));
    setenv("TMPDIR", folder.c_str(), 1);
    return;
  }
  throw berm::RunError(fmt::format("no folder for temporary files: {}: {}; set TMPDIR to one", wanted, why));
}
