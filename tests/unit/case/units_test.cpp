/// Numbers with units.

#include "case/units.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace berm {
namespace {

double value(const char* text, Unit unit) {
  const Parsed parsed = parse_quantity(text, unit);
  EXPECT_EQ(parsed.error, "") << text;
  return parsed.value;
}

std::string error(const char* text, Unit unit) { return parse_quantity(text, unit).error; }

TEST(Units, valuesInSi) {
  EXPECT_DOUBLE_EQ(value("35.5 GPa", Unit::stress), 35.5e9);
  EXPECT_DOUBLE_EQ(value("35.5GPa", Unit::stress), 35.5e9);
  EXPECT_DOUBLE_EQ(value("  3.05   MPa ", Unit::stress), 3.05e6);
  EXPECT_DOUBLE_EQ(value("12 N/mm2", Unit::stress), 12e6);
  EXPECT_DOUBLE_EQ(value("-5e-1 mm", Unit::length), -0.5e-3);
  EXPECT_DOUBLE_EQ(value("+7 um", Unit::length), 7e-6);
  EXPECT_DOUBLE_EQ(value("7 µm", Unit::length), 7e-6);
  EXPECT_DOUBLE_EQ(value("2410 kg/m3", Unit::density), 2410.0);
  EXPECT_DOUBLE_EQ(value("2.41 t/m^3", Unit::density), 2410.0);
  EXPECT_DOUBLE_EQ(value("2.41 g/cm³", Unit::density), 2410.0);
  EXPECT_DOUBLE_EQ(value("100 N/m", Unit::energy_per_area), 100.0);
  EXPECT_DOUBLE_EQ(value("0.1 N/mm", Unit::energy_per_area), 100.0);
  EXPECT_DOUBLE_EQ(value("100 J/m²", Unit::energy_per_area), 100.0);
  EXPECT_DOUBLE_EQ(value("9.81 m/s2", Unit::acceleration), 9.81);
  EXPECT_DOUBLE_EQ(value("5 kN", Unit::force), 5000.0);
  EXPECT_DOUBLE_EQ(value("1 N/mm3", Unit::stress_per_length), 1e9);
  EXPECT_DOUBLE_EQ(value("180 deg", Unit::angle), std::numbers::pi);
  EXPECT_DOUBLE_EQ(value("90°", Unit::angle), std::numbers::pi / 2);
  EXPECT_DOUBLE_EQ(value("0.5 rad", Unit::angle), 0.5);
  EXPECT_DOUBLE_EQ(value("100 cm²", Unit::area), 0.01);
  EXPECT_DOUBLE_EQ(value("90 s", Unit::minutes), 1.5);
  EXPECT_DOUBLE_EQ(value("6 1/min", Unit::rate), 0.1);
}

TEST(Units, stringsWithoutUnitAreLikeBareNumbers) {
  EXPECT_DOUBLE_EQ(value("3.5", Unit::length), 3.5);
  EXPECT_DOUBLE_EQ(value("180", Unit::angle), std::numbers::pi);
}

TEST(Units, wrongDimensionIsAnError) {
  EXPECT_EQ(error("5 mm", Unit::density),
            "\"5 mm\" has the unit of a length; a density is needed, such as \"1 kg/m3\"");
  EXPECT_EQ(error("5 N/m", Unit::angle),
            "\"5 N/m\" has the unit of an energy per area; an angle is needed, such as \"1 deg\"");
  EXPECT_NE(error("5 GPa", Unit::length), "");
  EXPECT_NE(error("20 deg", Unit::stress), "");
}

TEST(Units, unknownUnitListsTheKnownOnes) {
  EXPECT_EQ(error("5 furlong", Unit::length),
            "\"5 furlong\" has the unknown unit \"furlong\"; known units of length: m, km, dm, cm, mm, um");
  EXPECT_NE(error("5 mpa", Unit::stress), "") << "units are case sensitive: mPa and MPa differ";
}

TEST(Units, whatIsNoNumber) {
  for (const char* text : {"", " ", "GPa", "abc", "+", "--5 m", "1e999 m", "nan m", "inf m", "0x10 m"}) {
    EXPECT_NE(error(text, Unit::length), "") << text;
  }
}

TEST(Units, doubts) {
  EXPECT_EQ(unit_doubt("youngs_modulus", Unit::stress, 35.5), "youngs_modulus = 35.5 Pa: did you mean GPa?");
  EXPECT_EQ(unit_doubt("youngs_modulus", Unit::stress, 1e6), "");
  EXPECT_NE(unit_doubt("youngs_modulus", Unit::stress, 1e15), "");
  EXPECT_NE(unit_doubt("tensile_strength", Unit::stress, 3.05), "");
  EXPECT_EQ(unit_doubt("cohesion", Unit::stress, 0.0), "");
  EXPECT_EQ(unit_doubt("cohesion", Unit::stress, 5000.0), "");
  EXPECT_NE(unit_doubt("density", Unit::density, 200000.0), "");
  EXPECT_NE(unit_doubt("fracture_energy", Unit::energy_per_area, 0.1), "");
  EXPECT_EQ(unit_doubt("friction_angle", Unit::angle, 0.436332313 * std::numbers::pi / 180),
            "friction_angle = 0.436332313 deg: did you mean rad?");
  EXPECT_EQ(unit_doubt("friction_angle", Unit::angle, 0.436332313), "");
}

TEST(Units, rangesInFileUnits) {
  EXPECT_EQ(range_text({0.0, std::numbers::pi / 2, false, true}, Unit::angle), "0 <= value < 90");
  EXPECT_EQ(range_text(positive(), Unit::length), "> 0");
  EXPECT_EQ(range_text({-infinity, 3.0, false, false}, Unit::none), "<= 3");
  EXPECT_EQ(range_text({}, Unit::none), "");
}

}  // namespace
}  // namespace berm
