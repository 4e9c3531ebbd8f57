#include "core/spec/formula.hpp"

#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>
#include <random>
#include <thread>

#include "core/math/dual.hpp"
#include "core/math/ridders.hpp"
#include "core/spec/spec_error.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {

/// Names without units: bare numbers.
const std::vector<FormulaName> numbers{{"length", ""}, {"width", ""}, {"gap", ""}};
/// The same and more with units.
const std::vector<FormulaName> measures{{"length", "m"},
                                        {"width", "m"},
                                        {"gap", "m"},
                                        {"half_angle", "rad"},
                                        {"fraction", "1"},
                                        {"mass", "kg"},
                                        {"material.density", "kg/m^3"},
                                        {"E", "Pa"},
                                        {"aspect", ""}};

const std::string at = "/optimise/constraints/0";

Formula plain(const std::string& text) { return {text, numbers, at}; }
Formula strict(const std::string& text) { return {text, measures, at}; }
Formula si(const std::string& text) { return {text, measures, at, BareNumbers::may_be_si}; }

std::optional<double> value(const Formula& f, std::vector<double> v) { return f.value(v); }

std::string complaint(const std::string& text, BareNumbers bare = BareNumbers::are_plain,
                      const std::string& unit = "") {
  try {
    const Formula formula(text, measures, at, bare);
    if (!unit.empty()) formula.check_unit(unit);
  } catch (const SpecError& error) {
    CHECK(error.pointer() == at);
    return error.rule();
  }
  return "accepted";
}

std::string unit_of(const std::string& text) {
  const Formula f = strict(text);
  return f.dimension() ? flexopt::unit_of(*f.dimension()) : "bare";
}

/// Derivatives against extrapolated differences, which are known to a small part of themselves.
void check_gradient(const Formula& f, const std::vector<double>& v) {
  std::vector<double> slopes(f.slots().size());
  const std::optional<double> here = f.gradient(v, slopes);
  REQUIRE(here);
  CHECK(here == f.value(v));
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    const auto slot = static_cast<std::size_t>(f.slots()[i]);
    CAPTURE(slot);
    const Derivatives d = ridders(
        [&](double x) {
          std::vector<double> moved = v;
          moved[slot] = x;
          return std::vector<double>{f.value(moved).value()};
        },
        v[slot], 1e-2 * v[slot]);
    // rounding of the value is what is left of the differences' error
    const double known = 5 * d.error[0] + 1e-12 * (1 + std::abs(*here) / v[slot]);
    CHECK(std::abs(slopes[i] - d.value[0]) <= known + 1e-9 * std::abs(slopes[i]));
  }
}

}  // namespace

TEST_CASE("a formula has the value that mathematics gives it") {
  const std::vector<double> v{0.1, 0.03, 0.001};
  const auto of = [&](const char* text) { return value(plain(text), v).value(); };
  CHECK(of("2*width + length - gap") == Approx(0.159));
  CHECK(of("length^2/width") == Approx(1.0 / 3));
  CHECK(of("max(length, width) + min(gap, 1) + abs(-gap)") == Approx(0.102));
  CHECK(of("cos(pi*length*10)") == Approx(-1));
  CHECK(of("(length >= width)*gap") == Approx(0.001));
  CHECK(of("1e-3*length") == Approx(1e-4));
  CHECK(of("avg(length, width, 0.05) + sum(gap, 2*gap, 3)") == Approx(0.06 + 3.003));
  CHECK(of(".5*length + 5.*gap") == 0.5 * 0.1 + 5 * 0.001);
  CHECK(of("3 + 4") == 7);
}

