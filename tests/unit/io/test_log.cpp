#include <algorithm>

#include "io/log.hpp"
#include "temporary_folder.hpp"

namespace berm {
namespace {

using std::chrono::milliseconds;

class LogFile : public TemporaryFolder {
protected:
  /// What a "terminal" saw while `use` ran.
  template <class Use>
  std::string seen(bool interactive, bool quiet, Use use) {
    std::FILE* terminal = std::fopen(path("terminal").c_str(), "wb");
    {
      Log log({path("log.txt"), quiet, terminal, interactive});
      use(log);
    }
    std::fclose(terminal);
    return content(path("terminal"));
  }
  std::string log_text() const { return content(path("log.txt")); }

  static long lines(const std::string& text) { return std::count(text.begin(), text.end(), '\n'); }
};

TEST_F(LogFile, MessagesGoToBoth) {
  const std::string terminal = seen(false, false, [](Log& log) {
    log.info("one");
    log.warning("two");
    log.detail("three");
    log.status("not a terminal");
  });
  EXPECT_EQ(terminal, "one\nwarning: two\n");
  EXPECT_EQ(log_text(), "one\nwarning: two\nthree\n");
}

TEST_F(LogFile, QuietKeepsWarningsAndTheFile) {
  const std::string terminal = seen(true, true, [](Log& log) {
    log.info("one");
    log.warning("two");
    log.status("three");
  });
  EXPECT_EQ(terminal, "warning: two\n");
  EXPECT_EQ(log_text(), "one\nwarning: two\n");
}

TEST_F(LogFile, MessageRemovesTheStatusLine) {
  const std::string terminal = seen(true, false, [](Log& log) {
    log.status("busy");
    log.info("message");
    log.info("another");
  });
  EXPECT_EQ(terminal, "\r\x1b[K\x1b[?7lbusy\x1b[?7h\r\x1b[Kmessage\nanother\n");
}

TEST_F(LogFile, PlainProgressIsOneLineEveryTenPercent) {
  const std::string terminal = seen(false, false, [](Log& log) {
    const auto start = Progress::Clock::now();
    Progress progress(log, start);
    for (int i = 0; i <= 300; ++i) progress.update({i, i / 300.0, 1e6, 3, 1e-9, 1000}, start + milliseconds(100 * i));
  });
  EXPECT_EQ(lines(terminal), 10);
  EXPECT_EQ(terminal, log_text());
  const std::string first = terminal.substr(0, terminal.find('\n'));
  // Step 30 of 300 after 3 s: 31 updates of 1000 points, nine tenths of the run to go.
  EXPECT_EQ(first,
            "step    30   10.0 %  27 s left  load  1.0000e+06 N  iterations  3  residual 1.0e-09  1.03e+04 points/s");
}

TEST_F(LogFile, SlowRunsHaveALineEveryFiveSeconds) {
  const std::string terminal = seen(false, false, [](Log& log) {
    const auto start = Progress::Clock::now();
    Progress progress(log, start);
    for (int i = 0; i <= 60; ++i) progress.update({i, i * 1e-4, 0.0, 1, 0.0, 1}, start + milliseconds(1000 * i));
  });
  EXPECT_EQ(lines(terminal), 12);
}

TEST_F(LogFile, TerminalThatTakesNoWordsIsNoReasonToEnd) {
  std::FILE* full = std::fopen("/dev/full", "wb");
  if (!full) GTEST_SKIP() << "this system has no /dev/full";
  {
    Log log({path("log.txt"), false, full, true});
    log.info("one");
    log.status("busy");
    log.info("two");
  }
  std::fclose(full);
  EXPECT_EQ(log_text(), "warning: the terminal takes no more words (No space left on device): the rest is in the log\none\ntwo\n");
}

/// Steps that become ten times as small half-way: a tenth of the way behind that the pace is the new one.
TEST(TimeLeft, FollowsThePace) {
  Pace pace;
  double seconds = 0.0;
  for (double share = 0.0; share < 0.5; share += 1e-3) pace.add(seconds += 0.1, share);
  EXPECT_NEAR(pace.left(), 50.0, 1.0);
  for (double share = 0.5; share < 0.6; share += 1e-4) pace.add(seconds += 0.1, share);
  EXPECT_NEAR(pace.left(), 400.0, 10.0);
}

/// Cracks: a twentieth of the way takes as long as all that was before it, what comes after is quick again.
TEST(TimeLeft, OfTheMeanPaceForgetsNothing) {
  Pace pace;
  double seconds = 0.0;
  for (double share = 0.0; share < 0.5; share += 1e-3) pace.add(seconds += 0.1, share);
  for (double share = 0.5; share < 0.55; share += 1e-4) pace.add(seconds += 0.1, share);
  EXPECT_NEAR(pace.left_by_mean(), 100.0 * 0.45 / 0.55, 1.0);
  EXPECT_GT(pace.left(), 400.0);
}

TEST(TimeLeft, IsNotKnownAtFirst) {
  Pace pace;
  EXPECT_LT(pace.left(), 0.0);
  pace.add(3.0, 0.4);  // goes on from a checkpoint
  EXPECT_LT(pace.left(), 0.0);
  pace.add(4.0, 0.5);
  EXPECT_NEAR(pace.left(), 5.0, 1e-9);
}

TEST_F(LogFile, InteractiveProgressIsThrottled) {
  const std::string terminal = seen(true, false, [](Log& log) {
    const auto start = Progress::Clock::now();
    Progress progress(log, start);
    for (int i = 0; i < 1000; ++i) progress.update({i, i * 1e-5, 0.0, 1, 0.0, 1}, start + milliseconds(i));
  });
  EXPECT_EQ(std::count(terminal.begin(), terminal.end(), '\r'), 5);
  EXPECT_EQ(lines(terminal), 1);  // the line end when the log closes
}

TEST(Duration, ReadsWell) {
  EXPECT_EQ(duration_text(0.2), "1 s");
  EXPECT_EQ(duration_text(200.0), "3 min 20 s");
  EXPECT_EQ(duration_text(7500.0), "2 h 5 min");
}

}  // namespace
}  // namespace berm
