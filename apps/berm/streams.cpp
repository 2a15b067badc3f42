#include "streams.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include "base/error.hpp"

void prepare_streams() {
  // Only read, so that words to a closed stream fail and are missed.
  for (const int fd : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (fcntl(fd, F_GETFD) < 0 && open("/dev/null", O_RDONLY) < 0) std::_Exit(1);
  for (const int number : {SIGPIPE, SIGXFSZ}) std::signal(number, SIG_IGN);
}

void say_error(const std::string& line) {
  std::fputs((line + "\n").c_str(), stderr);
  std::fflush(stderr);
}

int print_out(const std::string& text) {
  errno = 0;
  if (std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0) return 0;
  if (errno != EPIPE) say_error(fmt::format("berm: cannot write to standard output: {}", std::strerror(errno)));
  return 1;
}

std::string read_standard_input() {
  constexpr std::size_t most = 4'000'000;  // as src/case/load.cpp takes
  std::string text;
  char piece[65536];
  while (const std::size_t n = std::fread(piece, 1, sizeof piece, stdin)) {
    text.append(piece, n);
    if (text.size() > most) throw berm::InputError("stdin: is too large for a case");
  }
  if (std::ferror(stdin)) throw berm::InputError(fmt::format("stdin: cannot be read: {}", std::strerror(errno)));
  return text;
}
