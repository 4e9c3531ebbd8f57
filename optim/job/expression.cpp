#include "optim/job/expression.hpp"

#include "core/spec/spec_error.hpp"

namespace flexopt {

Expression::Expression(std::string text, const std::vector<FormulaName>& parameters,
                       std::string pointer)
    : formula_(std::move(text), parameters, std::move(pointer), BareNumbers::may_be_si) {
  for (const int slot : formula_.slots())
    names_.push_back(parameters[static_cast<std::size_t>(slot)].name);
  if (names_.empty())
    throw SpecError(formula_.pointer(), formula_.text(), uses_no_name(parameters));
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
