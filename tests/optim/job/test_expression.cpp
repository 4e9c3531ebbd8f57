#include "optim/job/expression.hpp"

#include <catch2/catch.hpp>
#include <thread>

#include "core/spec/spec_error.hpp"

using namespace flexopt;
using Catch::Matchers::Contains;

namespace {
const std::vector<std::string> names{"length", "width", "gap"};
Expression make(const std::string& text) { return {text, names, "/optimise/constraints/0"}; }
}  // namespace

TEST_CASE("a formula has the value that mathematics gives it", "[optim]") {
  const ParameterValues v{{"length", 0.1}, {"width", 0.03}, {"gap", 0.001}};
  CHECK(*make("2*width + length - gap").value(v) == Approx(0.159));
  CHECK(*make("length^2/width").value(v) == Approx(1.0 / 3));
  CHECK(*make("max(length, width) + min(gap, 1) + abs(-gap)").value(v) == Approx(0.102));
  CHECK(*make("cos(pi*length*10)").value(v) == Approx(-1));
  CHECK(*make("(length >= width)*gap").value(v) == Approx(0.001));
  CHECK(*make("1e-3*length").value(v) == Approx(1e-4));
  CHECK(make("gap + width*gap").names() == std::vector<std::string>{"gap", "width"});
}

TEST_CASE("a formula that is not finite has no value", "[optim]") {
  CHECK_FALSE(make("1/gap").value({{"gap", 0.0}}));
  CHECK_FALSE(make("sqrt(gap)").value({{"gap", -1.0}}));
  CHECK(make("sqrt(gap)").value({{"gap", 4.0}}) == 2.0);
}

TEST_CASE("wrong formulas are refused with place and reason", "[optim]") {
  const auto [text, reason] = GENERATE(table<std::string, std::string>({
      {"2*outer_width",
       "unknown name 'outer_width'; the design parameters are: length, width, gap"},
      {"2*(width", "not a formula"},
      {"width +", "not a formula"},
      {"width width", "not a formula"},
      {"", "expected a formula"},
      {"  ", "expected a formula"},
      {"3 + 4", "uses no design parameter"},
      {"width = 3", "does not assign"},
      {"width, gap", "one value"},
      {"\"width\"", "no texts"},
      {"frobnicate(width)", "not a formula"},
  }));
  CAPTURE(text);
  CHECK_THROWS_AS(make(text), SpecError);
  CHECK_THROWS_WITH(make(text), Contains("/optimise/constraints/0") && Contains(reason));
}

TEST_CASE("one formula serves many threads", "[optim]") {
  const Expression e = make("length + width*gap");
  std::vector<std::jthread> threads;
  std::atomic<int> wrong{0};
  for (int k = 0; k < 4; ++k)
    threads.emplace_back([&, k] {
      for (int i = 0; i < 2000; ++i)
        if (*e.value({{"length", k}, {"width", i}, {"gap", 1}}) != k + i) ++wrong;
    });
  threads.clear();
  CHECK(wrong == 0);
}

TEST_CASE("derivatives of formulas are exact", "[optim]") {
  // every function and operator that the parser knows, away from its kinks
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
      "2*3*length/(width - 4*(gap - width))", "length*length*length", "1/(1 + exp(-length/gap))");
  CAPTURE(text);
  const ParameterValues at{{"length", 0.7}, {"width", 0.31}, {"gap", 0.11}};
  const Expression e = make(text);
  const auto gradient = e.gradient(at);
  REQUIRE(gradient);
  REQUIRE(gradient->size() == static_cast<Eigen::Index>(e.names().size()));
  for (std::size_t i = 0; i < e.names().size(); ++i) {
    CAPTURE(e.names()[i]);
    // extrapolated differences: error h⁴ of the fifth derivative and rounding, below 1e-9
    const auto slope = [&](double h) {
      ParameterValues up = at, down = at;
      up[e.names()[i]] += h;
      down[e.names()[i]] -= h;
      return (*e.value(up) - *e.value(down)) / (2 * h);
    };
    const double expected = (4 * slope(5e-4) - slope(1e-3)) / 3;
    CHECK((*gradient)[static_cast<Eigen::Index>(i)] == Approx(expected).epsilon(1e-8).margin(1e-9));
  }
}

TEST_CASE("a derivative that is not finite is none", "[optim]") {
  CHECK_FALSE(make("sqrt(gap)").gradient({{"gap", 0.0}}));
  CHECK(make("sqrt(gap)").value({{"gap", 0.0}}) == 0.0);
  CHECK_FALSE(make("1/gap").gradient({{"gap", 0.0}}));
  CHECK((*make("gap^2 + gap^3 + 0*sqrt(0)").gradient({{"gap", 0.0}}))[0] == 0.0);
}
