#include <cmath>
#include <limits>

#include "base/error.hpp"
#include "io/history.hpp"
#include "temporary_folder.hpp"

namespace berm {
namespace {

class History : public TemporaryFolder {};

TEST_F(History, EveryRowIsOnDiskAtOnce) {
  HistoryWriter history(path("history.csv"), {"step [-]", "reaction [N]"});
  EXPECT_EQ(content(path("history.csv")), "step [-],reaction [N]\n");
  history.append({0, 0});
  EXPECT_EQ(content(path("history.csv")), "step [-],reaction [N]\n0,0\n");
}

TEST_F(History, NumbersReadBackExactly) {
  const std::vector<double> row = {1.0 / 3.0, -1e-300, 5e6, std::nextafter(1.0, 2.0),
                                   std::numeric_limits<double>::max()};
  HistoryWriter(path("h.csv"), {"a [-]", "b [-]", "c [-]", "d [-]", "e [-]"}).append(row);
  std::ifstream in(path("h.csv"));
  std::string line, cell;
  std::getline(in, line);
  for (const double expected : row) {
    std::getline(in, cell, expected == row.back() ? '\n' : ',');
    EXPECT_EQ(std::stod(cell), expected);
  }
}

TEST_F(History, NamesWithSeparatorsAreQuoted) {
  HistoryWriter history(path("h.csv"), {"probe:a,b [Pa]", "gauge:\"x\" [m]"});
  EXPECT_EQ(content(path("h.csv")), "\"probe:a,b [Pa]\",\"gauge:\"\"x\"\" [m]\"\n");
}

TEST_F(History, RowOfWrongLengthIsRefused) {
  HistoryWriter history(path("h.csv"), {"a [-]", "b [-]"});
  EXPECT_THROW(history.append({1.0}), std::invalid_argument);
}

TEST_F(History, FailuresNameTheFile) {
  EXPECT_THROW(HistoryWriter(path("no_such_folder/h.csv"), {"a [-]"}), RunError);
  if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "this system has no /dev/full";
  try {
    HistoryWriter("/dev/full", {"a [-]"});
    FAIL() << "no error";
  } catch (const RunError& error) {
    EXPECT_EQ(std::string(error.what()), "cannot write /dev/full: No space left on device (make room, or choose a folder elsewhere with --out)");
  }
}

TEST(HistoryColumns, AllCarryUnits) {
  for (const std::string& column : standard_history_columns()) {
    EXPECT_NE(column.find(" ["), std::string::npos) << column;
    EXPECT_EQ(column.back(), ']') << column;
  }
}

}  // namespace
}  // namespace berm
