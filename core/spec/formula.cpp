#include "core/spec/formula.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "core/spec/formula_parser.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

/// Numbers for the steps of a formula: on the stack unless there are unusually many.
class Scratch {
 public:
  explicit Scratch(std::size_t count) {
    if (count <= few_.size()) return;
    many_.resize(count);
    begin_ = many_.data();
  }
  Scratch(const Scratch&) = delete;
  double* begin() { return begin_; }

 private:
  std::array<double, 128> few_;
  std::vector<double> many_;
  double* begin_ = few_.data();
};

/// An exponent 2, 3 or 4 of a name is multiplied out.
double whole_power(double x, int exponent) {
  double result = x;
  for (int k = 1; k < exponent; ++k) result *= x;
  return result;
}

using Step = Formula::Step;

/// The values of the operations, in the order of FormulaOp.
constexpr std::array<double (*)(const Step& step, double a, double b, double c), 23> operations{
    [](const Step& step, double, double, double) { return step.number; },
    [](const Step& step, double, double, double) { return step.number; },
    [](const Step&, double a, double, double) -> double { return -a; },
    [](const Step&, double a, double, double) -> double { return a == 0; },
    [](const Step& step, double a, double, double) { return step.function->value(a); },
    [](const Step& step, double a, double, double) {
      return whole_power(a, static_cast<int>(step.number));
    },
    [](const Step&, double a, double b, double) -> double { return a + b; },
    [](const Step&, double a, double b, double) -> double { return a - b; },
    [](const Step&, double a, double b, double) -> double { return a * b; },
    [](const Step&, double a, double b, double) -> double { return a / b; },
    [](const Step&, double a, double b, double) -> double { return std::pow(a, b); },
    [](const Step&, double a, double b, double) -> double { return a < b; },
    [](const Step&, double a, double b, double) -> double { return a <= b; },
    [](const Step&, double a, double b, double) -> double { return a > b; },
    [](const Step&, double a, double b, double) -> double { return a >= b; },
    [](const Step&, double a, double b, double) -> double { return a == b; },
    [](const Step&, double a, double b, double) -> double { return a != b; },
    [](const Step&, double a, double b, double) -> double { return a != 0 && b != 0; },
    [](const Step&, double a, double b, double) -> double { return a != 0 || b != 0; },
    [](const Step&, double a, double b, double) -> double { return std::min(a, b); },
    [](const Step&, double a, double b, double) -> double { return std::max(a, b); },
    [](const Step&, double a, double b, double) -> double { return std::atan2(a, b); },
    [](const Step&, double a, double b, double c) { return a != 0 ? b : c; }};
static_assert(static_cast<std::size_t>(FormulaOp::choice) + 1 == operations.size());

}  // namespace

double value_of_step(const Step& step, double a, double b, double c) {
  return operations[static_cast<std::size_t>(step.op)](step, a, b, c);
}

Formula::Formula(std::string text, const std::vector<FormulaName>& names, std::string pointer,
                 BareNumbers bare)
    : text_(std::move(text)), pointer_(std::move(pointer)) {
  FormulaParser(*this, names, bare).parse();
}

void Formula::check_unit(const std::string& unit) const {
  if (!dimension_ || fits_anywhere_) return;
  const Dimension wanted = dimension_of(unit);
  if (*dimension_ == wanted) return;
  throw SpecError(pointer_, text_,
                  fmt::format("it is {}, expected {}", describe(*dimension_), describe(wanted)));
}

void Formula::move_to(std::span<const int> to) {
  for (int& slot : slots_) slot = to[slot];
  assert(std::is_sorted(slots_.begin(), slots_.end()));
}

std::string uses_no_name(const std::vector<FormulaName>& names) {
  std::vector<std::string> list;
  for (const FormulaName& n : names) list.push_back(n.name);
  return fmt::format("the formula uses no design parameter; there are: {}", fmt::join(list, ", "));
}

