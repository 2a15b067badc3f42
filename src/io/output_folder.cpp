#include "io/output_folder.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <fstream>
#include <iterator>
#include <string>
#include <utility>
#include <vector>

#include "base/error.hpp"
#include "base/system_file.hpp"

namespace berm {
namespace {

constexpr const char* lock_name = ".lock";

/// Whether the descriptor is still that of the file of this name: the run before may have removed it meanwhile.
bool is_there(int descriptor, const std::string& path) {
  struct stat held, there;
  return ::fstat(descriptor, &held) == 0 && ::lstat(path.c_str(), &there) == 0 && held.st_ino == there.st_ino;
}

/// Zero if there is none.
std::uintmax_t number_of(const std::filesystem::path& folder) {
  struct stat there;
  return ::stat(folder.c_str(), &there) == 0 ? there.st_ino : 0;
}

/// Empty if there is none; a pipe would never end.
std::string first_line(const std::filesystem::path& path) {
  std::string line;
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error)) return line;
  std::ifstream file(path);
  std::getline(file, line);
  return line;
}

/// Who holds the lock, as written into it.
std::string holder(const std::string& path) {
  const std::string words = first_line(path);
  return words.empty() ? words : " (" + words + ")";
}

/// Which the next run into the folder removes.
bool is_result(const std::string& name) {
  const bool frame = (name.ends_with(".vtu") || name.ends_with(".pvtu")) &&
                     (name.starts_with("points_") || name.starts_with("mesh_") || name.starts_with("surface_"));
  return frame || name == "summary.json" || name == "history.csv" || name == "checkpoint.h5" || name.ends_with(".pvd");
}

}  // namespace

FolderLock::FolderLock(const std::filesystem::path& folder) : file_(folder / lock_name), folder_number_(number_of(folder)) {
  const std::string path = file_.string();
  do {
    if (descriptor_ >= 0) ::close(descriptor_);
    descriptor_ = ::open(path.c_str(), O_CREAT | O_RDWR | O_NOFOLLOW | O_CLOEXEC, 0666);
    if (descriptor_ < 0) throw RunError(fmt::format("cannot write {}: {}", path, system_reason(errno)));
    if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0) continue;
    if (errno != EWOULDBLOCK) break;  // file systems of some clusters have no locks: nobody is kept out there
    ::close(std::exchange(descriptor_, -1));
    throw InputError(fmt::format("{}: another run is writing to this folder{}: wait for its end, or choose another folder with --out",
                                 folder.string(), holder(path)));
  } while (!is_there(descriptor_, path));
  const std::string words = fmt::format("process {} on {}\n", ::getpid(), host_name());
  // For the message of the other run; one without it serves too.
  if (::ftruncate(descriptor_, 0) != 0 || ::write(descriptor_, words.data(), words.size()) < 0) errno = 0;
}

FolderLock::FolderLock(FolderLock&& other) noexcept
    : file_(std::move(other.file_)), descriptor_(std::exchange(other.descriptor_, -1)), folder_number_(other.folder_number_) {}

FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(file_, other.file_);
  std::swap(descriptor_, other.descriptor_);
  std::swap(folder_number_, other.folder_number_);
  return *this;
}

bool FolderLock::has_folder() const { return descriptor_ < 0 || number_of(file_.parent_path()) == folder_number_; }

FolderLock::~FolderLock() {
  if (descriptor_ < 0) return;
  if (has_folder()) ::unlink(file_.c_str());
  ::close(descriptor_);
}

void refuse_finished(const std::filesystem::path& folder) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(folder / "summary.json", error)) return;  // a pipe would never end
  std::ifstream file(folder / "summary.json");
  const std::string text{std::istreambuf_iterator<char>(file), {}};
  // As io/summary.cpp writes it; in a quoted text quotes and line ends look otherwise.
  if (text.find("\n  \"status\": \"done\",\n") == std::string::npos) return;
  throw InputError(fmt::format("{}: holds the results of a run that came to its end: --force replaces them, --out chooses another folder",
                               folder.string()));
}

void refuse_foreign(const std::filesystem::path& folder) {
  if (first_line(folder / "log.txt").starts_with("berm ")) return;  // what every run writes first
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    std::error_code error;  // links that lead in a circle
    if (entry.is_directory(error)) continue;  // cannot be replaced
    if (is_result(name) || name == "log.txt" || name == "case.toml")
      throw InputError(fmt::format("{}: holds a file \"{}\" that is not of a run, and would be lost: choose another folder with --out", folder.string(), name));
  }
}

void remove_old_results(const std::filesystem::path& folder) {
  std::vector<std::filesystem::path> old;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!is_result(entry.path().filename().string())) continue;
    if (entry.is_directory(error))
      throw InputError(fmt::format("{}: a folder has the name of a result: move it away, or choose another folder with --out", entry.path().string()));
    old.push_back(entry.path());
  }
  for (const auto& path : old) std::filesystem::remove(path);
}

}  // namespace berm
