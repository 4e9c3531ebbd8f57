// The tokens of a formula, and what is said of wrong ones.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "core/spec/formula_parser.hpp"
#include "core/spec/names.hpp"

namespace flexopt {
namespace {

bool is_space(char c) { return c == ' ' || c == '\t' || c == '\n' || c == '\r'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
/// Whether c may be part of a unit symbol; bytes of µ, ° and Ω in UTF-8 may.
bool is_unit_letter(char c) { return is_letter(c) || c == '%' || static_cast<signed char>(c) < 0; }

constexpr std::string_view two_letter_signs[] = {"<=", ">=", "==", "!=", "&&", "||"};
constexpr std::string_view one_letter_signs = "+-*/^()<>!?:,=";

std::string position(std::size_t at) { return fmt::format("position {}", at + 1); }

}  // namespace

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
  const std::vector<std::string> known = names_in(names_);
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

std::string FormulaParser::shown(const Part& part) const {
  constexpr std::size_t most = 40;
  std::string text = formula_.text_.substr(part.begin, part.end - part.begin);
  if (text.size() > most) text = text.substr(0, most) + "...";
  return fmt::format("'{}' ({})", text, position(part.begin));
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
    } else if (const auto name = text.substr(at + 1, text.find('\'', at + 1) - at - 1);
               c == '\'' && text.substr(at + 1 + name.size()).starts_with('\'') &&
               std::ranges::find(names_, name, &FormulaName::name) != names_.end()) {
      token.kind = Kind::name;
      token.text = name;
      token.end = at + name.size() + 2;
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

}  // namespace flexopt
