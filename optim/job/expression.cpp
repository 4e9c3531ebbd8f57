#include "optim/job/expression.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "core/spec/spec_error.hpp"

namespace flexopt {
namespace {

std::vector<FormulaName> without_units(const std::vector<std::string>& names) {
  std::vector<FormulaName> list;
  for (const std::string& name : names) list.push_back({name, ""});
  return list;
}

}  // namespace

Expression::Expression(std::string text, const std::vector<std::string>& parameters,
                       std::string pointer)
    : formula_(std::move(text), without_units(parameters), std::move(pointer)) {
  for (const int slot : formula_.slots())
    names_.push_back(parameters[static_cast<std::size_t>(slot)]);
  if (names_.empty())
    throw SpecError(formula_.pointer(), formula_.text(),
                    fmt::format("the formula uses no design parameter; there are: {}",
                                fmt::join(parameters, ", ")));
  numbers_ = parameters.size();
}

std::vector<double> Expression::numbers(const ParameterValues& values) const {
  std::vector<double> numbers(numbers_, 0.0);
  for (std::size_t i = 0; i < names_.size(); ++i)
    numbers[static_cast<std::size_t>(formula_.slots()[i])] = values.at(names_[i]);
  return numbers;
}

std::optional<double> Expression::value(const ParameterValues& values) const {
  return formula_.value(numbers(values));
}

std::optional<VectorXd> Expression::gradient(const ParameterValues& values) const {
  VectorXd slopes(static_cast<Eigen::Index>(names_.size()));
  if (!formula_.gradient(numbers(values), {slopes.data(), names_.size()})) return std::nullopt;
  return slopes;
}

}  // namespace flexopt
