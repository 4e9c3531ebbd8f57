#include "optim/job/expression.hpp"

#include "core/spec/spec_error.hpp"

namespace flexopt {

Expression::Expression(std::string text, const std::vector<FormulaName>& parameters,
                       std::string pointer)
    : Formula(std::move(text), parameters, std::move(pointer), BareNumbers::may_be_si) {
  if (names().empty())
    throw SpecError(Formula::pointer(), Formula::text(), uses_no_name(parameters));
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

std::optional<VectorXd> Expression::gradient(const ParameterValues& values) const {
  VectorXd slopes(static_cast<Eigen::Index>(names().size()));
  if (!Formula::gradient(numbers(values), {slopes.data(), names().size()})) return std::nullopt;
  return slopes;
}

}  // namespace flexopt
