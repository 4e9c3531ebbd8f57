#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <nlohmann/json.hpp>

#include "core/spec/json_file.hpp"
#include "core/spec/names.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/job/job_tables.hpp"
#include "optim/solvers/problem.hpp"

namespace flexopt {

using nlohmann::json;
using Pointer = json::json_pointer;

namespace {

constexpr int starts_of_global = 8;

/// A power of two: Sobol's sequence is the most even there.
int default_screening(std::size_t variables) {
  constexpr unsigned of_each = 2000, most = 65536;
  return static_cast<int>(
      std::min(most, std::bit_ceil(of_each * static_cast<unsigned>(variables))));
}

OptimiserOptions options_of(const Algorithm& algorithm) {
  OptimiserOptions options;
  options.library = algorithm.library;
  options.name = algorithm.name;
  return options;
}

}  // namespace

Algorithm read_algorithm(json& read) {
  const Pointer at("/optimise/algorithm");
  Algorithm algorithm = algorithm_table().read(read);
  if (algorithm.library == "ipopt") {
    if (read.contains("name"))
      throw wrong(read, at, "name", "ipopt is one algorithm and takes no name");
    if (read.contains("local"))
      throw wrong(read, at, "local", "ipopt runs no other algorithm inside");
    algorithm.name.clear();
    return algorithm;
  }
  std::vector<std::string> names;
  for (const std::string& offered : algorithms())
    if (offered.starts_with("nlopt ")) names.push_back(offered.substr(6));
  if (std::find(names.begin(), names.end(), algorithm.name) == names.end())
    throw SpecError(at / "name", '"' + algorithm.name + '"',
                    "unknown algorithm; " + known_names(algorithm.name, names));
  const std::vector<std::string> locals = local_algorithms(options_of(algorithm));
  if (!algorithm.local.empty() && locals.empty())
    throw SpecError(at / "local", '"' + algorithm.local + '"',
                    algorithm.name + " runs no other algorithm inside; AUGLAG and MLSL do");
  if (algorithm.local.empty() && !locals.empty()) algorithm.local = locals.front();
  if (!locals.empty() && std::ranges::find(locals, algorithm.local) == locals.end())
    throw SpecError(
        at / "local", '"' + algorithm.local + '"',
        fmt::format("{} may run inside: {}", algorithm.name, known_names(algorithm.local, locals)));
  read = algorithm_table().write(algorithm);
  return algorithm;
}

void check_takes_goals(const OptimiseSpec& spec) {
  if (spec.constraints.empty() && !spec.pareto) return;
  check_takes_constraints(options_of(spec.algorithm));
}

void settle_search(json& read, OptimiseSpec& spec, FaultList& faults) {
  const auto refuse = [&](const char* place, const std::string& rule) {
    faults.add(std::string("/optimise") + place, shown(read.at(Pointer(place))), rule);
  };
  const bool global = spec.search == SearchKind::global;
  if (!read.contains("starts")) spec.starts = global ? starts_of_global : 1;
  read["starts"] = spec.starts;
  if (!global) {
    if (read.contains("screened_designs"))
      refuse("/screened_designs", "no design is screened unless \"search\" is \"global\"");
    return;
  }
  if (!read.contains("screened_designs"))
    spec.screened_designs = default_screening(spec.variables.size());
  read["screened_designs"] = spec.screened_designs;
  if (spec.spread != Spread::sobol) refuse("/spread", "a global search is spread by \"sobol\"");
  if (spec.algorithm.name.starts_with("G"))
    refuse("/algorithm/name",
           "it looks through the whole box itself; \"search\": \"global\" needs an algorithm that "
           "goes on from a design, as LD_SLSQP or LN_COBYLA do");
}

}  // namespace flexopt