TEST_CASE("operators bind as mathematics writes them") {
  const auto [text, expected] = GENERATE(table<std::string, double>({
      {"-2^2", -4},
      {"2^-2", 0.25},
      {"2^3^2", 512},
      {"2^-1^2", 0.5},
      {"-2*3", -6},
      {"2*-3", -6},
      {"--2", 2},
      {"8/4/2", 1},
      {"8 - 4 - 2", 2},
      {"1 + 2*3^2", 19},
      {"1 + 2 < 4", 1},
      {"1 < 2 && 2 < 1", 0},
      {"0 && 0 || 1", 1},
      {"1 || 0 && 0", 1},
      {"!0 + 1", 2},
      {"!(1 < 2)", 0},
      {"1 < 2 ? 3 : 4", 3},
      {"2 < 1 ? 3 : 1 < 2 ? 5 : 6", 5},
      {"2 == 2 ? 1 : 0", 1},
      {"2 != 2 ? 1 : 0", 0},
      {"rint(2.5)", 3},
      {"round(-2.6)", -3},
      {"sign(-3)", -1},
      {"max(1, 7, 3)", 7},
      {"atan2(1, 1)*4/pi", 1},
      {"log(exp(2)) + ln(exp(1)) + log10(100) + log2(8)", 8},
  }));
  CAPTURE(text);
  CHECK(value(plain(text), {}).value() == Approx(expected).epsilon(1e-15));
}

TEST_CASE("a formula names the slots that it uses, in ascending order") {
  CHECK(plain("gap + width*gap").slots() == std::vector<int>{1, 2});
  CHECK(plain("3").slots().empty());
  CHECK(value(strict("material.density"), {0, 0, 0, 0, 0, 0, 7800, 0, 0}) == 7800.0);
}

TEST_CASE("a formula that is not finite has no value") {
  CHECK_FALSE(value(plain("1/gap"), {0, 0, 0}));
  CHECK_FALSE(value(plain("sqrt(gap)"), {0, 0, -1}));
  CHECK(value(plain("sqrt(gap)"), {0, 0, 4}) == 2.0);
  CHECK_FALSE(value(plain("1/0"), {}));
  // what is not taken does not matter
  CHECK(value(plain("gap > 0 ? 1/gap : width"), {0, 7, 0}) == 7.0);
}

TEST_CASE("numbers may carry units") {
  const std::vector<double> v{0.2, 0.04, 0.001, 0.5, 0.3, 2, 7800, 2.1e11, 4};
  CHECK(*strict("length/2 + 5 mm").value(v) == 0.2 / 2 + 5e-3);
  CHECK(*strict("0.5*width - 2 mm").value(v) == 0.5 * 0.04 - 2e-3);
  CHECK(*strict("5mm").value(v) == 5e-3);
  CHECK(*strict("90 deg - half_angle").value(v) == Approx(std::numbers::pi / 2 - 0.5));
  CHECK(*strict("3 [N/mm] * length").value(v) == Approx(600));
  CHECK(*strict("50 % * length").value(v) == Approx(0.1));
  CHECK(*strict("20 \xC2\xB5m + gap").value(v) == Approx(1.02e-3));
  CHECK(*strict("sin(30 deg)*length").value(v) == Approx(0.1));
  CHECK(*strict("2 kg + mass").value(v) == 4);
  CHECK(unit_of("3 [N/mm] * length") == "N");
  CHECK(unit_of("length*width") == "m^2");
  CHECK(unit_of("E*gap") == "N/m");
  CHECK(unit_of("sqrt(length*width)") == "m");
  CHECK(unit_of("(length^3)^(1/3)") == "m");
  CHECK(unit_of("mass/length/width") == "kg m^-2");
  CHECK(unit_of("atan2(length, width)") == "rad");
  CHECK(unit_of("length > width ? gap : 1") == "m");
  CHECK(unit_of("(length > width)*gap") == "m");
  CHECK(unit_of("2*3 + aspect") == "bare");
  CHECK(unit_of("pi") == "1");
}

TEST_CASE("a bare number takes the dimension of what it is added to or compared with") {
  for (const char* text :
       {"0.1 - length", "length + 0.1", "max(length, 0.1, 1e-3)", "length > 0.1",
        "2*aspect + length", "length > width ? 0.1 : gap", "half_angle + 0.1",
        "half_angle + fraction", "pi/2 - half_angle", "atan2(length, 0.1)", "avg(0.1, gap)"})
    CHECK_NOTHROW(strict(text));
  CHECK(unit_of("0.1 - length") == "m");
  // and that of its place, unless it is a factor
  CHECK_NOTHROW(strict("0.1*2").check_unit("Pa"));
  CHECK(complaint("0.1*length*width", BareNumbers::are_plain, "m") ==
        "it is an area [m^2], expected a length [m]");
}

