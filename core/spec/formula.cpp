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

/// Whether small changes of the operands leave the value as it is.
bool is_flat(FormulaOp op) {
  switch (op) {
    case FormulaOp::less:
    case FormulaOp::less_equal:
    case FormulaOp::greater:
    case FormulaOp::greater_equal:
    case FormulaOp::equal:
    case FormulaOp::unequal:
    case FormulaOp::both:
    case FormulaOp::either:
    case FormulaOp::negation:
      return true;
    default:
      return false;
  }
}

/// An exponent 2, 3 or 4 of a name is multiplied out.
double whole_power(double x, int exponent) {
  double result = x;
  for (int k = 1; k < exponent; ++k) result *= x;
  return result;
}

}  // namespace

double value_of_step(const Formula::Step& step, double a, double b, double c) {
  switch (step.op) {
    case FormulaOp::constant:
    case FormulaOp::name:
      return step.number;
    case FormulaOp::minus:
      return -a;
    case FormulaOp::negation:
      return a == 0;
    case FormulaOp::function:
      return step.function->value(a);
    case FormulaOp::whole_power:
      return whole_power(a, static_cast<int>(step.number));
    case FormulaOp::add:
      return a + b;
    case FormulaOp::subtract:
      return a - b;
    case FormulaOp::multiply:
      return a * b;
    case FormulaOp::divide:
      return a / b;
    case FormulaOp::power:
      return std::pow(a, b);
    case FormulaOp::less:
      return a < b;
    case FormulaOp::less_equal:
      return a <= b;
    case FormulaOp::greater:
      return a > b;
    case FormulaOp::greater_equal:
      return a >= b;
    case FormulaOp::equal:
      return a == b;
    case FormulaOp::unequal:
      return a != b;
    case FormulaOp::both:
      return a != 0 && b != 0;
    case FormulaOp::either:
      return a != 0 || b != 0;
    case FormulaOp::least:
      return std::min(a, b);
    case FormulaOp::largest:
      return std::max(a, b);
    case FormulaOp::angle:
      return std::atan2(a, b);
    case FormulaOp::choice:
      return a != 0 ? b : c;
  }
  assert(false);
  return 0;
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

/// Adds d times the derivatives of a step's value by its operands a and b.
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
    if (visited[i] == 0 || is_flat(step.op)) continue;
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
