#include "results/start/start_design.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>

#include "core/spec/fault_list.hpp"
#include "designs/describe.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {

StartDesign start_design(const nlohmann::json& design, const std::string& folder) {
  FaultList faults;
  StartDesign start;
  start.family = design_source({{"design", design}}, folder, faults);
  faults.raise();
  if (start.family->drives.items.empty())
    throw SpecError("/drive", "nothing", "a new job prescribes the stroke of a drive");
  start.choices = default_choices(*start.family);
  start.values = usual_values(*start.family);
  start.material = materials().front().material;
  start.mechanism = start.make(start.values);
  return start;
}

double round_below(double value) {
  constexpr double rounding = 1e-9;
  const double power = std::pow(10.0, std::floor(std::log10(value) + rounding));
  double best = power;
  for (const double digit : {2.0, 5.0})
    if (digit * power <= value * (1 + rounding)) best = digit * power;
  return best;
}

OrderedJson readable(double value, const std::string& unit) {
  struct Shown {
    const char *si, *unit;
    double factor, from;  ///< of values that are at least so large
  };
  static constexpr std::array shown{Shown{"m", "m", 1, 1},
                                    Shown{"m", "mm", 1e3, 1e-5},
                                    Shown{"m", "um", 1e6, 0},
                                    Shown{"kg", "kg", 1, 0.1},
                                    Shown{"kg", "g", 1e3, 0},
                                    Shown{"Pa", "MPa", 1e-6, 0},
                                    Shown{"kg m^2", "kg mm^2", 1e6, 0},
                                    Shown{"rad", "deg", 180 / std::numbers::pi, 0}};
  if (unit == "1" || value == 0) return std::stod(fmt::format("{:.10g}", value));
  const auto fits = std::ranges::find_if(
      shown, [&](const Shown& of) { return unit == of.si && std::abs(value) >= of.from; });
  return fits == shown.end() ? fmt::format("{:.10g} {}", value, unit)
                             : fmt::format("{:.10g} {}", value * fits->factor, fits->unit);
}

}  // namespace flexopt