TEST_CASE("dimensions that do not fit are refused, both named with their positions") {
  const auto [text, first, second] = GENERATE(table<std::string, std::string, std::string>({
      {"length + half_angle", "'length' (position 1) is a length [m]",
       "'half_angle' (position 10) is an angle [rad]"},
      {"2*length - mass", "'2*length' (position 1) is a length [m]",
       "'mass' (position 12) is a mass [kg]"},
      {"length < E", "'length' (position 1) is a length", "compared"},
      {"max(length, mass)", "'length' (position 5) is a length", "'mass' (position 13) is a mass"},
      {"length > width ? length : mass", "'length' (position 18)", "'mass' (position 27)"},
      {"5 mm + 3 deg", "'5 mm' (position 1) is a length", "'3 deg' (position 8) is an angle"},
      {"atan2(length, mass)", "a length", "a mass"},
      {"sin(length)", "the argument 'length' (position 5) of sin is a length [m]",
       "expected a plain number or an angle"},
      {"exp(length/mass)", "'length/mass' (position 5)", "a quantity in kg^-1 m"},
      {"asin(mass)", "a mass [kg]", "expected a plain number"},
      {"2^length", "the exponent 'length' (position 3) is a length", "expected a plain number"},
      {"length^fraction", "'length' (position 1) is a length", "must be a constant"},
      {"length^2 + gap", "an area [m^2]", "a length [m]"},
      {"0.5*length + half_angle + 1 mm", "a length", "an angle"},
  }));
  CAPTURE(text);
  CHECK_THAT(complaint(text), Contains(first) && Contains(second));
}

TEST_CASE("a formula without units may hold quantities in SI as factors") {
  for (const char* text : {"0.5e-3*(2e11/E)^(1/3)", "sqrt(length*0.036)", "0.1*cos(half_angle)",
                           "exp(-length/0.01)*width", "sqrt(length - 0.1)", "aspect*width^2"}) {
    CAPTURE(text);
    CHECK(complaint(text, BareNumbers::may_be_si, "m") == "accepted");
    CHECK_THAT(complaint(text, BareNumbers::are_plain, "m"), Contains("expected"));
  }
  CHECK(complaint("3.5e8*length + E", BareNumbers::may_be_si) == "accepted");
  // whole factors are numbers, and a unit anywhere says that units are written
  CHECK_THAT(complaint("2*length + half_angle", BareNumbers::may_be_si), Contains("an angle"));
  CHECK_THAT(complaint("0.5*length + 2 deg", BareNumbers::may_be_si), Contains("an angle"));
  CHECK_THAT(complaint("length + half_angle + 0.1", BareNumbers::may_be_si), Contains("an angle"));
  CHECK_THAT(complaint("length*width", BareNumbers::may_be_si, "m"), Contains("an area"));
  CHECK_FALSE(si("length*width").fits_anywhere());
  CHECK(si("0.5*width").fits_anywhere());
  CHECK_FALSE(si("0.5*width - 2 mm").fits_anywhere());
}

TEST_CASE("a name with signs in it stands in quotes") {
  const std::vector<FormulaName> names{{"load.-ux", "N"}, {"load.+x-1", "N"}, {"x", "N"}};
  const Formula f("2*'load.-ux' - 'load.+x-1'/x*(x)", names, at);
  CHECK(f.value(std::vector<double>{3, 5, 7}).value() == Approx(1));
  CHECK(f.names() == std::vector<std::string>{"load.-ux", "load.+x-1", "x"});
  for (const char* wrong : {"'load.-u'", "'load.-ux", "'", "2*''", "load.-ux"})
    CHECK_THROWS_AS(Formula(wrong, names, at), SpecError);
}

