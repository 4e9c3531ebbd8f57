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
class Expression : public Formula {
 public:
  /// `parameters` are the names it may use; `pointer` is the JSON pointer of the text. Throws
  /// SpecError for what is no formula and for one that uses no parameter. Numbers without unit may
  /// be quantities in SI.
  Expression(std::string text, const std::vector<FormulaName>& parameters, std::string pointer);

  /// SI unit of the value; "SI" where a number in the formula may be of any.
  std::string unit() const;
  /// The value; nothing where the formula is not finite (1/0, sqrt(-1)). `values` must hold every
  /// used name.
  std::optional<double> value(const ParameterValues& values) const;
  /// Exact derivatives with respect to `names()`, in their order. Nothing where the value or a
  /// derivative is not finite.
  std::optional<VectorXd> gradient(const ParameterValues& values) const;

 private:
  std::vector<double> numbers(const ParameterValues& values) const;
};

}  // namespace flexopt
