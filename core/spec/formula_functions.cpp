#include "core/spec/formula_parser.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

namespace flexopt {
namespace {

using std::numbers::ln10;
using std::numbers::ln2;
using enum FormulaMeasure;

// Lambdas pick the overload for double.
constexpr auto functions = std::to_array<FormulaFunction>({
    {"abs", [](double x) { return std::abs(x); },
     [](double x, double) { return x < 0   ? -1.0
                                   : x > 0 ? 1.0
                                           : 0.0; }, keeps},
    {"sign", [](double x) { return x < 0   ? -1.0
                                   : x > 0 ? 1.0
                                           : 0.0; }, nullptr, forgets},
    {"rint", [](double x) { return std::floor(x + 0.5); }, nullptr, keeps},
    {"round", [](double x) { return std::floor(x + 0.5); }, nullptr, keeps},
    {"sqrt", [](double x) { return std::sqrt(x); }, [](double, double y) { return 0.5 / y; }, root},
    {"exp", [](double x) { return std::exp(x); }, [](double, double y) { return y; }, plain},
    {"ln", [](double x) { return std::log(x); }, [](double x, double) { return 1 / x; }, plain},
    {"log", [](double x) { return std::log(x); }, [](double x, double) { return 1 / x; }, plain},
    {"log2", [](double x) { return std::log2(x); }, [](double x, double) { return 1 / (x * ln2); },
     plain},
    {"log10", [](double x) { return std::log10(x); },
     [](double x, double) { return 1 / (x * ln10); }, plain},
    {"sin", [](double x) { return std::sin(x); }, [](double x, double) { return std::cos(x); },
     plain},
    {"cos", [](double x) { return std::cos(x); }, [](double x, double) { return -std::sin(x); },
     plain},
    {"tan", [](double x) { return std::tan(x); }, [](double, double y) { return 1 + y * y; },
     plain},
    {"asin", [](double x) { return std::asin(x); },
     [](double x, double) { return 1 / std::sqrt(1 - x * x); }, FormulaMeasure::angle},
    {"acos", [](double x) { return std::acos(x); },
     [](double x, double) { return -1 / std::sqrt(1 - x * x); }, FormulaMeasure::angle},
    {"atan", [](double x) { return std::atan(x); },
     [](double x, double) { return 1 / (1 + x * x); }, FormulaMeasure::angle},
    {"sinh", [](double x) { return std::sinh(x); }, [](double x, double) { return std::cosh(x); },
     plain},
    {"cosh", [](double x) { return std::cosh(x); }, [](double x, double) { return std::sinh(x); },
     plain},
    {"tanh", [](double x) { return std::tanh(x); }, [](double, double y) { return 1 - y * y; },
     plain},
    {"asinh", [](double x) { return std::asinh(x); },
     [](double x, double) { return 1 / std::sqrt(x * x + 1); }, plain},
    {"acosh", [](double x) { return std::acosh(x); },
     [](double x, double) { return 1 / std::sqrt(x * x - 1); }, plain},
    {"atanh", [](double x) { return std::atanh(x); },
     [](double x, double) { return 1 / (1 - x * x); }, plain},
});

constexpr std::array list_functions{ListFunction{"min", FormulaOp::least, longest_formula},
                                    ListFunction{"max", FormulaOp::largest, longest_formula},
                                    ListFunction{"sum", FormulaOp::add, longest_formula},
                                    ListFunction{"avg", FormulaOp::add, longest_formula},
                                    ListFunction{"atan2", FormulaOp::angle, 2}};

template <class List>
auto find(const List& list, std::string_view name) {
  const auto found = std::ranges::find(list, name, [](const auto& entry) { return entry.name; });
  return found == list.end() ? nullptr : &*found;
}

}  // namespace

const FormulaFunction* find_function(std::string_view name) { return find(functions, name); }

const ListFunction* find_list_function(std::string_view name) { return find(list_functions, name); }

std::vector<std::string> function_names() {
  std::vector<std::string> names;
  for (const FormulaFunction& f : functions) names.emplace_back(f.name);
  for (const ListFunction& f : list_functions) names.emplace_back(f.name);
  return names;
}

bool is_formula_word(std::string_view word) {
  return word == "pi" || find_function(word) || find_list_function(word);
}

}  // namespace flexopt
