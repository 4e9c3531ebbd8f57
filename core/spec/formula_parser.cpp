#include "core/spec/formula_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <numbers>

#include "core/spec/names.hpp"

namespace flexopt {
namespace {

constexpr int deepest_nesting = 200;  // a pair of parentheses counts twice

/// A sign between two operands. Signs of a higher level bind more; those of one level, from the
/// left.
struct BinarySign {
  enum Level { either, both, comparison, sum, product };
  std::string_view sign;
  Level level;
  FormulaOp op;
  const char* verb = "compared";  ///< what is done to operands of one dimension
};
constexpr std::array binary_signs{
    BinarySign{"||", BinarySign::either, FormulaOp::either},
    BinarySign{"&&", BinarySign::both, FormulaOp::both},
    BinarySign{"<", BinarySign::comparison, FormulaOp::less},
    BinarySign{"<=", BinarySign::comparison, FormulaOp::less_equal},
    BinarySign{">", BinarySign::comparison, FormulaOp::greater},
    BinarySign{">=", BinarySign::comparison, FormulaOp::greater_equal},
    BinarySign{"==", BinarySign::comparison, FormulaOp::equal},
    BinarySign{"!=", BinarySign::comparison, FormulaOp::unequal},
    BinarySign{"+", BinarySign::sum, FormulaOp::add, "added"},
    BinarySign{"-", BinarySign::sum, FormulaOp::subtract, "subtracted"},
    BinarySign{"*", BinarySign::product, FormulaOp::multiply},
    BinarySign{"/", BinarySign::product, FormulaOp::divide}};

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
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw refuse(fmt::format("expected a formula over: {}", fmt::join(names_in(names_), ", ")));
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
  return make({.op = op, .a = a.step, .b = b.step, .c = a.step}, a.begin, b.end);
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
  const Part condition = binary(BinarySign::either);
  if (!accept("?")) return condition;
  const Part yes = choice();
  expect(":", "between the two values of '?'");
  const Part no = choice();
  Part result = make({.op = FormulaOp::choice, .a = condition.step, .b = yes.step, .c = no.step},
                     condition.begin, no.end);
  measure_alike(result, yes, no, "two values of one formula");
  return result;
}

FormulaParser::Part FormulaParser::binary(int level) {
  if (level > BinarySign::product) return factor();
  const auto here = [&] {
    const auto found = std::ranges::find(binary_signs, token().text, &BinarySign::sign);
    const bool is_such = token().kind == Kind::sign && found != binary_signs.end();
    return is_such && found->level == level ? &*found : nullptr;
  };
  Part left = binary(level + 1);
  while (const BinarySign* sign = here()) {
    ++at_;
    const Part right = binary(level + 1);
    Part result = make(sign->op, left, right);
    if (level == BinarySign::product)
      measure_product(result, left, right, sign->op == FormulaOp::divide);
    else if (level >= BinarySign::comparison)
      measure_alike(result, left, right, sign->verb);
    if (level <= BinarySign::comparison) {  // true or false
      result.measure = Part::Measure::known;
      result.dimension = {};
    }
    left = result;
    if (level == BinarySign::comparison && here())
      throw no_formula("comparisons are not chained: write a < b && b < c, or parentheses",
                       token().begin);
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
  Part result =
      make(unary(minus ? FormulaOp::minus : FormulaOp::negation, argument), begin, argument.end);
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
  measure_power(result, base, exponent);
  Formula::Step step{.op = FormulaOp::power, .a = base.step, .b = exponent.step, .c = base.step};
  const double whole = formula_.steps_[exponent.step].number;
  if (formula_.steps_[base.step].op == FormulaOp::name && is_constant(exponent) &&
      (whole == 2 || whole == 3 || whole == 4)) {
    step = unary(FormulaOp::whole_power, base);
    step.number = whole;
    formula_.steps_.pop_back();  // the exponent
  }
  const Part made = make(step, base.begin, exponent.end);
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
  if (number.unit.empty()) {
    Part result = make({.number = number.number}, number.begin, number.end);
    result.fraction = number.fraction;
    return result;
  }
  const std::optional<Measure> value = measured(number.number, number.unit);
  assert(value);
  Part result = make({.number = value->value}, number.begin, number.end);
  result.measure = Part::Measure::known;
  result.dimension = value->dimension;
  return result;
}

FormulaParser::Part FormulaParser::name() {
  const Token& name = token();
  ++at_;
  const auto found = std::ranges::find(names_, name.text, &FormulaName::name);
  if (found == names_.end()) {
    if (is_formula_word(name.text) && name.text != "pi")
      throw no_formula(fmt::format("'{}' is a function: expected '('", name.text), name.end);
    if (name.text != "pi") throw unknown(name);
    Part result = make({.number = std::numbers::pi}, name.begin, name.end);
    result.measure = Part::Measure::known;
    return result;
  }
  if (found->definition) return defined(*found->definition, name);
  Part result = make({.op = FormulaOp::name, .slot = slot_of(*found)}, name.begin, name.end);
  if (found->unit.empty()) {
    result.fraction = true;
  } else {
    result.measure = Part::Measure::known;
    result.dimension = dimension_of(found->unit);
  }
  return result;
}

int FormulaParser::slot_of(const FormulaName& name) {
  const auto slot = static_cast<int>(&name - names_.data());
  std::vector<int>& slots = formula_.slots_;
  auto used = std::find(slots.begin(), slots.end(), slot);
  if (used == slots.end()) used = slots.insert(slots.end(), slot);
  return static_cast<int>(used - slots.begin());
}

/// The steps of another formula, as if they were written here.
FormulaParser::Part FormulaParser::defined(const Formula& formula, const Token& name) {
  std::vector<Formula::Step>& steps = formula_.steps_;
  if (steps.size() + formula.steps_.size() > longest_formula)
    throw refuse(fmt::format("with what its names stand for it has more than {} operations",
                             longest_formula));
  const auto first = static_cast<int>(steps.size());
  for (Formula::Step step : formula.steps_) {
    step.a += first;
    step.b += first;
    step.c += first;
    if (step.op == FormulaOp::name) {
      const auto used = std::ranges::find(
          names_, formula.names_[static_cast<std::size_t>(step.slot)], &FormulaName::name);
      assert(used != names_.end());
      step.slot = slot_of(*used);
    }
    steps.push_back(step);
  }
  has_fraction_ = has_fraction_ || formula.fits_anywhere_;
  Part result;
  result.step = static_cast<int>(steps.size()) - 1;
  result.begin = name.begin;
  result.end = name.end;
  result.measure = formula.fits_anywhere_ ? Part::Measure::loose
                   : formula.dimension_   ? Part::Measure::known
                                          : Part::Measure::bare;
  result.dimension = formula.dimension_.value_or(Dimension());
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
    const Part by = make({.number = static_cast<double>(count)}, close.begin, close.end),
               total = result;
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
