#include <unistd.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstdio>

#include "core/spec/quantity.hpp"
#include "core/spec/spec_error.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

std::string complaint(const std::string& text, const std::string& unit) {
  try {
    parse_quantity(text, unit, "/here");
  } catch (const SpecError& error) {
    CHECK(error.pointer() == "/here");
    return error.what();
  }
  return "accepted";
}

}  // namespace

TEST_CASE("a text with a unit is the number in SI") {
  struct Case {
    const char *text, *unit;
    double value;
  };
  const double degree = M_PI / 180;
  for (const Case& c : {Case{"0.35 mm", "m", 0.35e-3},
                        {"0.35mm", "m", 0.35e-3},
                        {"  +1e2 um ", "m", 1e-4},
                        {"100 µm", "m", 1e-4},
                        {"2 in", "m", 0.0508},
                        {"-.5 m", "m", -0.5},
                        {"20 deg", "rad", 20 * degree},
                        {"20 °", "rad", 20 * degree},
                        {"50 mrad", "rad", 0.05},
                        {"100 gon", "rad", 90 * degree},
                        {"1e-3 kg m^2", "kg m^2", 1e-3},
                        {"3 g cm2", "kg m^2", 3e-7},
                        {"50 N/mm", "N/m", 5e4},
                        {"1 N m", "N m", 1},
                        {"1 N.m", "N m", 1},
                        {"1 N*m", "N m", 1},
                        {"20 N mm", "N m", 0.02},
                        {"3 N m/rad", "N m/rad", 3},
                        {"3 N m", "N m/rad", 3},
                        {"210 GPa", "Pa", 210e9},
                        {"450 N/mm^2", "Pa", 450e6},
                        {"7.8 g/cm^3", "kg/m^3", 7800},
                        {"2 kHz", "Hz", 2000},
                        {"50 %", "1", 0.5},
                        {"0.3", "1", 0.3}}) {
    INFO(c.text << " as " << c.unit);
    CHECK(parse_quantity(c.text, c.unit, "") == Approx(c.value).epsilon(1e-13));
  }
}

TEST_CASE("a unit of another dimension is refused with the expected one") {
  CHECK_THAT(complaint("5 N", "m"),
             Contains("/here = \"5 N\"") && Contains("a length") && Contains("0.35 mm"));
  CHECK_THAT(complaint("5 mm", "rad"), Contains("an angle"));
  CHECK_THAT(complaint("5 mm", "kg m^2"), Contains("a moment of inertia"));
  CHECK_THAT(complaint("5 kg", "N"), Contains("a force"));
  CHECK_THAT(complaint("5 N", "N m"), Contains("a moment"));
  CHECK_THAT(complaint("5 mm", "1"), Contains("a plain number"));
}

TEST_CASE("the radian is a dimension, although UDUNITS takes it for a number") {
  CHECK_THAT(complaint("600 rad/s", "Hz"), Contains("a frequency"));
  CHECK_THAT(complaint("600 rpm", "Hz"), Contains("a frequency"));
  CHECK_THAT(complaint("0.3", "rad"), Contains("unit is missing"));
  CHECK_THAT(complaint("5 %", "rad"), Contains("an angle"));
  CHECK_THAT(complaint("20 deg", "1"), Contains("a plain number"));
  CHECK_THAT(complaint("1 N m/rad", "N m"), Contains("a moment"));
}

TEST_CASE("texts that are no plain quantity are refused") {
  for (const char* text : {"",
                           " ",
                           "mm",
                           "five mm",
                           "0.35",
                           "0.35 mmm",
                           "0,35 mm",
                           "1.2.3 mm",
                           "nan mm",
                           "inf mm",
                           "-inf m",
                           "1e999 mm",
                           "1e308 km",
                           "2 3 mm",
                           "1 /m",
                           "1 -mm",
                           "1 mm @ 5",
                           "1 lg(re 1 m)",
                           "1 m since 2000-01-01",
                           "0x10 mm",
                           "1 mm; rm",

                           "++1 mm",
                           "1 \xff"}) {
    INFO(text);
    CHECK_THAT(complaint(text, "m"), Contains("expected a length"));
  }
  CHECK_THAT(complaint("0,35 mm", "m"), Contains("the decimal sign is a point"));
  CHECK_THAT(complaint("20 degC", "m"), Contains("another dimension"));
}

