#pragma once
// The functions of formulas. Private to the formula's own sources.
#include <string>
#include <vector>

#include "core/spec/formula_parser.hpp"

namespace flexopt {

constexpr std::size_t longest_formula = 10000;  ///< letters

/// A function of several arguments: how many, and the operation that joins them.
struct ListFunction {
  std::string_view name;
  FormulaOp op;
  std::size_t most;  ///< arguments
};

/// The function of this name; null where there is none.
const FormulaFunction* find_function(std::string_view name);
const ListFunction* find_list_function(std::string_view name);

std::vector<std::string> function_names();

}  // namespace flexopt
