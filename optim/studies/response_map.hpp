#pragma once
// Quantities of a design over two of its parameters.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "optim/problem/design_problem.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/solvers/parallel.hpp"

namespace flexopt {

/// Values of one quantity; nothing where a design has none.
using MapValues = std::vector<std::optional<double>>;

struct ResponseMap {
  std::array<std::vector<double>, 2> parameters;  ///< their values, ascending [SI]
  /// For each quantity of the map, value (i, j) of the two parameters at i · (size of the second) +
  /// j.
  std::vector<MapValues> quantities;
  /// Distance to the nearest bound of the job's constraints, relative, negative where one is
  /// missed; none without constraints.
  MapValues margin;
  std::array<double, 2> held{};  ///< the parameters of the design itself
  bool looked_up = false;        ///< its leaves in an atlas
  int failed = 0;
  std::string first_failure;  ///< with its design
};

/// Map of the job's design with these parameters (formulas computed), on reduced leaves. The result
/// does not depend on the number of threads. `progress` is called after every design. `shared`: the
/// processes that share the designs; values are empty where this process does not learn them all.
ResponseMap evaluate_map(const Job& job, const MapSpec& map, const ParameterValues& parameters,
                         int threads, const StrokeEvaluator& evaluator = evaluate_stroke,
                         const LoopProgress& progress = {}, SharedUnits* shared = nullptr);

}  // namespace flexopt
