#include "comm/hdf5_file.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <csignal>
#include <filesystem>
#include <fstream>
#include <limits>

#include "../io/temporary_folder.hpp"
#include "base/error.hpp"

namespace berm {
namespace {

namespace fs = std::filesystem;

class Checkpoint : public TemporaryFolder {
protected:
  const std::string file = path("run.h5");

  void write(double value) const {
    auto out = CheckpointFile::create(Comm(), file);
    out.write("points/x", std::vector<double>(1000, value), 2);
    out.commit();
  }

  /// The message of the InputError that opening the file throws.
  std::string refusal() const {
    try {
      CheckpointFile::open(Comm(), file);
    } catch (const InputError& e) {
      return e.what();
    }
    return "";
  }
};

template <class F>
std::string input_error(F f) {
  try {
    f();
  } catch (const InputError& e) {
    return e.what();
  }
  return "";
}

TEST_F(Checkpoint, ReturnsWhatWasWritten) {
  const std::vector<double> x{0.1, -1e-310, std::numeric_limits<double>::infinity(), 4.0, 5.0, 6.0};
  const std::vector<std::int64_t> id{1LL << 62, -5};
  const std::vector<std::int32_t> cell{7};
  const std::vector<std::uint8_t> flag{0, 255, 3};
  std::string text = "line\n\xc3\xa9";
  text.resize(100000, 'x');  // longer than an attribute may be
  {
    auto out = CheckpointFile::create(Comm(), file);
    out.write("points/state/x", x, 3);
    out.write("points/id", id);
    out.write("cell", cell);
    out.write("flag", flag);
    out.write("points/none", std::vector<double>{}, 9);
    out.write_text("case", text);
    out.write_text("empty", "");
    out.write_number("time", 0.1);
    for (int i = 0; i < 100; ++i) out.write_number("number" + std::to_string(i), i);
    out.commit();
  }
  EXPECT_FALSE(fs::exists(file + ".part"));
  const auto in = CheckpointFile::open(Comm(), file);
  EXPECT_EQ(in.rows("points/state/x"), 2);
  EXPECT_EQ(in.read_rows<double>("points/state/x", 0, 2, 3), x);
  EXPECT_EQ(in.read_rows<double>("points/state/x", 1, 1, 3), (std::vector<double>{4, 5, 6}));
  EXPECT_EQ(in.read_rows<double>("points/state/x", 2, 0, 3), std::vector<double>{});
  EXPECT_EQ(in.read_rows<std::int64_t>("points/id", 0, 2), id);
  EXPECT_EQ(in.read_rows<std::int32_t>("cell", 0, 1), cell);
  EXPECT_EQ(in.read_rows<std::uint8_t>("flag", 1, 2), (std::vector<std::uint8_t>{255, 3}));
  EXPECT_EQ(in.rows("points/none"), 0);
  EXPECT_EQ(in.read_rows<double>("points/none", 0, 0, 9), std::vector<double>{});
  EXPECT_EQ(in.read_text("case"), text);
  EXPECT_EQ(in.read_text("empty"), "");
  EXPECT_EQ(in.read_number("time"), 0.1);
  EXPECT_EQ(in.read_number("number99"), 99.0);
  EXPECT_TRUE(in.has("points/state/x"));
  EXPECT_FALSE(in.has("points/y"));
  EXPECT_FALSE(in.has("nothing/at/all"));
}

TEST_F(Checkpoint, NamesWhatIsMissingOrOfAnotherShape) {
  write(1.0);
  const auto in = CheckpointFile::open(Comm(), file);
  EXPECT_EQ(input_error([&] { in.rows("points/y"); }), file + ": points/y is missing");
  EXPECT_EQ(input_error([&] { in.read_number("time"); }), file + ": time is missing");
  EXPECT_EQ(input_error([&] { in.read_text("case"); }), file + ": case is missing");
  EXPECT_EQ(input_error([&] { in.read_rows<double>("points/x", 0, 1, 3); }), file + ": points/x has 2 columns, not 3");
  EXPECT_EQ(input_error([&] { in.read_rows<double>("points/x", 499, 2, 2); }),
            file + ": points/x has 500 rows, not rows 499 to 501");
  EXPECT_EQ(input_error([&] { in.read_rows<double>("points/x", 0, 1LL << 62, 2); }),
            file + ": points/x has 500 rows, not rows 0 to 4611686018427387904");
  EXPECT_EQ(input_error([&] { in.read_rows<std::int32_t>("points/x", 0, 1, 2); }),
            file + ": points/x does not hold 32-bit integers");
  EXPECT_EQ(input_error([&] { in.read_text("points/x"); }), file + ": points/x is not a text");
  EXPECT_EQ(input_error([&] { in.rows("format"); }), file + ": format is not a table of rows and columns");
  EXPECT_NE(input_error([&] { in.rows("points"); }).find(file + ": points cannot be opened"), std::string::npos);
}

TEST_F(Checkpoint, KeepsTheOldFileUntilTheNewOneIsWhole) {
  write(1.0);
  {
    auto out = CheckpointFile::create(Comm(), file);
    out.write("points/x", std::vector<double>(1000, 2.0), 2);
    EXPECT_EQ(CheckpointFile::open(Comm(), file).read_rows<double>("points/x", 0, 1, 2)[0], 1.0);
    EXPECT_TRUE(fs::exists(file + ".part"));
  }
  EXPECT_FALSE(fs::exists(file + ".part"));
  EXPECT_EQ(CheckpointFile::open(Comm(), file).read_rows<double>("points/x", 0, 1, 2)[0], 1.0);
  write(3.0);
  EXPECT_EQ(CheckpointFile::open(Comm(), file).read_rows<double>("points/x", 0, 1, 2)[0], 3.0);
}

TEST_F(Checkpoint, SurvivesAKill) {
  write(1.0);
  EXPECT_EXIT(
      {
        auto out = CheckpointFile::create(Comm(), file);
        out.write("points/x", std::vector<double>(1000000, 2.0), 2);
        std::raise(SIGKILL);
      },
      testing::KilledBySignal(SIGKILL), "");
  EXPECT_TRUE(fs::exists(file + ".part"));
  EXPECT_EQ(CheckpointFile::open(Comm(), file).read_rows<double>("points/x", 0, 1, 2)[0], 1.0);
  write(4.0);
  EXPECT_FALSE(fs::exists(file + ".part"));
  EXPECT_EQ(CheckpointFile::open(Comm(), file).read_rows<double>("points/x", 0, 1, 2)[0], 4.0);
}

TEST_F(Checkpoint, RefusesWhatIsNone) {
  EXPECT_EQ(refusal(), "cannot read " + file + ": No such file or directory");
  std::ofstream(file) << "title = \"a case file\"\n";
  EXPECT_EQ(refusal(), file + " is not a checkpoint of berm: it is no HDF5 file");
  std::ofstream(file).flush();
  EXPECT_EQ(refusal(), file + " is not a checkpoint of berm: it is no HDF5 file");
  fs::remove(file);
  fs::create_directory(file);
  EXPECT_EQ(refusal(), "cannot read " + file + ": it is a folder");
}

TEST_F(Checkpoint, RefusesTruncatedAndDamagedFiles) {
  write(1.0);
  const std::string whole = content(file);
  const std::string words = file + " is not a checkpoint of berm: ";
  for (const double part : {0.999, 0.5, 0.1, 0.02}) {
    fs::resize_file(file, static_cast<std::uintmax_t>(part * whole.size()));
    EXPECT_EQ(refusal().substr(0, words.size()), words) << part;
  }
  // Any single flipped bit is noticed, wherever it is: in the seal, in the headers, in the numbers.
  for (std::size_t i = 0; i < whole.size(); i += i < 4000 ? 29 : 977) {
    std::string broken = whole;
    broken[i] = static_cast<char>(broken[i] ^ (1 << i % 8));
    std::ofstream(file, std::ios::binary) << broken;
    EXPECT_EQ(refusal().substr(0, words.size()), words) << i;
  }
}

TEST_F(Checkpoint, SaysWhyItCannotBeWritten) {
  const std::string nowhere = path("absent/run.h5");
  try {
    CheckpointFile::create(Comm(), nowhere);
    FAIL();
  } catch (const RunError& e) {
    EXPECT_EQ(e.what(), "cannot write " + nowhere + ": No such file or directory");
  }
}

TEST_F(Checkpoint, ReportsAFullDisk) {
  // A limit on the size of files stands for the disk; in a process of its own, where it does no harm.
  const auto fill = [&] {
    std::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{100000, 100000};
    setrlimit(RLIMIT_FSIZE, &limit);
    try {
      auto out = CheckpointFile::create(Comm(), file);
      out.write("points/x", std::vector<double>(100000, 1.0), 2);
      out.commit();
    } catch (const RunError& e) {
      std::fprintf(stderr, "%s\n", e.what());
      std::exit(fs::exists(file) || fs::exists(file + ".part") ? 2 : 1);
    }
    std::exit(0);
  };
  EXPECT_EXIT(fill(), testing::ExitedWithCode(1), "cannot write .*run.h5: File too large");
}

}  // namespace
}  // namespace berm
