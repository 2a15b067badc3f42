#include "io/log.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>

#include "base/error.hpp"

namespace berm {

Log::Log(const LogOptions& options)
    : terminal_(options.terminal),
      quiet_(options.quiet),
      interactive_(options.is_interactive ? *options.is_interactive : options.terminal && isatty(fileno(options.terminal)) == 1),
      file_(options.file.empty() ? nullptr : std::make_unique<OutputFile>(options.file, options.append)) {}

Log::~Log() {
  if (status_shown_) std::fputc('\n', terminal_);
}

void Log::info(std::string_view message) {
  if (!quiet_) to_terminal(message);
  to_file(message);
}

void Log::warning(std::string_view message) {
  const std::string line = fmt::format("warning: {}", message);
  to_terminal(line);
  to_file(line);
}

void Log::detail(std::string_view message) { to_file(message); }

void Log::status(std::string_view line) {
  if (quiet_ || !interactive_) return;
  fmt::print(terminal_, "\r\x1b[K\x1b[?7l{}\x1b[?7h", line);  // ?7l, ?7h: cut at the right edge rather than wrap
  std::fflush(terminal_);
  status_shown_ = true;
}

void Log::to_terminal(std::string_view line) {
  if (!terminal_) return;
  fmt::print(terminal_, "{}{}\n", status_shown_ ? "\r\x1b[K" : "", line);
  std::fflush(terminal_);
  status_shown_ = false;
}

void Log::to_file(std::string_view line) {
  if (!file_) return;
  try {
    file_->write(fmt::format("{}\n", line));
    file_->flush();
  } catch (const RunError& error) {
    file_.reset();
    warning(error.what());
  }
}

Progress::Progress(Log& log, Clock::time_point start) : log_(log), start_(start) {}

void Progress::update(const ProgressState& state, Clock::time_point now) {
  point_steps_ += static_cast<double>(state.points);
  const int tenths = static_cast<int>(std::floor(10.0 * state.time + 1e-9));
  const bool milestone = tenths > tenths_;
  const bool renew = log_.interactive() && (!shown_ || now - *shown_ >= std::chrono::milliseconds(200) || milestone);
  if (!milestone && !renew) return;

  const double elapsed = std::chrono::duration<double>(now - start_).count();
  const std::string left =
      state.time > 0.0 ? duration_text(elapsed * std::max(0.0, 1.0 - state.time) / state.time) : std::string("?");
  const std::string line =
      fmt::format("step {:5}  {:5.1f} %  {} left  load {:11.4e} N  iterations {:2}  residual {:.1e}  {:.3g} points/s",
                  state.step, 100.0 * state.time, left, state.load, state.newton_iterations, state.residual,
                  elapsed > 0.0 ? point_steps_ / elapsed : 0.0);
  if (renew) {
    log_.status(line);
    shown_ = now;
  }
  if (milestone) {
    if (log_.interactive())
      log_.detail(line);
    else
      log_.info(line);
    tenths_ = tenths;
  }
}

std::string duration_text(double seconds) {
  const long s = std::lround(std::ceil(seconds));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {} s", s / 60, s % 60);
  return fmt::format("{} h {} min", s / 3600, s % 3600 / 60);
}

}  // namespace berm
