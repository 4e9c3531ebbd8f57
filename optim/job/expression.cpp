#include "optim/job/expression.hpp"

#include "core/response/quantities.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

namespace {

std::vector<FormulaName> joined(std::vector<FormulaName> names,
                                const std::vector<FormulaName>& more) {
  names.insert(names.end(), more.begin(), more.end());
  return names;
}

}  // namespace

Expression::Expression(std::string text, const std::vector<FormulaName>& parameters,
                       std::string pointer, const std::vector<FormulaName>& quantities)
    : Formula(std::move(text), joined(parameters, quantities), std::move(pointer),
              BareNumbers::may_be_si) {
  if (names().empty())
    throw SpecError(Formula::pointer(), Formula::text(), uses_no_name(parameters));
  for (std::size_t i = 0; i < names().size(); ++i)
    if (slots()[i] >= std::ssize(parameters)) quantities_.push_back(names()[i]);
}

std::string Expression::unit() const {
  return dimension() && !fits_anywhere() ? unit_of(*dimension()) : "SI";
}

std::vector<double> Expression::numbers(const ParameterValues& values) const {
  std::vector<double> numbers(static_cast<std::size_t>(slots().back()) + 1, 0.0);
  for (std::size_t i = 0; i < names().size(); ++i)
    numbers[static_cast<std::size_t>(slots()[i])] = values.at(names()[i]);
  return numbers;
}

std::optional<double> Expression::value(const ParameterValues& values) const {
  return Formula::value(numbers(values));
}

std::optional<double> Expression::value(const PathPoint& point, ParameterValues parameters) const {
  for (const std::string& name : quantities_) {
    const std::optional<double> number = value_of(point, name);
    if (!number) return std::nullopt;
    parameters[name] = *number;
  }
  return value(parameters);
}

std::optional<VectorXd> Expression::gradient(const ParameterValues& values) const {
  VectorXd slopes(static_cast<Eigen::Index>(names().size()));
  if (!Formula::gradient(numbers(values), {slopes.data(), names().size()})) return std::nullopt;
  return slopes;
}

}  // namespace flexopt
