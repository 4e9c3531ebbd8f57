#include "results/files/units.hpp"

#include <algorithm>

#include "optim/job/job_numbers.hpp"

namespace flexopt {

std::string stroke_unit(const DriveList& drives, const StrokeRequest& request) {
  if (!request.loads.driven()) return "1";
  return is_rotation(drives.first()) ? "rad" : "m";
}

std::string quantity_unit(const std::string& quantity, const DriveList& drives) {
  const auto known = quantities(drives);
  const auto found = std::ranges::find(known, quantity, &Quantity::name);
  return found == known.end() ? "" : found->unit;
}

std::string goal_unit(const std::string& quantity, const DriveList& drives) {
  return quantity.empty() ? "SI" : quantity_unit(quantity, drives);
}

std::string parameter_unit(const Family& family, const std::string& parameter) {
  const Parameter* found = find_parameter(family, parameter);
  return found ? found->unit : "";
}

}  // namespace flexopt