TEST_CASE("UDUNITS knows the units that messages speak of") {
  for (const char* unit : {"m", "m^2", "m^3", "rad", "1", "kg", "kg m^2", "kg/m^3", "Pa", "N",
                           "N m", "N/m", "N m/rad", "Hz", "m/N", "rad/(N m)"})
    CHECK(is_known_unit(unit));
  CHECK_FALSE(is_known_unit("parrot"));
}

TEST_CASE("a number with a unit is measured in SI") {
  const auto [unit, value, si] = GENERATE(table<std::string, double, std::string>({
      {"mm", 1e-3, "m"},
      {"N/mm", 1e3, "N/m"},
      {"kN m/deg", 1e3 * 180 / M_PI, "N m/rad"},
      {"deg", M_PI / 180, "rad"},
      {"%", 1e-2, "1"},
      {"g/cm^3", 1e3, "kg/m^3"},
      {"GPa", 1e9, "Pa"},
      {"mm/N", 1e-3, "m/N"},
      {"W/K", 1, "kg m^2 s^-3 K^-1"},
      {"cd/m^2", 1, "m^-2 cd"},
  }));
  CAPTURE(unit);
  const auto found = measured(1, unit);
  REQUIRE(found);
  CHECK(found->value == Approx(value).epsilon(1e-14));
  CHECK(unit_of(found->dimension) == si);
  CHECK(found->dimension == dimension_of(si));
}

TEST_CASE("units that are none, or no plain multiples, measure nothing") {
  for (const char* unit :
       {"", " ", "furlongz", "degC", "lg(re 1 mW)", "2 mm", "m @ 5", "K @ 273.15"})
    CHECK_FALSE(measured(1, unit));
}

TEST_CASE("whatever a unit is, nothing is written to stdout") {
  std::fflush(stdout);
  const int before = dup(STDOUT_FILENO);
  std::FILE* file = std::tmpfile();
  REQUIRE(file);
  dup2(fileno(file), STDOUT_FILENO);
  for (const char* unit : {"m\nm", "m\n", "\n", "m\tm", "kg\r\nm", "\x01"}) measured(1, unit);
  std::fflush(stdout);
  const auto written = lseek(STDOUT_FILENO, 0, SEEK_END);
  dup2(before, STDOUT_FILENO);
  close(before);
  std::fclose(file);
  CHECK(written == 0);
}

TEST_CASE("dimensions multiply, divide and take powers") {
  const Dimension m = dimension_of("m"), N = dimension_of("N");
  CHECK(m * m == dimension_of("m^2"));
  CHECK(N / m == dimension_of("N/m"));
  CHECK((m * m).power(0.5) == m);
  CHECK(m.power(1.0 / 3) * m.power(2.0 / 3) == m);
  CHECK_FALSE(m == N);
  CHECK((m / m).is_plain());
  // an angle is a plain number, but is called an angle
  CHECK(dimension_of("rad").is_plain());
  CHECK(describe(dimension_of("rad")) == "an angle [rad]");
  CHECK(describe(m / m) == "a plain number");
  CHECK(describe(m.power(0.5)) == "a quantity in m^0.5");
  CHECK(unit_of(dimension_of("N m/rad").without_radian()) == "N m");
}

TEST_CASE("a unit may be one over another, and a change of temperature is no temperature") {
  CHECK(parse_quantity("11e-6 1/K", "1/K", "") == Approx(11e-6));
  CHECK(parse_quantity("11 um/(m K)", "1/K", "") == Approx(11e-6));
  CHECK(parse_quantity("-9.81 m/s^2", "m/s^2", "") == Approx(-9.81));
  CHECK(parse_quantity("20 K", "K", "") == 20);
  CHECK_THROWS_AS(parse_quantity("20 degC", "K", ""), SpecError);
  CHECK_THROWS_AS(parse_quantity("3 1/2 mm", "m", ""), SpecError);
  CHECK_THROWS_AS(parse_quantity("3 1/ mm", "m", ""), SpecError);
  CHECK_THROWS_AS(parse_quantity("3 1/mm", "m", ""), SpecError);
}
