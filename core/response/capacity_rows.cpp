// The rows of the table of quantities that say how far loads and strokes may go.
#include "core/response/quantities.hpp"

namespace flexopt {
namespace {

std::vector<std::string> signed_directions() {
  std::vector<std::string> names(direction_names.begin(), direction_names.end());
  for (const std::string_view name : direction_names) names.push_back("-" + std::string(name));
  return names;
}

// Value of a capacity that a limit ends, or (`open`) of one that none ends.
template <class Capacity>
std::optional<double> value_of(const std::optional<Capacity>& capacity, bool open) {
  if (!capacity || (capacity->limit == decltype(capacity->limit)::none) != open)
    return std::nullopt;
  return capacity->value;
}

template <bool open>
std::optional<double> largest_load(const PathPoint& p, int k) {
  return value_of(p.load_capacity[k], open);
}
template <bool open>
std::optional<double> largest_stroke(const PathPoint& p, int k) {
  return k < std::ssize(p.stroke_capacity) ? value_of(p.stroke_capacity[k], open) : std::nullopt;
}

}  // namespace

std::vector<QuantityRow> capacity_rows() {
  return {
      {.name = "load_capacity",
       .components = signed_directions(),
       .layout = Layout::object,
       .label = "load capacity",
       .meaning = "largest dead load at O along (or, with -, against) a direction, beside the "
                  "loads that act, drives held or free as the job's load_capacity says, before "
                  "the stress limit, a singular tangent or the stated loss of support stiffness; "
                  "load_capacity_limit says which",
       .needs = {Output::equilibrium, Output::load_capacity},
       .unit = [](Direction, int d) { return load_unit(static_cast<Direction>(d % 6)); },
       .value = largest_load<false>,
       .gradient = [](const PathPoint&, const PointGradients& g,
                      int d) { return g.load_capacity[d]; },
       .at_least = largest_load<true>,
       .error = ErrorKind::stress,  // which often ends it
       .in_report = true},
      {.name = "stroke_capacity",
       .components = {"forward", "backward"},
       .layout = Layout::object,
       .label = "largest stroke",
       .meaning = "size of the largest stroke from rest, other drives at rest, before the stress "
                  "limit, an instability, or what else the job's stroke_capacity states; "
                  "stroke_capacity_limit says which, and the drive load there",
       .needs = {Output::stroke_capacity},
       .unit = [](Direction d, int) -> std::string { return is_rotation(d) ? "rad" : "m"; },
       .value = largest_stroke<false>,
       .gradient = [](const PathPoint&, const PointGradients& g, int k) -> std::optional<VectorXd> {
         return k < std::ssize(g.stroke_capacity) ? g.stroke_capacity[k] : std::nullopt;
       },
       .at_least = largest_stroke<true>,
       .of_drives = true,
       .of_design = true,
       .in_report = true}};
}

}  // namespace flexopt