TEST_CASE("wrong formulas are refused with place and reason") {
  const auto [text, reason] = GENERATE(table<std::string, std::string>({
      {"2*outer_width", "unknown name 'outer_width' (position 3)"},
      {"2*widht", "unknown name 'widht' (position 3); did you mean 'width'? known: length, width"},
      {"2*(width", "not a formula: ')' is missing"},
      {"width)", "not a formula: unexpected ')' (position 6)"},
      {"width +", "not a formula: it ends where a value is expected (position 8)"},
      {"width width", "not a formula: unexpected 'width' (position 7)"},
      {"", "expected a formula over: length, width"},
      {"  \t\n", "expected a formula"},
      {"width = 3", "does not assign: '=' is not allowed (position 7)"},
      {"width === 3", "does not assign"},
      {"width, gap", "one value; ',' separates two (position 6)"},
      {"\"width\"", "no texts (position 1)"},
      {"frobnicate(width)", "not a formula: unknown function 'frobnicate'"},
      {"sine(half_angle)", "did you mean 'sin'?"},
      {"sin + 1", "'sin' is a function: expected '(' (position 4)"},
      {"sin()", "sin wants an argument (position 5)"},
      {"sin(1, 2)", "sin takes 1 argument (position 6)"},
      {"atan2(1)", "atan2 takes 2 arguments (position 8)"},
      {"atan2(1, 2, 3)", "atan2 takes 2 arguments (position 11)"},
      {"gap < width < length", "comparisons are not chained"},
      {"gap < width == 1",
       "comparisons are not chained: write a < b && b < c, or parentheses "
       "(position 13)"},
      {"gap > 0 ? 1", "':' is missing between the two values of '?' (position 12)"},
      {"2 width", "'width' follows a number; a product needs '*' (position 3)"},
      {"2 pi", "a product needs '*'"},
      {"2 sin(1)", "a product needs '*'"},
      {"2 (width)", "unexpected '('"},
      {"5 furlongz", "unknown unit 'furlongz' (position 3)"},
      {"5 degC", "unknown unit 'degC'"},
      {"5 [2 mm]", "unknown unit '2 mm'"},
      {"5 []", "unknown unit ''"},
      {"5 [N/m", "']' is missing (position 3)"},
      {"5 mm^2", "can be read in two ways: write 5 [mm^2] or (5 mm)^2"},
      {"5 N/mm", "a unit of several symbols stands in brackets: 5 [N/mm]"},
      {"1e999*width", "out of range (position 1)"},
      {"width # 2", "unexpected '#' (position 7)"},
      {"width \x01", "an unexpected letter (position 7)"},
  }));
  CAPTURE(text);
  CHECK_THAT(complaint(text), Contains(reason));
}

TEST_CASE("long and deep formulas are refused, not crashed on") {
  const auto repeated = [](const std::string& part, int times) {
    std::string text;
    for (int i = 0; i < times; ++i) text += part;
    return text;
  };
  CHECK_NOTHROW(plain(repeated("(", 90) + "width" + repeated(")", 90)));
  CHECK_THAT(complaint(repeated("(", 4000) + "1" + repeated(")", 4000)),
             Contains("nested too deeply"));
  CHECK_THAT(complaint(repeated("-", 9000) + "1"), Contains("nested too deeply"));
  CHECK_THAT(complaint(repeated("2^", 4000) + "1"), Contains("nested too deeply"));
  CHECK_THAT(complaint(repeated("1?2:", 2000) + "1"), Contains("nested too deeply"));
  CHECK_THAT(complaint(repeated("sin(", 2000) + "1"), Contains("nested too deeply"));
  CHECK_THAT(complaint(repeated("1+", 5001) + "1"), Contains("expected at most 10000"));
  // long ones that are not deep are fine
  CHECK(value(plain(repeated("gap+", 2000) + "gap"), {0, 0, 1}) == 2001.0);
}

TEST_CASE("one formula serves many threads") {
  const Formula f = plain("length + width*gap");
  std::vector<std::jthread> threads;
  std::atomic<int> wrong{0};
  for (int k = 0; k < 4; ++k)
    threads.emplace_back([&, k] {
      for (int i = 0; i < 2000; ++i) {
        const std::vector<double> v{double(k), double(i), 1};
        if (f.value(v) != double(k + i)) ++wrong;
      }
    });
  threads.clear();
  CHECK(wrong == 0);
}