void Formula::values(std::span<const double> numbers, double* of) const {
  for (std::size_t i = 0; i < steps_.size(); ++i) {
    const Step& step = steps_[i];
    if (step.op == FormulaOp::constant)
      of[i] = step.number;
    else if (step.op == FormulaOp::name)
      of[i] = numbers[slots_[step.slot]];
    else
      of[i] = value_of_step(step, of[step.a], of[step.b], of[step.c]);
  }
}

std::optional<double> Formula::value(std::span<const double> numbers) const {
  Scratch scratch(steps_.size());
  values(numbers, scratch.begin());
  const double result = scratch.begin()[steps_.size() - 1];
  if (!std::isfinite(result)) return std::nullopt;
  return result;
}

namespace {

/// Adds d times the derivatives of a step's value by its operands a and b. Comparisons and logic
/// have none: small changes of the operands leave the value as it is.
template <class Add>
void add_slopes(const Formula::Step& step, double d, double a, double b, double value,
                const Add& add) {
  switch (step.op) {
    case FormulaOp::minus:
      add(step.a, -d);
      break;
    case FormulaOp::function:
      if (step.function->derivative) add(step.a, d * step.function->derivative(a, value));
      break;
    case FormulaOp::whole_power: {
      const int exponent = static_cast<int>(step.number);
      add(step.a, d * (exponent * whole_power(a, exponent - 1)));
      break;
    }
    case FormulaOp::add:
      add(step.a, d);
      add(step.b, d);
      break;
    case FormulaOp::subtract:
      add(step.a, d);
      add(step.b, -d);
      break;
    case FormulaOp::multiply:
      add(step.a, d * b);
      add(step.b, d * a);
      break;
    case FormulaOp::divide:
      add(step.a, d / b);
      add(step.b, -d * value / b);
      break;
    case FormulaOp::power:
      if (b != 0) add(step.a, d * (b * std::pow(a, b - 1)));
      add(step.b, d * (value * std::log(a)));
      break;
    case FormulaOp::least:
      add(b < a ? step.b : step.a, d);
      break;
    case FormulaOp::largest:
      add(a < b ? step.b : step.a, d);
      break;
    case FormulaOp::angle: {
      const double square = a * a + b * b;
      add(step.a, d * (b / square));
      add(step.b, d * (-a / square));
      break;
    }
    case FormulaOp::choice:
      add(a != 0 ? step.b : step.c, d);
      break;
    default:
      break;
  }
}

}  // namespace

// The reverse sweep: adjoint[i] = d value / d step i, complete when step i is reached from above.
// Only what gives the value is visited, so that 1/0 in a branch that is not taken does no harm.
std::optional<double> Formula::gradient(std::span<const double> numbers,
                                        std::span<double> slopes) const {
  assert(slopes.size() == slots_.size());
  const std::size_t n = steps_.size();
  Scratch values_of(n), adjoints(n), visits(n);
  double *of = values_of.begin(), *adjoint = adjoints.begin(), *visited = visits.begin();
  values(numbers, of);
  const double result = of[n - 1];
  std::fill(slopes.begin(), slopes.end(), 0.0);
  std::fill(adjoint, adjoint + n, 0.0);
  std::fill(visited, visited + n, 0.0);
  adjoint[n - 1] = visited[n - 1] = 1;
  for (std::size_t i = n; i-- > 0;) {
    const Step& step = steps_[i];
    if (visited[i] == 0) continue;
    const double d = adjoint[i], a = of[step.a], b = of[step.b];  // of leaves: not looked at
    const auto add = [&](int operand, double slope) {
      const auto k = static_cast<std::size_t>(operand);
      if (steps_[k].op == FormulaOp::constant) return;
      visited[k] = 1;
      adjoint[k] += slope;
    };
    if (step.op == FormulaOp::name)
      slopes[step.slot] += d;
    else
      add_slopes(step, d, a, b, of[i], add);
  }
  if (!std::isfinite(result) ||
      !std::all_of(slopes.begin(), slopes.end(), [](double s) { return std::isfinite(s); }))
    return std::nullopt;
  return result;
}

}  // namespace flexopt
