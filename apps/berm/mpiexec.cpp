#include "mpiexec.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <string_view>

#include "base/error.hpp"
#include "base/system_file.hpp"
#include "streams.hpp"

namespace {

using berm::InputError;
using berm::raise_limit_of_open_files;
using berm::RunError;

constexpr int failed = 1;
/// Even those who share cores on purpose get no more processes than so many a core.
constexpr int most_per_core = 64;
/// Open MPI shares memory in files of 4 MB.
constexpr rlim_t largest_file = 8'000'000;
/// Set for the processes below mpiexec if the user sees a terminal.
constexpr const char* terminal_variable = "BERM_TERMINAL";

/// Set for the processes below mpiexec: the first one shall say when signals end the run in order.
constexpr const char* ready_variable = "BERM_SAY_READY";
constexpr std::string_view ready_line = "\x1e" "berm listens to signals\n";
constexpr std::string_view begun_line = "\x1e" "berm has begun\n";

/// The last words shall be ours, not mpiexec's about an exit code.
constexpr const char* quiet_variable = "OMPI_MCA_orte_execute_quiet";

/// Signals that end a run in order, with a checkpoint.
constexpr std::array passed_on = {SIGINT, SIGTERM, SIGUSR1, SIGHUP, SIGXCPU};
volatile pid_t mpiexec = 0;
volatile std::sig_atomic_t signals = 0, ready = 0;

/// mpiexec itself would leave the processes one second, or whatever odls_base_sigkill_timeout says, but wait that long
/// before it tells them anything too. While it starts them, signals are lost or end them without a word: the first one waits.
void pass_on(int) {
  const int error = errno;
  signals = signals + 1;
  if (signals > 1)
    kill(mpiexec, SIGTERM);
  else if (ready)
    kill(mpiexec, SIGUSR1);
  errno = error;
}

/// The processes listen: a signal that has come before is for them.
void become_ready() {
  sigset_t ours, before;
  sigemptyset(&ours);
  for (const int number : passed_on) sigaddset(&ours, number);
  sigprocmask(SIG_BLOCK, &ours, &before);
  ready = 1;
  if (signals == 1) kill(mpiexec, SIGUSR1);
  sigprocmask(SIG_SETMASK, &before, nullptr);
}

void handle(int number) {
  struct sigaction action {};
  action.sa_handler = pass_on;
  sigaction(number, &action, nullptr);
}

/// Those that this process may use.
int cores() {
  cpu_set_t set;
  return sched_getaffinity(0, sizeof set, &set) == 0 ? CPU_COUNT(&set) : static_cast<int>(sysconf(_SC_NPROCESSORS_ONLN));
}

/// Whether the PATH leads to mpiexec.
bool finds_mpiexec() {
  const char* path = std::getenv("PATH");
  const std::string folders = path ? path : "";
  for (std::size_t begin = 0; begin <= folders.size();) {
    const std::size_t end = std::min(folders.find(':', begin), folders.size());
    const std::string folder = end > begin ? folders.substr(begin, end - begin) : ".";
    if (access((folder + "/mpiexec").c_str(), X_OK) == 0) return true;
    begin = end + 1;
  }
  return false;
}

void look_for_mpiexec() {
  if (finds_mpiexec()) return;
  const char* path = std::getenv("PATH");
  const std::string usual = "/usr/local/bin:/usr/bin:/bin";
  setenv("PATH", (path && *path ? std::string(path) + ":" + usual : usual).c_str(), 1);
  if (!finds_mpiexec())
    throw RunError(fmt::format("cannot find mpiexec in PATH ({}): install openmpi-bin, or add its folder", std::getenv("PATH")));
}

void check_limit_of_files() {
  rlimit limit;
  if (getrlimit(RLIMIT_FSIZE, &limit) == 0 && limit.rlim_cur < largest_file)
    throw RunError(fmt::format("files may have {} bytes only, {} are needed for several processes: see ulimit -f", limit.rlim_cur,
                               largest_file));
}

/// A file without a name that holds the text.
int file_of(const std::string& text) {
  const int fd = memfd_create("berm", MFD_CLOEXEC);
  if (fd < 0 || write(fd, text.data(), text.size()) != static_cast<ssize_t>(text.size()) || lseek(fd, 0, SEEK_SET) != 0)
    throw RunError(fmt::format("cannot hand standard input on: {}", std::strerror(errno)));
  return fd;
}

/// Hands on what mpiexec prints. mpiexec itself ends a run whose reader has gone; from here on the words are then lost, and the
/// log has them.
class Output {
public:
  void add(std::string_view words) {
    if (ready) return write_out(words);
    kept_ += words;
    begun_ = take_out(begun_line) || begun_;
    if (!take_out(ready_line)) return;
    become_ready();
    end();
  }
  void end() {
    write_out(kept_);
    kept_.clear();
  }
  /// Whether a process of berm's got through the start of MPI.
  bool begun() const { return begun_; }

private:
  bool take_out(std::string_view line) {
    const std::size_t at = kept_.find(line);
    if (at == std::string::npos) return false;
    kept_.erase(at, line.size());
    return true;
  }
  void write_out(std::string_view words) {
    while (heard_ && !words.empty()) {
      const ssize_t n = write(STDOUT_FILENO, words.data(), words.size());
      if (n >= 0) words.remove_prefix(static_cast<std::size_t>(n));
      heard_ = n >= 0 || errno == EINTR;
      if (!heard_ && errno != EPIPE)
        say_error(fmt::format("berm: the terminal takes no more words ({}): the rest is in the log", std::strerror(errno)));
    }
  }

