#include "core/spec/formula_parser.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <numbers>

#include "core/spec/names.hpp"

namespace flexopt {
namespace {

constexpr std::size_t longest = 10000;
constexpr int deepest_nesting = 200;  // a pair of parentheses counts twice

using std::numbers::ln10;
using std::numbers::ln2;
using enum FormulaMeasure;

// Lambdas pick the overload for double.
constexpr std::array functions{
    FormulaFunction{"abs", [](double x) { return std::abs(x); },
                    [](double x, double) { return x < 0   ? -1.0
                                                  : x > 0 ? 1.0
                                                          : 0.0; }, keeps},
    FormulaFunction{"sign", [](double x) { return x < 0   ? -1.0
                                                  : x > 0 ? 1.0
                                                          : 0.0; }, nullptr,
                    forgets},
    FormulaFunction{"rint", [](double x) { return std::floor(x + 0.5); }, nullptr, keeps},
    FormulaFunction{"round", [](double x) { return std::floor(x + 0.5); }, nullptr, keeps},
    FormulaFunction{"sqrt", [](double x) { return std::sqrt(x); },
                    [](double, double y) { return 0.5 / y; }, root},
    FormulaFunction{"exp", [](double x) { return std::exp(x); }, [](double, double y) { return y; },
                    plain},
    FormulaFunction{"ln", [](double x) { return std::log(x); },
                    [](double x, double) { return 1 / x; }, plain},
    FormulaFunction{"log", [](double x) { return std::log(x); },
                    [](double x, double) { return 1 / x; }, plain},
    FormulaFunction{"log2", [](double x) { return std::log2(x); },
                    [](double x, double) { return 1 / (x * ln2); }, plain},
    FormulaFunction{"log10", [](double x) { return std::log10(x); },
                    [](double x, double) { return 1 / (x * ln10); }, plain},
    FormulaFunction{"sin", [](double x) { return std::sin(x); },
                    [](double x, double) { return std::cos(x); }, plain},
    FormulaFunction{"cos", [](double x) { return std::cos(x); },
                    [](double x, double) { return -std::sin(x); }, plain},
    FormulaFunction{"tan", [](double x) { return std::tan(x); },
                    [](double, double y) { return 1 + y * y; }, plain},
    FormulaFunction{"asin", [](double x) { return std::asin(x); },
                    [](double x, double) { return 1 / std::sqrt(1 - x * x); },
                    FormulaMeasure::angle},
    FormulaFunction{"acos", [](double x) { return std::acos(x); },
                    [](double x, double) { return -1 / std::sqrt(1 - x * x); },
                    FormulaMeasure::angle},
    FormulaFunction{"atan", [](double x) { return std::atan(x); },
                    [](double x, double) { return 1 / (1 + x * x); }, FormulaMeasure::angle},
    FormulaFunction{"sinh", [](double x) { return std::sinh(x); },
                    [](double x, double) { return std::cosh(x); }, plain},
    FormulaFunction{"cosh", [](double x) { return std::cosh(x); },
                    [](double x, double) { return std::sinh(x); }, plain},
    FormulaFunction{"tanh", [](double x) { return std::tanh(x); },
                    [](double, double y) { return 1 - y * y; }, plain},
    FormulaFunction{"asinh", [](double x) { return std::asinh(x); },
                    [](double x, double) { return 1 / std::sqrt(x * x + 1); }, plain},
    FormulaFunction{"acosh", [](double x) { return std::acosh(x); },
                    [](double x, double) { return 1 / std::sqrt(x * x - 1); }, plain},
    FormulaFunction{"atanh", [](double x) { return std::atanh(x); },
                    [](double x, double) { return 1 / (1 - x * x); }, plain},
};

/// Functions of several arguments: how many, and the operation that joins them.
struct ListFunction {
  std::string_view name;
  FormulaOp op;
  std::size_t most;  ///< arguments
};
constexpr std::array list_functions{
    ListFunction{"min", FormulaOp::least, longest},
    ListFunction{"max", FormulaOp::largest, longest}, ListFunction{"sum", FormulaOp::add, longest},
    ListFunction{"avg", FormulaOp::add, longest}, ListFunction{"atan2", FormulaOp::angle, 2}};

struct Comparison {
  std::string_view sign;
  FormulaOp op;
};
constexpr std::array comparisons{
    Comparison{"<", FormulaOp::less},    Comparison{"<=", FormulaOp::less_equal},
    Comparison{">", FormulaOp::greater}, Comparison{">=", FormulaOp::greater_equal},
    Comparison{"==", FormulaOp::equal},  Comparison{"!=", FormulaOp::unequal}};

template <class List>
auto find(const List& list, std::string_view name) {
  const auto found =
      std::find_if(list.begin(), list.end(), [&](const auto& entry) { return entry.name == name; });
  return found == list.end() ? nullptr : &*found;
}

std::vector<std::string> function_names() {
  std::vector<std::string> names;
  for (const FormulaFunction& f : functions) names.emplace_back(f.name);
  for (const ListFunction& f : list_functions) names.emplace_back(f.name);
  return names;
}

bool is_function(std::string_view name) {
  return find(functions, name) || find(list_functions, name);
}

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
/// Of unit symbols: µ, ° and Ω in UTF-8 as well.
bool is_unit_letter(char c) { return is_letter(c) || c == '%' || static_cast<signed char>(c) < 0; }

constexpr std::string_view two_letter_signs[] = {"<=", ">=", "==", "!=", "&&", "||"};
constexpr std::string_view one_letter_signs = "+-*/^()<>!?:,=";

std::string position(std::size_t at) { return fmt::format("position {}", at + 1); }

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

SpecError FormulaParser::refuse(const std::string& rule) const {
  constexpr std::size_t shown = 500;
  const std::string& text = formula_.text_;
  return {formula_.pointer_, text.size() > shown ? text.substr(0, shown) + "..." : text, rule};
}

SpecError FormulaParser::no_formula(const std::string& what, std::size_t at) const {
  return refuse(fmt::format("not a formula: {} ({})", what, position(at)));
}

SpecError FormulaParser::unexpected() const {
  if (token().kind == Kind::end)
    return no_formula("it ends where a value is expected", token().begin);
  return no_formula(fmt::format("unexpected '{}'", token().text), token().begin);
}

SpecError FormulaParser::unknown(const Token& name) const {
  std::vector<std::string> known;
  for (const FormulaName& n : names_) known.push_back(n.name);
  std::string rule =
      fmt::format("unknown name '{}' ({}); {}", name.text, position(name.begin),
                  known.empty() ? "a formula has no names here" : known_names(name.text, known));
  // 5 N/mm: the name after a number with a unit
  const auto at = static_cast<std::size_t>(&name - tokens_.data());
  if (at >= 2 && !tokens_[at - 2].unit.empty() &&
      (tokens_[at - 1].text == "/" || tokens_[at - 1].text == "*") &&
      measured(1, std::string(name.text)))
    rule +=
        fmt::format("; a unit of several symbols stands in brackets: {} [{}{}{}]",
                    tokens_[at - 2].text, tokens_[at - 2].unit, tokens_[at - 1].text, name.text);
  return refuse(rule);
}

void FormulaParser::parse() {
  const std::string& text = formula_.text_;
  if (text.size() > longest)
    throw refuse(fmt::format("{} letters, expected at most {}", text.size(), longest));
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
      const int slot = formula_.slots_[static_cast<std::size_t>(step.slot)];
      step.slot =
          static_cast<int>(std::lower_bound(sorted.begin(), sorted.end(), slot) - sorted.begin());
    }
  formula_.slots_ = std::move(sorted);
  for (const int slot : formula_.slots_) {
    const FormulaName& name = names_[static_cast<std::size_t>(slot)];
    formula_.names_.push_back(name.name);
    formula_.units_.push_back(name.unit.empty() || name.unit == "1" ? "" : " [" + name.unit + "]");
  }
}

void FormulaParser::read_tokens() {
  const std::string_view text = formula_.text_;
  std::size_t at = 0;
  while (true) {
    while (at < text.size() && is_space(text[at])) ++at;
    Token token;
    token.begin = token.end = at;
    if (at == text.size()) {
      tokens_.push_back(token);
      break;
    }
    const char c = text[at];
    if (is_digit(c) || (c == '.' && at + 1 < text.size() && is_digit(text[at + 1]))) {
      token = read_number(at);
    } else if (is_letter(c)) {
      token.kind = Kind::name;
      while (token.end < text.size() &&
             (is_letter(text[token.end]) || is_digit(text[token.end]) || text[token.end] == '.'))
        ++token.end;
      token.text = text.substr(at, token.end - at);
      for (const FormulaName& n : names_)
        has_fraction_ = has_fraction_ || (n.unit.empty() && n.name == token.text);
    } else {
      token.kind = Kind::sign;
      token.text = text.substr(at, 2);
      if (std::ranges::find(two_letter_signs, token.text) == std::end(two_letter_signs))
        token.text = text.substr(at, 1);
      token.end = at + token.text.size();
      if (c == '"' || c == '\'') throw no_formula("a formula holds numbers, no texts", at);
      if (token.text.size() == 1 && one_letter_signs.find(c) == std::string_view::npos)
        throw no_formula(c > ' ' && c <= '~' ? fmt::format("unexpected '{}'", c)
                                             : std::string("an unexpected letter"),
                         at);
      if (token.text == "=")
        throw refuse(fmt::format(
            "a formula has a value, it does not assign: '=' is not allowed ({})", position(at)));
    }
    at = token.end;
    has_unit_ = has_unit_ || !token.unit.empty();
    has_fraction_ = has_fraction_ || (token.fraction && token.unit.empty());
    tokens_.push_back(std::move(token));
  }
}

FormulaParser::Token FormulaParser::read_number(std::size_t begin) const {
  const std::string_view text = formula_.text_;
  Token token;
  token.kind = Kind::number;
  token.begin = begin;
  const auto [end, error] =
      std::from_chars(text.data() + begin, text.data() + text.size(), token.number);
  if (error != std::errc{}) throw no_formula("the number is out of range", begin);
  token.end = static_cast<std::size_t>(end - text.data());
  token.text = text.substr(begin, token.end - begin);
  token.fraction = token.text.find_first_of(".eE") != std::string_view::npos;
  read_unit(token);
  return token;
}

void FormulaParser::read_unit(Token& number) const {
  const std::string_view text = formula_.text_;
  std::size_t begin = number.end;
  while (begin < text.size() && is_space(text[begin])) ++begin;
  if (begin == text.size()) return;
  std::size_t end = begin;
  const bool brackets = text[begin] == '[';
  if (brackets) {
    end = text.find(']', begin);
    if (end == std::string_view::npos) throw no_formula("']' is missing", begin);
    number.unit = text.substr(begin + 1, end - begin - 1);
    ++end;
  } else {
    if (!is_unit_letter(text[begin])) return;
    while (end < text.size() && (is_unit_letter(text[end]) || is_digit(text[end]))) ++end;
    number.unit = text.substr(begin, end - begin);
    const bool known = std::ranges::find(names_, number.unit, &FormulaName::name) != names_.end();
    std::size_t after = end;
    while (after < text.size() && is_space(text[after])) ++after;
    const char next = after < text.size() ? text[after] : ' ';
    if (number.unit == "pi" || next == '(' || (known && !measured(1, number.unit)))
      throw no_formula(fmt::format("'{}' follows a number; a product needs '*'", number.unit),
                       begin);
    if (next == '^' && measured(1, number.unit))
      throw no_formula(fmt::format("'{0} {1}^' can be read in two ways: write {0} [{1}^2] or "
                                   "({0} {1})^2",
                                   number.text, number.unit),
                       begin);
  }
  const std::optional<Measure> value = measured(number.number, number.unit);
  if (!value)
    throw refuse(
        fmt::format("unknown unit '{}' ({}); expected a multiple of SI units, such as mm "
                    "or [N/m]",
                    number.unit, position(begin)));
  number.end = end;
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

std::string FormulaParser::shown(const Part& part) const {
  constexpr std::size_t most = 40;
  std::string text = formula_.text_.substr(part.begin, part.end - part.begin);
  if (text.size() > most) text = text.substr(0, most) + "...";
  return fmt::format("'{}' ({})", text, position(part.begin));
}

bool FormulaParser::is_constant(const Part& part) const {
  return formula_.steps_[static_cast<std::size_t>(part.step)].op == FormulaOp::constant;
}

/// Appends the step; where its operands are constants it becomes one itself.
FormulaParser::Part FormulaParser::make(Formula::Step step, std::size_t begin, std::size_t end) {
  std::vector<Formula::Step>& steps = formula_.steps_;
  Part part;
  part.begin = begin;
  part.end = end;
  const bool leaf = step.op == FormulaOp::constant || step.op == FormulaOp::name;
  const auto of = [&](int operand) -> const Formula::Step& {
    return steps[static_cast<std::size_t>(operand)];
  };
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

/// A bare part takes the dimension of the other.
void FormulaParser::measure_alike(Part& result, const Part& a, const Part& b,
                                  const char* verb) const {
  using enum Part::Measure;
  if (a.measure == bare && b.measure == bare) {
    result.measure = bare;
    result.fraction = a.fraction || b.fraction;
    return;
  }
  const Part& leads = a.measure == bare || (a.measure == loose && b.measure == known) ? b : a;
  result.measure = leads.measure;
  result.dimension = leads.dimension;
  if (a.measure == bare || b.measure == bare || a.dimension == b.dimension) return;
  if (a.measure == known && b.measure == known)
    throw refuse(fmt::format("{} is {} and {} is {}: they cannot be {}", shown(a),
                             describe(a.dimension), shown(b), describe(b.dimension), verb));
}

FormulaParser::Part FormulaParser::alike(FormulaOp op, const Part& a, const Part& b,
                                         const char* verb) {
  Part result = make(op, a, b);
  measure_alike(result, a, b, verb);
  return result;
}

void FormulaParser::measure_product(Part& result, const Part& a, const Part& b,
                                    bool quotient) const {
  using enum Part::Measure;
  if (a.measure == bare && b.measure == bare) {
    result.fraction = a.fraction || b.fraction;
    return;
  }
  result.measure = known;
  const auto hides = [&](const Part& part) {
    return part.measure == loose ||
           (part.measure == bare && part.fraction && may_be_si_ && !has_unit_);
  };
  if (hides(a) || hides(b)) result.measure = loose;
  result.dimension = quotient ? a.dimension / b.dimension : a.dimension * b.dimension;
}

void FormulaParser::measure_power(Part& result, const Part& base, const Part& exponent) const {
  using enum Part::Measure;
  if (exponent.measure == known && !exponent.dimension.is_plain())
    throw refuse(fmt::format("the exponent {} is {}, expected a plain number", shown(exponent),
                             describe(exponent.dimension)));
  if (base.measure == bare) {
    result.measure = exponent.measure == bare ? bare : known;
    result.fraction = base.fraction;
    if (base.fraction && exponent.measure != bare) result.measure = loose;
    return;
  }
  result.measure = base.measure;
  if (is_constant(exponent)) {
    const double power = formula_.steps_[static_cast<std::size_t>(exponent.step)].number;
    result.dimension = base.dimension.power(power);
  } else if (base.measure == known && !base.dimension.is_plain()) {
    throw refuse(fmt::format("{} is {}: its exponent {} must be a constant", shown(base),
                             describe(base.dimension), shown(exponent)));
  }
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
  const Formula::Step& of_base = formula_.steps_[static_cast<std::size_t>(base.step)];
  const double whole = formula_.steps_[static_cast<std::size_t>(exponent.step)].number;
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
    if (is_function(name.text))
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

FormulaParser::Part FormulaParser::apply(const FormulaFunction& function, const Part& argument,
                                         const Token& name) {
  using enum Part::Measure;
  Formula::Step step;
  step.op = FormulaOp::function;
  step.function = &function;
  step.a = step.b = step.c = argument.step;
  Part result = make(step, name.begin, argument.end);
  result.measure = argument.measure;
  result.fraction = argument.fraction;
  const bool wants_plain = function.measure == plain || function.measure == FormulaMeasure::angle;
  if (wants_plain && argument.measure == known && !argument.dimension.is_plain())
    throw refuse(fmt::format("the argument {} of {} is {}, expected a plain number{}",
                             shown(argument), name.text, describe(argument.dimension),
                             function.measure == plain ? " or an angle" : ""));
  switch (function.measure) {
    case keeps:
      result.dimension = argument.dimension;
      break;
    case forgets:
      result.measure = known;
      break;
    case root:
      result.dimension = argument.dimension.power(0.5);
      break;
    case plain:
      break;
    case FormulaMeasure::angle:
      result.measure = known;
      result.dimension = dimension_of("rad");
      break;
  }
  return result;
}

FormulaParser::Part FormulaParser::call() {
  const Token& name = token();
  at_ += 2;
  const FormulaFunction* one = find(functions, name.text);
  const ListFunction* many = find(list_functions, name.text);
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

bool is_formula_word(std::string_view word) { return word == "pi" || is_function(word); }

}  // namespace flexopt