TEST_CASE("derivatives of formulas are exact") {
  // every function and operator, away from its kinks
  const auto text = GENERATE(
      as<std::string>(), "2*width + length - gap", "length^2/width", "length^3 + width^4*gap",
      "width^gap", "2^length", "-length^2", "+width*-gap", "length^-2", "(length+width)^2.5",
      "3*length*2 + 7 - length/3", "sin(length)", "cos(length*width)", "tan(width)", "asin(gap)",
      "acos(gap)", "atan(length)", "atan2(length, width)", "sinh(length)", "cosh(length)",
      "tanh(length)", "asinh(length)", "acosh(1 + length)", "atanh(gap)", "exp(length*width)",
      "ln(length)", "log(length)", "log2(length)", "log10(width)", "sqrt(length*gap)",
      "abs(gap - length)", "sign(length)*gap", "rint(length)*width", "min(length, width, gap*10)",
      "max(length, width^2, gap)", "sum(length, width^2, gap)", "avg(length, width, gap*gap)",
      "pi*length^2/4", "length > width ? length*gap : width",
      "length < width ? length*gap : width^2",
      "(length >= width)*gap + (length <= width) + (length == width) + (length != width)*gap",
      "(length > 0 && width > 0)*gap + (length < 0 || gap < 0)*length",
      "2*3*length/(width - 4*(gap - width))", "length*length*length", "1/(1 + exp(-length/gap))",
      "length*0.005 + !gap*width", "length/length + width^2^gap");
  CAPTURE(text);
  check_gradient(plain(text), {0.7, 0.31, 0.11});
}

TEST_CASE("derivatives of random formulas are exact") {
  std::mt19937 random(20240607);
  const auto pick = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
  const std::function<std::string(int)> part = [&](int depth) -> std::string {
    if (depth == 0) {
      const char* leaves[] = {"length", "width", "gap", "1.7", "3", "0.4"};
      return leaves[pick(6)];
    }
    const std::string a = part(depth - 1), b = part(pick(depth));
    const char* binary[] = {"+", "-", "*", "/"};
    const char* unary[] = {"sin(", "cos(", "atan(", "tanh(", "exp(-abs(", "sqrt(1 + abs("};
    switch (pick(5)) {
      case 0: {
        const int f = pick(6);
        return unary[f] + a + (f > 3 ? "))" : ")");
      }
      case 1:
        return "(2 + sin(" + a + "))^(" + b + "/(3 + abs(" + b + ")))";
      case 2:
        return (pick(2) ? "max(" : "min(") + a + ", " + b + ")";
      default:
        return "(" + a + " " + binary[pick(3)] + " " + b + "/(2 + cos(" + a + ")))";
    }
  };
  std::uniform_real_distribution<double> between(0.2, 1.5);
  int moving = 0;
  for (int i = 0; i < 300; ++i) {
    const std::string text = part(1 + i % 4);
    CAPTURE(text);
    const Formula f = plain(text);
    const std::vector<double> v{between(random), between(random), between(random)};
    if (text.find("max") == std::string::npos && text.find("min") == std::string::npos &&
        text.find("abs") == std::string::npos)
      check_gradient(f, v);  // elsewhere a kink may lie within the steps
    std::vector<double> slopes(f.slots().size());
    const auto here = f.gradient(v, slopes);
    REQUIRE(here);
    for (const double s : slopes) moving += s != 0;
    // the same on numbers with derivatives
    std::vector<Dual<3>> duals;
    for (int k = 0; k < 3; ++k) duals.push_back(Dual<3>::variable(v[std::size_t(k)], k));
    const auto dual = f.evaluate<Dual<3>>(duals);
    REQUIRE(dual);
    CHECK(dual->value == *here);
    for (std::size_t k = 0; k < slopes.size(); ++k)
      CHECK(dual->derivatives[static_cast<std::size_t>(f.slots()[k])] == slopes[k]);
  }
  CHECK(moving > 300);
}

TEST_CASE("at a kink the derivative is that of the branch that gives the value") {
  const auto slopes = [](const char* text, std::vector<double> v) {
    const Formula f = plain(text);
    std::vector<double> s(f.slots().size());
    REQUIRE(f.gradient(v, s));
    return s;
  };
  CHECK(slopes("min(length, 2*length)", {0, 0, 0}) == std::vector<double>{1});
  CHECK(slopes("max(width, length)", {1, 1, 0}) == std::vector<double>{0, 1});
  CHECK(slopes("abs(gap)", {0, 0, 0}) == std::vector<double>{0});
  CHECK(slopes("gap >= 0 ? 3*gap : sqrt(gap)", {0, 0, 0}) == std::vector<double>{3});
  CHECK(slopes("gap > 0 ? 1/gap : 3*gap", {0, 0, 0}) == std::vector<double>{3});
}

