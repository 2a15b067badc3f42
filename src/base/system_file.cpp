#include "base/system_file.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <string_view>
#include <vector>

#include "base/error.hpp"

namespace berm {

int open_new_file(const std::string& path) {
  constexpr int flags = O_CREAT | O_WRONLY | O_NOFOLLOW | O_CLOEXEC;
  struct stat there;
  if (::lstat(path.c_str(), &there) == 0 && !S_ISREG(there.st_mode) && !S_ISLNK(there.st_mode) && !S_ISFIFO(there.st_mode))
    return ::open(path.c_str(), flags | O_TRUNC, 0666);
  if (::unlink(path.c_str()) != 0 && errno != ENOENT) return -1;
  return ::open(path.c_str(), flags | O_EXCL, 0666);
}

int open_to_append(const std::string& path) {
  // O_NONBLOCK: a named pipe without a reader is refused at once.
  return ::open(path.c_str(), O_CREAT | O_WRONLY | O_APPEND | O_NOFOLLOW | O_CLOEXEC | O_NONBLOCK, 0666);
}

void raise_limit_of_open_files(unsigned long needed) {
  rlimit limit{};
  if (getrlimit(RLIMIT_NOFILE, &limit) != 0 || limit.rlim_cur >= needed) return;
  limit.rlim_cur = std::min<rlim_t>(needed, limit.rlim_max);
  if (limit.rlim_cur < needed || setrlimit(RLIMIT_NOFILE, &limit) != 0)
    throw RunError(fmt::format("a run opens up to {} files, and this process may not have as many: raise its limit (ulimit -n)", needed));
}

const char* rank_of_launcher() {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMIX_RANK", "PMI_RANK"})
    if (const char* rank = std::getenv(name)) return rank;
  return nullptr;
}

bool is_first_process() {
  const char* rank = rank_of_launcher();
  return !rank || std::string_view(rank) == "0";
}

void forget_variables(const std::function<bool(std::string_view)>& is_such) {
  std::vector<std::string> names;
  for (char** variable = environ; *variable; ++variable)
    if (std::string name(*variable, std::strcspn(*variable, "=")); is_such(name)) names.push_back(std::move(name));
  for (const std::string& name : names) unsetenv(name.c_str());
}

namespace {

/// Only what a handler of signals may call.
void say_fault(int number) {
  const auto say = [](const char* words) { static_cast<void>(!::write(STDERR_FILENO, words, std::strlen(words))); };
  const char* name = sigdescr_np(number);
  say("berm: ");
  say(name ? name : "a fault");
  say(": a fault of the program, or of a library that it uses; please report it. If the output folder has a checkpoint.h5, --restart goes on from it\n");
  ::raise(number);  // SA_RESETHAND: as if nobody had caught it
}

}  // namespace

void say_faults() {
#ifdef __SANITIZE_ADDRESS__
  return;  // it says more
#endif
  static std::array<char, 65536> stack;  // that of the thread may be what has run out
  const stack_t other{.ss_sp = stack.data(), .ss_flags = 0, .ss_size = stack.size()};
  sigaltstack(&other, nullptr);
  struct sigaction action {};
  action.sa_handler = say_fault;
  action.sa_flags = SA_RESETHAND | SA_ONSTACK | SA_NODEFER;
  for (const int number : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGSYS, SIGTRAP}) sigaction(number, &action, nullptr);
}

std::string host_name() {
  char name[256] = "";
  ::gethostname(name, sizeof name - 1);
  return name;
}

std::string system_reason(int error) {
  const std::string words = std::strerror(error);
  switch (error) {
    case ENOSPC:
    case EDQUOT:
      return words + " (make room, or choose a folder elsewhere with --out)";
    case EFBIG:
      return words + " (for this file system or the limit of the shell: see ulimit -f)";
    case EACCES:
    case EPERM:
    case EROFS:
      return words + " (choose a folder that you may write to with --out)";
    case ELOOP:
      return words + " (remove the link: berm does not write through links)";
    default:
      return words;
  }
}

}  // namespace berm
