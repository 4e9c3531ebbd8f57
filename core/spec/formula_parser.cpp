#include "core/spec/formula_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <numbers>

#include "core/spec/formula_functions.hpp"
#include "core/spec/names.hpp"

namespace flexopt {
namespace {

constexpr int deepest_nesting = 200;  // a pair of parentheses counts twice

struct Comparison {
  std::string_view sign;
  FormulaOp op;
};
constexpr std::array comparisons{
    Comparison{"<", FormulaOp::less},    Comparison{"<=", FormulaOp::less_equal},
    Comparison{">", FormulaOp::greater}, Comparison{">=", FormulaOp::greater_equal},
    Comparison{"==", FormulaOp::equal},  Comparison{"!=", FormulaOp::unequal}};

/// Counts how deep the parts of a formula stand in each other.
class Deeper {
 public:
  explicit Deeper(int& depth) : depth_(depth) { ++depth_; }
  Deeper(const Deeper&) = delete;
  ~Deeper() { --depth_; }

 private:
  int& depth_;
};

}  // namespace

FormulaParser::FormulaParser(Formula& formula, const std::vector<FormulaName>& names,
                             BareNumbers bare)
    : formula_(formula), names_(names), may_be_si_(bare == BareNumbers::may_be_si) {}

void FormulaParser::parse() {
  const std::string& text = formula_.text_;
  if (text.size() > longest_formula)
    throw refuse(fmt::format("{} letters, expected at most {}", text.size(), longest_formula));
  if (text.find_first_not_of(" \t\r\n") == std::string::npos) {
    std::vector<std::string> known;
    for (const FormulaName& n : names_) known.push_back(n.name);
    throw refuse(fmt::format("expected a formula over: {}", fmt::join(known, ", ")));
  }
  read_tokens();
  const Part whole = choice();
  if (is(",")) throw no_formula("a formula has one value; ',' separates two", token().begin);
  if (token().kind != Kind::end) throw unexpected();
  if (whole.measure != Part::Measure::bare) formula_.dimension_ = whole.dimension;
  formula_.fits_anywhere_ = may_be_si_ && has_fraction_ && !has_unit_;
  // slots in ascending order; steps refer to them by their place
  std::vector<int> sorted = formula_.slots_;
  std::sort(sorted.begin(), sorted.end());
  for (Formula::Step& step : formula_.steps_)
    if (step.op == FormulaOp::name) {
      const int slot = formula_.slots_[step.slot];
      step.slot =
          static_cast<int>(std::lower_bound(sorted.begin(), sorted.end(), slot) - sorted.begin());
    }
  formula_.slots_ = std::move(sorted);
  for (const int slot : formula_.slots_) {
    const FormulaName& name = names_[slot];
    formula_.names_.push_back(name.name);
    formula_.units_.push_back(name.unit.empty() || name.unit == "1" ? "" : " [" + name.unit + "]");
  }
}

bool FormulaParser::is(std::string_view sign) const {
  return token().kind == Kind::sign && token().text == sign;
}

bool FormulaParser::accept(std::string_view sign) {
  if (!is(sign)) return false;
  ++at_;
  return true;
}

void FormulaParser::expect(std::string_view sign, const char* why) {
  if (accept(sign)) return;
  if (token().kind == Kind::end)
    throw no_formula(fmt::format("'{}' is missing {}", sign, why), token().begin);
  throw no_formula(fmt::format("unexpected '{}', expected '{}' {}", token().text, sign, why),
                   token().begin);
}

bool FormulaParser::is_constant(const Part& part) const {
  return formula_.steps_[part.step].op == FormulaOp::constant;
}

/// Appends the step; where its operands are constants it becomes one itself.
FormulaParser::Part FormulaParser::make(Formula::Step step, std::size_t begin, std::size_t end) {
  std::vector<Formula::Step>& steps = formula_.steps_;
  Part part;
  part.begin = begin;
  part.end = end;
  const bool leaf = step.op == FormulaOp::constant || step.op == FormulaOp::name;
  const auto of = [&](int operand) -> const Formula::Step& { return steps[operand]; };
  if (!leaf && of(step.a).op == FormulaOp::constant && of(step.b).op == FormulaOp::constant &&
      of(step.c).op == FormulaOp::constant) {
    Formula::Step folded;
    folded.number = value_of_step(step, of(step.a).number, of(step.b).number, of(step.c).number);
    // constants are single steps, so the operands are the last ones
    steps.resize(static_cast<std::size_t>(std::min({step.a, step.b, step.c})));
    step = folded;
  }
  part.step = static_cast<int>(steps.size());
  steps.push_back(step);
  return part;
}

FormulaParser::Part FormulaParser::make(FormulaOp op, const Part& a, const Part& b) {
  Formula::Step step;
  step.op = op;
  step.a = a.step;
  step.b = b.step;
  step.c = a.step;
  return make(step, a.begin, b.end);
}

FormulaParser::Part FormulaParser::alike(FormulaOp op, const Part& a, const Part& b,
                                         const char* verb) {
  Part result = make(op, a, b);
  measure_alike(result, a, b, verb);
  return result;
}

FormulaParser::Part FormulaParser::choice() {
  const Deeper deeper(depth_);
  if (depth_ > deepest_nesting) throw no_formula("it is nested too deeply", token().begin);
  const Part condition = either();
  if (!accept("?")) return condition;
  const Part yes = choice();
  expect(":", "between the two values of '?'");
  const Part no = choice();
  Formula::Step step;
  step.op = FormulaOp::choice;
  step.a = condition.step;
  step.b = yes.step;
  step.c = no.step;
  Part result = make(step, condition.begin, no.end);
  measure_alike(result, yes, no, "two values of one formula");
  return result;
}

FormulaParser::Part FormulaParser::either() {
  Part left = both();
  while (accept("||")) {
    left = make(FormulaOp::either, left, both());
    left.measure = Part::Measure::known;
  }
  return left;
}

FormulaParser::Part FormulaParser::both() {
  Part left = comparison();
  while (accept("&&")) {
    left = make(FormulaOp::both, left, comparison());
    left.measure = Part::Measure::known;
  }
  return left;
}

FormulaParser::Part FormulaParser::comparison() {
  const auto here = [&] {
    const auto found = std::ranges::find(comparisons, token().text, &Comparison::sign);
    return token().kind == Kind::sign && found != comparisons.end() ? &*found : nullptr;
  };
  const Part left = sum();
  const Comparison* compare = here();
  if (!compare) return left;
  ++at_;
  Part result = alike(compare->op, left, sum(), "compared");
  result.measure = Part::Measure::known;
  result.dimension = {};
  if (here())
    throw no_formula("comparisons are not chained: write a < b && b < c, or parentheses",
                     token().begin);
  return result;
}

FormulaParser::Part FormulaParser::sum() {
  Part left = product();
  while (is("+") || is("-")) {
    const bool plus = accept("+");
    if (!plus) ++at_;
    left = alike(plus ? FormulaOp::add : FormulaOp::subtract, left, product(),
                 plus ? "added" : "subtracted");
  }
  return left;
}

FormulaParser::Part FormulaParser::product() {
  Part left = factor();
  while (is("*") || is("/")) {
    const bool quotient = is("/");
    ++at_;
    const Part right = factor();
    Part result = make(quotient ? FormulaOp::divide : FormulaOp::multiply, left, right);
    measure_product(result, left, right, quotient);
    left = result;
  }
  return left;
}

FormulaParser::Part FormulaParser::factor() {
  const Deeper deeper(depth_);
  if (depth_ > deepest_nesting) throw no_formula("it is nested too deeply", token().begin);
  const std::size_t begin = token().begin;
  if (accept("+")) return factor();
  const bool minus = accept("-");
  if (!minus && !accept("!")) return power();
  const Part argument = factor();
  Formula::Step step;
  step.op = minus ? FormulaOp::minus : FormulaOp::negation;
  step.a = step.b = step.c = argument.step;
  Part result = make(step, begin, argument.end);
  result.measure = minus ? argument.measure : Part::Measure::known;
  result.fraction = argument.fraction;
  if (minus) result.dimension = argument.dimension;
  return result;
}

FormulaParser::Part FormulaParser::power() {
  const Part base = operand();
  if (!accept("^")) return base;
  const Part exponent = factor();  // binds from the right, and may have signs
  Part result;
  const Formula::Step& of_base = formula_.steps_[base.step];
  const double whole = formula_.steps_[exponent.step].number;
  if (of_base.op == FormulaOp::name && is_constant(exponent) &&
      (whole == 2 || whole == 3 || whole == 4)) {
    measure_power(result, base, exponent);
    Formula::Step step;
    step.op = FormulaOp::whole_power;
    step.number = whole;
    step.a = step.b = step.c = base.step;
    formula_.steps_.pop_back();  // the exponent
    const Part made = make(step, base.begin, exponent.end);
    result.step = made.step;
    result.begin = made.begin;
    result.end = made.end;
    return result;
  }
  measure_power(result, base, exponent);
  const Part made = make(FormulaOp::power, base, exponent);
  result.step = made.step;
  result.begin = made.begin;
  result.end = made.end;
  return result;
}

FormulaParser::Part FormulaParser::operand() {
  if (token().kind == Kind::number) return number();
  if (token().kind == Kind::name) {
    const Token& next = tokens_[at_ + 1];  // the end at the latest
    return next.kind == Kind::sign && next.text == "(" ? call() : name();
  }
  const std::size_t begin = token().begin;
  if (!accept("(")) throw unexpected();
  Part inner = choice();
  inner.begin = begin;
  inner.end = token().end;
  expect(")", "after the opening one");
  return inner;
}

FormulaParser::Part FormulaParser::number() {
  const Token& number = token();
  ++at_;
  Formula::Step step;
  step.number = number.number;
  Part result;
  if (number.unit.empty()) {
    result = make(step, number.begin, number.end);
    result.fraction = number.fraction;
    return result;
  }
  const std::optional<Measure> value = measured(number.number, number.unit);
  assert(value);
  step.number = value->value;
  result = make(step, number.begin, number.end);
  result.measure = Part::Measure::known;
  result.dimension = value->dimension;
  return result;
}

FormulaParser::Part FormulaParser::name() {
  const Token& name = token();
  ++at_;
  Formula::Step step;
  const auto found = std::ranges::find(names_, name.text, &FormulaName::name);
  if (found == names_.end()) {
    if (is_formula_word(name.text) && name.text != "pi")
      throw no_formula(fmt::format("'{}' is a function: expected '('", name.text), name.end);
    if (name.text != "pi") throw unknown(name);
    step.number = std::numbers::pi;
    Part result = make(step, name.begin, name.end);
    result.measure = Part::Measure::known;
    return result;
  }
  const auto slot = static_cast<int>(found - names_.begin());
  std::vector<int>& slots = formula_.slots_;
  auto used = std::find(slots.begin(), slots.end(), slot);
  if (used == slots.end()) used = slots.insert(slots.end(), slot);
  step.op = FormulaOp::name;
  step.slot = static_cast<int>(used - slots.begin());
  Part result = make(step, name.begin, name.end);
  if (found->unit.empty()) {
    result.fraction = true;
  } else {
    result.measure = Part::Measure::known;
    result.dimension = dimension_of(found->unit);
  }
  return result;
}

FormulaParser::Part FormulaParser::call() {
  const Token& name = token();
  at_ += 2;
  const FormulaFunction* one = find_function(name.text);
  const ListFunction* many = find_list_function(name.text);
  if (!one && !many)
    throw no_formula(fmt::format("unknown function '{}'; {}", name.text,
                                 known_names(name.text, function_names())),
                     name.begin);
  if (is(")")) throw no_formula(fmt::format("{} wants an argument", name.text), token().begin);
  Part result = choice();
  std::size_t count = 1;
  const std::size_t most = one ? 1 : many->most;
  for (; is(","); ++count) {
    if (count == most)
      throw no_formula(fmt::format("{} takes {} argument{}", name.text, most, most == 1 ? "" : "s"),
                       token().begin);
    ++at_;
    result = alike(many->op, result, choice(), "arguments of one function");
  }
  const Token& close = token();
  expect(")", "after the arguments");
  if (one) {
    result = apply(*one, result, name);
  } else if (many->op == FormulaOp::angle) {
    if (count != 2) throw no_formula("atan2 takes 2 arguments", close.begin);
    result.measure = Part::Measure::known;
    result.dimension = dimension_of("rad");
  } else if (name.text == "avg") {
    Formula::Step divisor;
    divisor.number = static_cast<double>(count);
    const Part by = make(divisor, close.begin, close.end), total = result;
    result = make(FormulaOp::divide, total, by);
    result.measure = total.measure;
    result.dimension = total.dimension;
    result.fraction = total.fraction;
  }
  result.begin = name.begin;
  result.end = close.end;
  return result;
}

}  // namespace flexopt
