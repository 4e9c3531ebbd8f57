#pragma once
// Formulas over design parameters, as a job writes them: "2*outer_width + inner_width".
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "core/spec/formula.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// A formula over named numbers.
class Expression {
 public:
  /// `parameters` are the names it may use; `pointer` is the JSON pointer of the text. Throws
  /// SpecError for what is no formula and for one that uses no parameter. Numbers without unit may
  /// be quantities in SI.
  Expression(std::string text, const std::vector<FormulaName>& parameters, std::string pointer);

  const std::string& text() const { return formula_.text(); }
  const std::string& pointer() const { return formula_.pointer(); }
  const Formula& formula() const { return formula_; }
  /// The parameters that the formula uses.
  const std::vector<std::string>& names() const { return names_; }
  /// The value; nothing where the formula is not finite (1/0, sqrt(-1)). `values` must hold every
  /// used name.
  std::optional<double> value(const ParameterValues& values) const;
  /// Exact derivatives with respect to `names()`, in their order. Nothing where the value or a
  /// derivative is not finite.
  std::optional<VectorXd> gradient(const ParameterValues& values) const;

 private:
  std::vector<double> numbers(const ParameterValues& values) const;

  Formula formula_;
  std::vector<std::string> names_;
  std::size_t numbers_ = 0;
};

}  // namespace flexopt