  bool heard_ = true, begun_ = false;
  std::string kept_;  ///< what was said before the processes were ready
};

/// True if a process has begun.
bool pass_on_words(int from) {
  char piece[65536];
  Output words;
  for (;;) {
    const ssize_t n = read(from, piece, sizeof piece);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    words.add({piece, static_cast<std::size_t>(n)});
  }
  words.end();
  return words.begun();
}

/// `input` in the place of standard input: a group in the background is stopped when it reads a terminal.
[[noreturn]] void become_mpiexec(std::vector<std::string> words, int input, int output) {
  setpgid(0, 0);  // Ctrl-C in a terminal reaches the whole group: this one must hear of it from us alone
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  dup2(input, STDIN_FILENO);
  dup2(output, STDOUT_FILENO);
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  execvp("mpiexec", argv.data());
  say_error(fmt::format("berm: cannot start mpiexec: {}", std::strerror(errno)));
  std::_Exit(failed);
}

/// mpiexec ends with 128 and the number of the signal that has ended one of its processes.
int exit_code_of(int status) {
  constexpr int of_signals = 128, largest_of_berm = 2;
  const int code = WIFEXITED(status) ? WEXITSTATUS(status) : of_signals + WTERMSIG(status);
  if (code <= largest_of_berm) return code;
  if (const int number = code - of_signals; signals < 2)  // who has sent two knows why
    say_error(number <= 0 || number >= NSIG
                  ? fmt::format("berm: mpiexec has ended with code {}", code)
                  : fmt::format("berm: one of the processes was ended by signal {} ({}){}. If the output folder has a checkpoint.h5, --restart goes on from it", number,
                                strsignal(number), number == SIGKILL ? ", as happens where memory runs out" : ""));
  return failed;
}

void say_to_parent(std::string_view line) {
  if (!std::getenv(ready_variable)) return;
  std::fwrite(line.data(), 1, line.size(), stdout);
  std::fflush(stdout);
}

/// Of Open MPI, as the user has set them: "A=1, B=2".
std::string settings_of_mpi() {
  std::string all;
  for (char** entry = environ; *entry; ++entry)
    if (const std::string_view word = *entry; berm::is_setting_of_mpi(word)) all += fmt::format("{}{}", all.empty() ? "" : ", ", word);
  return all;
}

/// Open MPI's own words are left out (quiet_variable), also where it cannot start.
void say_not_begun(const std::string& settings) {
  const bool told = settings.find(quiet_variable) != settings.npos;
  say_error(fmt::format("berm: Open MPI has not started the processes{}{}", told ? "" : fmt::format(". The same with {}=0 in the environment shows why", quiet_variable),
                        settings.empty() ? "" : fmt::format("; the environment holds {}", settings)));
}

}  // namespace

int ranks_of_launcher() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* size = std::getenv(name)) return std::atoi(size);
  return 1;
}

void say_begun() { say_to_parent(begun_line); }
void say_ready() { say_to_parent(ready_line); }

bool user_sees_terminal() { return std::getenv(terminal_variable) != nullptr; }

std::string own_path() { return std::filesystem::read_symlink("/proc/self/exe").string(); }

void check_processes(int ranks, bool oversubscribe) {
  const int n = cores();
  if (ranks > n && !oversubscribe)
    throw InputError(fmt::format("-n {}: this machine has {} core{} for berm, and processes that share one wait for each other: "
                                 "take -n {}, or --oversubscribe to have it so",
                                 ranks, n, n > 1 ? "s" : "", n));
  if (ranks > most_per_core * n)
    throw InputError(fmt::format("-n {}: not more than {} processes, {} a core", ranks, most_per_core * n, most_per_core));
}

int run_under_mpiexec(int ranks, const std::vector<std::string>& arguments, const std::string& input) {
  look_for_mpiexec();
  check_limit_of_files();
  raise_limit_of_open_files(64 + 16 * static_cast<unsigned long>(ranks));  // mpiexec waits for ever where it has too few for its pipes
  const std::string settings = settings_of_mpi();
  // Root may run a program with mpiexec as well as without (containers, CI); more processes than cores are the user's
  // choice.
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 0);
  setenv(quiet_variable, "1", 0);
  setenv(ready_variable, "1", 1);
  if (isatty(STDOUT_FILENO) == 1) setenv(terminal_variable, "1", 1);
  std::vector<std::string> words = {"mpiexec", "-n", std::to_string(ranks), own_path()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const int text = file_of(input);
  int out[2];
  if (pipe2(out, O_CLOEXEC) != 0) throw RunError(fmt::format("cannot start mpiexec: {}", std::strerror(errno)));
  const pid_t child = fork();
  if (child == 0) become_mpiexec(std::move(words), text, out[1]);
  close(text);
  close(out[1]);
  if (child < 0) {
    say_error("berm: cannot start mpiexec: no process left");
    return failed;
  }
  mpiexec = child;
  for (const int number : passed_on)
    if (number != SIGHUP || std::signal(SIGHUP, SIG_IGN) != SIG_IGN) handle(number);  // else: nohup
  const bool begun = pass_on_words(out[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (!begun && status != 0 && signals == 0) say_not_begun(settings);
  return exit_code_of(status);
}