TEST_CASE("a derivative that is not finite is none") {
  double slope = 0;
  const std::span<double> one(&slope, 1);
  const std::vector<double> zero{0, 0, 0};
  CHECK_FALSE(plain("sqrt(gap)").gradient(zero, one));
  CHECK(plain("sqrt(gap)").value(zero) == 0.0);
  CHECK_FALSE(plain("1/gap").gradient(zero, one));
  CHECK(plain("gap^2 + gap^3 + 0*sqrt(0)").gradient(zero, one) == 0.0);
  CHECK(slope == 0.0);
}

TEST_CASE("random texts are formulas or refused, and never crash") {
  std::mt19937 random(7);
  const std::vector<std::string> pieces{"length", "width", "half_angle", "material.density",
                                        "sin(",   "max(",  "atan2(",     "avg(",
                                        "(",      ")",     ",",          "+",
                                        "-",      "*",     "/",          "^",
                                        "<",      "==",    "&&",         "||",
                                        "!",      "?",     ":",          "=",
                                        "1",      "2.5",   "1e9",        "5 mm",
                                        "[N/m]",  "[",     "]",          " ",
                                        "pi",     ".",     "e",          "%",
                                        "\xC2",   "\"",    "\x7f",       "1e",
                                        "deg",    "0",     "#",          "rint("};
  int formulas = 0;
  const std::vector<double> v(measures.size(), 0.3);
  for (int i = 0; i < 10000; ++i) {
    std::string text;
    const auto parts = random() % 12;
    for (unsigned k = 0; k < parts; ++k)
      text += i % 4 == 0 ? std::string(1, static_cast<char>(random() % 256))
                         : pieces[random() % pieces.size()];
    try {
      const Formula f(text, measures, at, i % 2 ? BareNumbers::may_be_si : BareNumbers::are_plain);
      std::vector<double> slopes(f.slots().size());
      f.value(v);
      f.gradient(v, slopes);
      ++formulas;
    } catch (const SpecError& error) {
      if (error.rule().empty()) FAIL("no reason for " << text);
    }
  }
  CHECK(formulas > 100);
  CHECK(formulas < 5000);
}

TEST_CASE("a name that stands for a formula counts as if that were written there") {
  const auto defined = [](const char* name, const Formula& formula,
                          std::vector<FormulaName> names) {
    names.push_back({name, "", std::make_shared<const Formula>(formula)});
    return names;
  };
  const Formula area = strict("length*width"), half = strict("gap + 1 mm"),
                loose("2.5*mass", measures, at, BareNumbers::may_be_si);
  const std::vector<FormulaName> names =
      defined("loose", loose, defined("half", half, defined("area", area, measures)));
  const std::vector<double> v{0.1, 0.02, 0.003, 0.5, 0.2, 1.5, 7800, 2e11, 3};
  for (const auto& [text, written] :
       {std::pair{"area", "length*width"},
        {"E*area^2/mass - sin(half/gap)*E*area^2/mass",
         "E*(length*width)^2/mass - sin((gap + 1 mm)/gap)*E*(length*width)^2/mass"},
        {"half < gap ? half : width", "(gap + 1 mm) < gap ? (gap + 1 mm) : width"}}) {
    const Formula by_name(text, names, at), whole = strict(written);
    CAPTURE(text);
    CHECK(*by_name.dimension() == *whole.dimension());
    CHECK(by_name.names() == whole.names());
    CHECK(*by_name.value(v) == *whole.value(v));
    std::vector<double> slopes(by_name.slots().size()), expected(whole.slots().size());
    REQUIRE(by_name.gradient(v, slopes));
    REQUIRE(whole.gradient(v, expected));
    CHECK(slopes == expected);
  }
  CHECK_THROWS_WITH(Formula("area + mass", names, at), Contains("an area") && Contains("a mass"));
  // a number that may be any quantity is so through the name
  CHECK(Formula("loose*length", names, at, BareNumbers::may_be_si).fits_anywhere());
}
