#pragma once
// muParser's bytecode run with dual numbers: exact derivatives of a formula. Private to optim/.
#include <muParser.h>

#include <vector>

#include "core/math/types.hpp"

namespace flexopt {

/// Puts signs that the bytecode can be recognised by in place of the parser's own.
void define_signs(mu::Parser& parser);

/// A value and its derivatives with respect to the formula's variables.
struct DualValue {
  double value = 0;
  VectorXd gradient;
};

/// Runs the bytecode of a parsed formula at the numbers that its variables point to, which lie one
/// after the other in `variables`. Where a formula has a kink (abs, min, max, comparisons), the
/// derivative is that of the branch that gives the value.
DualValue run_bytecode(const mu::Parser& parser, const std::vector<double>& variables);

}  // namespace flexopt
