// The dimensions of a formula's parts.
#include <fmt/format.h>

#include "core/spec/formula_parser.hpp"

namespace flexopt {

using enum FormulaMeasure;

/// A bare part takes the dimension of the other.
void FormulaParser::measure_alike(Part& result, const Part& a, const Part& b,
                                  const char* verb) const {
  using enum Part::Measure;
  if (a.measure == bare && b.measure == bare) {
    result.measure = bare;
    result.fraction = a.fraction || b.fraction;
    return;
  }
  const Part& leads = a.measure == bare || (a.measure == loose && b.measure == known) ? b : a;
  result.measure = leads.measure;
  result.dimension = leads.dimension;
  if (a.measure == bare || b.measure == bare || a.dimension == b.dimension) return;
  if (a.measure == known && b.measure == known)
    throw refuse(fmt::format("{} is {} and {} is {}: they cannot be {}", shown(a),
                             describe(a.dimension), shown(b), describe(b.dimension), verb));
}

void FormulaParser::measure_product(Part& result, const Part& a, const Part& b,
                                    bool quotient) const {
  using enum Part::Measure;
  if (a.measure == bare && b.measure == bare) {
    result.fraction = a.fraction || b.fraction;
    return;
  }
  result.measure = known;
  const auto hides = [&](const Part& part) {
    return part.measure == loose ||
           (part.measure == bare && part.fraction && may_be_si_ && !has_unit_);
  };
  if (hides(a) || hides(b)) result.measure = loose;
  result.dimension = quotient ? a.dimension / b.dimension : a.dimension * b.dimension;
}

void FormulaParser::measure_power(Part& result, const Part& base, const Part& exponent) const {
  using enum Part::Measure;
  if (exponent.measure == known && !exponent.dimension.is_plain())
    throw refuse(fmt::format("the exponent {} is {}, expected a plain number", shown(exponent),
                             describe(exponent.dimension)));
  if (base.measure == bare) {
    result.measure = exponent.measure == bare ? bare : known;
    result.fraction = base.fraction;
    if (base.fraction && exponent.measure != bare) result.measure = loose;
    return;
  }
  result.measure = base.measure;
  if (is_constant(exponent)) {
    const double power = formula_.steps_[exponent.step].number;
    result.dimension = base.dimension.power(power);
  } else if (base.measure == known && !base.dimension.is_plain()) {
    throw refuse(fmt::format("{} is {}: its exponent {} must be a constant", shown(base),
                             describe(base.dimension), shown(exponent)));
  }
}

FormulaParser::Part FormulaParser::apply(const FormulaFunction& function, const Part& argument,
                                         const Token& name) {
  using enum Part::Measure;
  Formula::Step step = unary(FormulaOp::function, argument);
  step.function = &function;
  Part result = make(step, name.begin, argument.end);
  result.measure = argument.measure;
  result.fraction = argument.fraction;
  const bool wants_plain = function.measure == plain || function.measure == FormulaMeasure::angle;
  if (wants_plain && argument.measure == known && !argument.dimension.is_plain())
    throw refuse(fmt::format("the argument {} of {} is {}, expected a plain number{}",
                             shown(argument), name.text, describe(argument.dimension),
                             function.measure == plain ? " or an angle" : ""));
  switch (function.measure) {
    case keeps:
      result.dimension = argument.dimension;
      break;
    case forgets:
      result.measure = known;
      break;
    case root:
      result.dimension = argument.dimension.power(0.5);
      break;
    case plain:
      break;
    case FormulaMeasure::angle:
      result.measure = known;
      result.dimension = dimension_of("rad");
      break;
  }
  return result;
}

}  // namespace flexopt
