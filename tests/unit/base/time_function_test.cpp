#include "base/time_function.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "base/error.hpp"

namespace berm {
namespace {

TEST(TimeFunction, NumberIsReachedAtTheEnd) {
  TimeFunction f(3.0);
  EXPECT_EQ(f.at(0.0), 0.0);
  EXPECT_EQ(f.at(1.0), 3.0);
  f.set_end(4.0);
  EXPECT_EQ(f.at(1.0), 0.75);
  EXPECT_EQ(f.at(4.0), 3.0);
  EXPECT_TRUE(TimeFunction().is_zero());
  EXPECT_FALSE(f.is_zero());
}

TEST(TimeFunction, ExpressionOfTimeAndPlace) {
  const TimeFunction ramp("9.81*min(t/0.5, 1)"), water("9810*max(0, 5*t - y)");
  EXPECT_DOUBLE_EQ(ramp.at(0.25), 4.905);
  EXPECT_DOUBLE_EQ(ramp.at(2.0), 9.81);
  EXPECT_FALSE(ramp.depends_on_place());
  EXPECT_TRUE(water.depends_on_place());
  EXPECT_DOUBLE_EQ(water.at(0.5, Vec3(7.0, 2.0, 0.0)), 9810.0 * 0.5);
  EXPECT_EQ(water.at(0.5, Vec3(7.0, 2.6, 0.0)), 0.0);
  EXPECT_DOUBLE_EQ(TimeFunction("sin(2*pi*t)").at(0.25), 1.0);
  EXPECT_DOUBLE_EQ(TimeFunction("t > 0.5 ? 2 : 1").at(0.75), 2.0);
}

/// What an expression is at t = 0 comes with the first step; a number begins with 0 anyway.
TEST(TimeFunction, StepsBeginWithZero) {
  const TimeFunction constant("-0.001 - 0.0*t"), ramp("2*t + 1"), number(3.0);
  EXPECT_DOUBLE_EQ(constant.step(0.0, 0.2), -0.001);
  EXPECT_DOUBLE_EQ(constant.step(0.2, 0.4), 0.0);
  EXPECT_DOUBLE_EQ(ramp.step(0.0, 0.5) + ramp.step(0.5, 1.0), 3.0);
  EXPECT_DOUBLE_EQ(number.step(0.0, 0.5), 1.5);
}

TEST(TimeFunction, PlacesCountFromAnOrigin) {
  TimeFunction f("x + 2*y");
  f.set_origin(Vec3(100.0, 1000.0, 0.0));
  EXPECT_DOUBLE_EQ(f.at(0.0, Vec3(1.0, 2.0, 0.0)), 2105.0);
}

TEST(TimeFunction, RefusesAssignmentsAndConstantsWithoutAValue) {
  for (const char* text : {"t=5", "t = 5", "0*t + (x=3)", "1/0", "log(0)", "sqrt(-1)"}) EXPECT_THROW(TimeFunction{text}, std::invalid_argument) << text;
  for (const char* text : {"t==5 ? 1 : 2", "t>=5 ? 1 : 2", "t<=5 ? 1 : 2", "t!=5 ? 1 : 2", "1/t"}) EXPECT_NO_THROW(TimeFunction{text}) << text;
}

TEST(TimeFunction, CopiesDoNotDisturbEachOther) {
  const TimeFunction a("x + t"), b = a;
  EXPECT_EQ(a.at(1.0, Vec3(1.0, 0.0, 0.0)) + b.at(2.0, Vec3(3.0, 0.0, 0.0)), 7.0);
  EXPECT_EQ(a, b);
  EXPECT_NE(a, TimeFunction("t + x"));
}

TEST(TimeFunction, SaysWhatIsWrongAndWhere) {
  const auto error_of = [](const std::string& text) -> std::string {
    try {
      const TimeFunction unused(text);
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(error_of("2*t+"), "\"2*t+\": Unexpected end of expression at position 5");
  EXPECT_NE(error_of("sin(q)").find("\"q\" found at position 4"), std::string::npos);
  EXPECT_NE(error_of("1,5*t").find("decimal comma"), std::string::npos);
  EXPECT_NE(error_of(""), "");
}

TEST(TimeFunction, RefusesValuesThatAreNotFinite) {
  EXPECT_THROW(TimeFunction("1/t").at(0.0), RunError);
  EXPECT_THROW(TimeFunction("sqrt(t - 1)").at(0.5), RunError);
}

}  // namespace
}  // namespace berm
