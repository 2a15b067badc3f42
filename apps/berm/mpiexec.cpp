#include "mpiexec.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdlib>
#include <filesystem>

namespace {

constexpr int failed = 1;
/// Set for the processes below mpiexec if the user sees a terminal.
constexpr const char* terminal_variable = "BERM_TERMINAL";

volatile pid_t mpiexec = 0;
volatile std::sig_atomic_t signals = 0;

/// mpiexec itself would leave the processes one second, or whatever odls_base_sigkill_timeout says, but wait that long
/// before it tells them anything too.
void pass_on(int) {
  const int error = errno;
  signals = signals + 1;
  kill(mpiexec, signals == 1 ? SIGUSR1 : SIGTERM);
  errno = error;
}

void handle(int number) {
  struct sigaction action {};
  action.sa_handler = pass_on;
  sigaction(number, &action, nullptr);
}

[[noreturn]] void become_mpiexec(std::vector<std::string> words) {
  setpgid(0, 0);  // Ctrl-C in a terminal reaches the whole group: this one must hear of it from us alone
  prctl(PR_SET_PDEATHSIG, SIGTERM);
  dup2(open("/dev/null", O_RDONLY), STDIN_FILENO);  // a group in the background is stopped when it reads a terminal
  std::vector<char*> argv;
  for (std::string& w : words) argv.push_back(w.data());
  argv.push_back(nullptr);
  execvp("mpiexec", argv.data());
  fmt::print(stderr, "berm: cannot start mpiexec: install openmpi-bin\n");
  std::_Exit(failed);
}

}  // namespace

int ranks_of_launcher() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* size = std::getenv(name)) return std::atoi(size);
  return 1;
}

bool user_sees_terminal() { return std::getenv(terminal_variable) != nullptr; }

int run_under_mpiexec(int ranks, const std::vector<std::string>& arguments) {
  // Root may run a program with mpiexec as well as without (containers, CI); more processes than cores are the user's
  // choice; the last words are ours, not mpiexec's about an exit code.
  setenv("OMPI_ALLOW_RUN_AS_ROOT", "1", 0);
  setenv("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1", 0);
  setenv("OMPI_MCA_rmaps_base_oversubscribe", "1", 0);
  setenv("OMPI_MCA_orte_execute_quiet", "1", 0);
  if (isatty(STDOUT_FILENO) == 1) setenv(terminal_variable, "1", 1);
  std::vector<std::string> words = {"mpiexec", "-n", std::to_string(ranks),
                                    std::filesystem::read_symlink("/proc/self/exe").string()};
  words.insert(words.end(), arguments.begin(), arguments.end());
  const pid_t child = fork();
  if (child == 0) become_mpiexec(std::move(words));
  if (child < 0) {
    fmt::print(stderr, "berm: cannot start mpiexec: no process left\n");
    return failed;
  }
  mpiexec = child;
  handle(SIGINT);
  handle(SIGTERM);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  return WIFEXITED(status) ? WEXITSTATUS(status) : failed;
}
