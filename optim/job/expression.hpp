#pragma once
// Formulas over design parameters and quantities, as a job writes them: "2*outer_width +
// inner_width", "support_stiffness.uz/drive_stiffness".
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "core/response/response.hpp"
#include "core/spec/formula.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// A formula over named numbers.
class Expression : public Formula {
 public:
  /// `parameters` and `quantities` are the names it may use; of one name, the parameter is meant.
  /// `pointer` is the JSON pointer of the text. Throws SpecError for what is no formula and for one
  /// that uses no name. Numbers without unit may be quantities in SI.
  Expression(std::string text, const std::vector<FormulaName>& parameters, std::string pointer,
             const std::vector<FormulaName>& quantities = {});

  /// Those of `names()` that are quantities. Without any, it is a formula of the parameters.
  const std::vector<std::string>& quantities() const { return quantities_; }
  /// SI unit of the value; "SI" where a number in the formula may be of any.
  std::string unit() const;
  /// The value; nothing where the formula is not finite (1/0, sqrt(-1)). `values` must hold every
  /// used name.
  std::optional<double> value(const ParameterValues& values) const;
  /// The value at a point of a path; nothing where the point lacks one of its quantities.
  std::optional<double> value(const PathPoint& point, ParameterValues parameters) const;
  /// Exact derivatives with respect to `names()`, in their order. Nothing where the value or a
  /// derivative is not finite.
  std::optional<VectorXd> gradient(const ParameterValues& values) const;

 private:
  std::vector<double> numbers(const ParameterValues& values) const;

  std::vector<std::string> quantities_;
};

}  // namespace flexopt
