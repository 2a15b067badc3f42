#include "io/log.hpp"

#include <fmt/core.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <iterator>

#include "base/error.hpp"

namespace berm {

Log::Log(const LogOptions& options)
    : terminal_(options.terminal),
      quiet_(options.quiet),
      interactive_(options.is_interactive ? *options.is_interactive : options.terminal && isatty(fileno(options.terminal)) == 1),
      file_(options.file.empty() ? nullptr : std::make_unique<OutputFile>(options.file, options.append)) {}

Log::~Log() {
  if (status_shown_) write_terminal("\n");
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
  write_terminal(fmt::format("\r\x1b[K\x1b[?7l{}\x1b[?7h", line));  // ?7l, ?7h: cut at the right edge rather than wrap
  status_shown_ = terminal_ != nullptr;
}

void Log::to_terminal(std::string_view line) {
  write_terminal(fmt::format("{}{}\n", status_shown_ ? "\r\x1b[K" : "", line));
  status_shown_ = false;
}

void Log::write_terminal(const std::string& text) {
  if (!terminal_) return;
  if (std::fwrite(text.data(), 1, text.size(), terminal_) == text.size() && std::fflush(terminal_) == 0) return;
  const int reason = errno;
  terminal_ = nullptr;
  const std::string words = fmt::format("the terminal takes no more words ({}): the rest is in the log", std::strerror(reason));
  to_file("warning: " + words);
  if (reason != EPIPE) std::fprintf(stderr, "berm: %s\n", words.c_str());  // a reader that has gone knows it
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

void Pace::add(double seconds, double share) {
  constexpr double fineness = 1.002;  // keeps the list short: the last one stays only if it is that far from the one before
  if (const std::size_t n = samples_.size(); n > 1 && samples_[n - 1].seconds < fineness * samples_[n - 2].seconds)
    samples_.pop_back();
  samples_.push_back({seconds, share});
}

double Pace::left_from(std::size_t k) const {
  if (!samples_.empty() && samples_.back().share >= 1.0) return 0.0;
  if (k >= samples_.size() || samples_.back().share <= samples_[k].share) return -1.0;
  const Sample &then = samples_[k], &now = samples_.back();
  return (now.seconds - then.seconds) * std::max(0.0, 1.0 - now.share) / (now.share - then.share);
}

double Pace::left() const {
  if (samples_.empty()) return -1.0;
  const double middle = 0.5 * (samples_.front().seconds + samples_.back().seconds);
  const auto after = std::upper_bound(samples_.begin(), samples_.end(), middle,
                                      [](double t, const Sample& s) { return t < s.seconds; });
  return left_from(after == samples_.begin() ? 0 : after - samples_.begin() - 1);
}

double Pace::left_by_mean() const { return left_from(0); }

Progress::Progress(Log& log, Clock::time_point start) : log_(log), start_(start), told_(start) {}

void Progress::update(const ProgressState& state, Clock::time_point now) {
  point_steps_ += static_cast<double>(state.points);
  const double elapsed = std::chrono::duration<double>(now - start_).count();
  pace_.add(elapsed, state.share);
  const int tenths = static_cast<int>(std::floor(10.0 * state.share + 1e-9));
  const bool milestone = tenths > tenths_ || (!log_.interactive() && now - told_ >= std::chrono::seconds(5));
  const bool renew = log_.interactive() && (!shown_ || now - *shown_ >= std::chrono::milliseconds(200) || milestone);
  if (!milestone && !renew) return;

  // Cracks slow a run for a while: the pace among them is no measure of what comes after, nor that before them.
  const double seconds = state.may_slow ? std::min(pace_.left(), pace_.left_by_mean()) : pace_.left();
  const std::string left = seconds >= 0.0 ? (state.may_slow && seconds > 0.0 ? "at least " : "") + duration_text(seconds) : std::string("?");
  const std::string line =
      fmt::format("step {:5}  {:5.1f} %  {} left  load {:11.4e} N  iterations {:2}  residual {:.1e}  {:.3g} points/s",
                  state.step, 100.0 * state.share, left, state.load, state.newton_iterations, state.residual,
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
    told_ = now;
  }
}

std::string duration_text(double seconds) {
  constexpr double ages = 1e12;
  if (!(seconds < ages)) return "ages";
  const long s = std::lround(std::ceil(seconds));
  if (s < 60) return fmt::format("{} s", s);
  if (s < 3600) return fmt::format("{} min {} s", s / 60, s % 60);
  return fmt::format("{} h {} min", s / 3600, s % 3600 / 60);
}

}  // namespace berm
