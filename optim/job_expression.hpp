#pragma once
// Formulas of the design parameters in a job: "2*outer_width + inner_width + 2*gap", in SI.
#include <optional>
#include <string>
#include <vector>

#include "designs/family.hpp"

namespace flexopt {

/// Value of the formula [SI]. May be NaN or infinite where the formula has no value (1/0).
/// Throws SpecError(pointer) for wrong syntax or an unknown name.
double evaluate_expression(const std::string& expression, const ParameterValues& parameters,
                           const std::string& pointer = "/expression");

/// The parameters that occur in it, sorted. Throws like evaluate_expression.
std::vector<std::string> expression_parameters(const std::string& expression,
                                               const ParameterValues& parameters,
                                               const std::string& pointer = "/expression");

/// The power n of the metre that the formula has, found by scaling every length in `lengths`;
/// nothing if it is a sum of different powers (which plain numbers in it make it, too).
std::optional<int> expression_length_power(const std::string& expression,
                                           const ParameterValues& parameters,
                                           const std::vector<std::string>& lengths);

}  // namespace flexopt
