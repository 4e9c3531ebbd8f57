#pragma once
// Formulas over design parameters, as a job writes them: "2*outer_width + inner_width".
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/math/types.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// A formula over parameter names; every parameter stands for its SI value. Understands + - * / ^,
/// parentheses, comparisons, min, max, abs, sqrt, exp, ln, log10, sin, cos, tan, … and `pi`.
/// Copies share the parsed formula; evaluation is thread-safe.
class Expression {
 public:
  /// `parameters` are the names it may use; `pointer` is the JSON pointer of the text. Throws
  /// SpecError for bad syntax, for an unknown name (the rule lists the known ones) and for a
  /// formula that uses no parameter.
  Expression(std::string text, const std::vector<std::string>& parameters, std::string pointer);

  const std::string& text() const;
  const std::string& pointer() const;
  /// The parameters that the formula uses, in alphabetical order.
  const std::vector<std::string>& names() const;
  /// Nothing where the formula is not finite (1/0, sqrt(-1)). `values` must hold every used name.
  std::optional<double> value(const ParameterValues& values) const;
  /// Exact derivatives with respect to `names()`, in their order, by dual numbers on the parsed
  /// formula; at a kink those of the branch that gives the value. Nothing where the value or a
  /// derivative is not finite.
  std::optional<VectorXd> gradient(const ParameterValues& values) const;

 private:
  struct Parsed;
  std::shared_ptr<Parsed> parsed_;
};

}  // namespace flexopt
