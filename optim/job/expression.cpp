#include "optim/job/expression.hpp"

#include <fmt/format.h>
#include <algorithm>
#include <cassert>
#include <cmath>
#include <mutex>
#include <numbers>

#include "core/spec/spec_error.hpp"
#include "optim/job/expression_bytecode.hpp"

namespace flexopt {

struct Expression::Parsed {
  std::string text, pointer;
  std::vector<std::string> names;
  std::vector<double> values;  ///< where the parser reads; guarded by `mutex`
  mu::Parser parser;
  std::mutex mutex;

  void set(const ParameterValues& at) {
    for (std::size_t i = 0; i < names.size(); ++i) {
      const auto it = at.find(names[i]);
      assert(it != at.end());
      values[i] = it->second;
    }
  }
};

namespace {

/// Of names in formulas: those of the parser, and the point of material.density.
const char* const name_characters =
    "0123456789_.abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ";

std::string list(const std::vector<std::string>& names) {
  return fmt::format("{}", fmt::join(names, ", "));
}

/// muParser would take a lone '=' as an assignment to a parameter.
bool assigns(const std::string& text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '=') continue;
    if (i + 1 < text.size() && text[i + 1] == '=') {
      ++i;
      continue;
    }
    if (i == 0 || std::string_view("<>!").find(text[i - 1]) == std::string_view::npos) return true;
  }
  return false;
}

std::string lowered(std::string text) {
  if (!text.empty()) text.front() = static_cast<char>(std::tolower(text.front()));
  while (!text.empty() && text.back() == '.') text.pop_back();
  return text;
}

}  // namespace

Expression::Expression(std::string text, const std::vector<std::string>& parameters,
                       std::string pointer)
    : parsed_(std::make_shared<Parsed>()) {
  Parsed& p = *parsed_;
  p.text = std::move(text);
  p.pointer = std::move(pointer);
  const auto refuse = [&](const std::string& rule) -> SpecError {
    return {p.pointer, p.text, rule};
  };
  if (p.text.find_first_not_of(" \t\n") == std::string::npos)
    throw refuse("expected a formula over the design parameters: " + list(parameters));
  if (assigns(p.text))
    throw refuse("a formula has a value, it does not assign: '=' is not allowed");
  if (p.text.find('"') != std::string::npos) throw refuse("a formula holds numbers, no texts");
  try {
    p.parser.DefineNameChars(name_characters);
    define_signs(p.parser);
    p.parser.DefineConst("pi", std::numbers::pi);
    p.parser.SetExpr(p.text);
    for (const auto& [name, where] : p.parser.GetUsedVar()) p.names.push_back(name);
    for (const std::string& name : p.names)
      if (std::find(parameters.begin(), parameters.end(), name) == parameters.end())
        throw refuse(fmt::format("unknown name '{}'; the design parameters are: {}", name,
                                 list(parameters)));
    if (p.names.empty())
      throw refuse("the formula uses no design parameter; there are: " + list(parameters));
    p.values.assign(p.names.size(), 1.0);
    for (std::size_t i = 0; i < p.names.size(); ++i) p.parser.DefineVar(p.names[i], &p.values[i]);
    p.parser.Eval();  // parses
    if (p.parser.GetNumResults() != 1) throw refuse("a formula has one value; ',' separates two");
  } catch (const mu::Parser::exception_type& error) {
    throw refuse(
        fmt::format("not a formula: {} (position {})", lowered(error.GetMsg()), error.GetPos()));
  }
}

const std::string& Expression::text() const { return parsed_->text; }
const std::string& Expression::pointer() const { return parsed_->pointer; }
const std::vector<std::string>& Expression::names() const { return parsed_->names; }

std::optional<double> Expression::value(const ParameterValues& values) const {
  Parsed& p = *parsed_;
  const std::lock_guard lock(p.mutex);
  p.set(values);
  const double result = p.parser.Eval();
  if (!std::isfinite(result)) return std::nullopt;
  return result;
}

std::optional<VectorXd> Expression::gradient(const ParameterValues& values) const {
  Parsed& p = *parsed_;
  const std::lock_guard lock(p.mutex);
  p.set(values);
  const DualValue result = run_bytecode(p.parser, p.values);
  if (!std::isfinite(result.value) || !result.gradient.allFinite()) return std::nullopt;
  return result.gradient;
}

}  // namespace flexopt
