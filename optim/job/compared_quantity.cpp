#include "optim/job/compared_quantity.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>

#include "optim/job/expression.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/job/job_sections.hpp"

namespace flexopt {
namespace {

constexpr const char* both_lists = "frequencies";

// Surfaces, or an expansion at rest, for one number, and ratios many of which symmetry makes zero:
// compared where they are listed.
const Outputs where_listed{Output::envelope, Output::moving_envelope, Output::clearance,
                           Output::frequency_derivatives, Output::gain};

std::string name_of(const QuantityRow& row) {
  return row.name.starts_with("frequencies.") ? both_lists : row.name;
}

std::vector<const QuantityRow*> rows_of(const std::string& name) {
  std::vector<const QuantityRow*> rows;
  for (const QuantityRow& row : quantity_rows())
    if (name_of(row) == name) rows.push_back(&row);
  return rows;
}

// How many numbers of a row a point has at most.
int count_of(const QuantityRow& row, const Job& job, const DriveList& drives) {
  if (name_of(row) == both_lists) return job.request.frequencies;
  return std::max(1, static_cast<int>(row.components.size())) *
         (row.of_drives ? std::max(1, static_cast<int>(drives.items.size())) : 1);
}

// "x", or "x.ux", "x.uy", …
std::vector<std::string> parts_of(const QuantityRow& row, const std::string& drive) {
  std::vector<std::string> parts;
  for (const std::string& component : row.components) parts.push_back(drive + "." + component);
  return parts.empty() ? std::vector{drive} : parts;
}

ComparedQuantity compared(const std::string& name, const Job& job, const DriveList& drives) {
  ComparedQuantity quantity;
  quantity.name = name;
  for (const QuantityRow* row : rows_of(name)) {
    quantity.needs.add(row->needs);
    quantity.motion = row->error == ErrorKind::motion;
    quantity.of_design = row->of_design;
    if (row->of_names) {
      for (const NamedNumber& number : drives.numbers)
        if (number.row == name) {
          quantity.numbers.push_back({row, number.component, -1});
          quantity.parts.push_back(number.name);
        }
      quantity.part_key = "by_component";
      continue;
    }
    for (int k = 0; k < count_of(*row, job, drives); ++k) quantity.numbers.push_back({row, k, -1});
    if (name == both_lists || quantity.motion) continue;
    if (row->of_drives && drives.named())
      for (const DriveList::Item& drive : drives.items)
        for (const std::string& part : parts_of(*row, drive.name)) quantity.parts.push_back(part);
    else
      quantity.parts = row->components;
    const bool directions = row->of_supports || row->needs.has(Output::load_capacity);
    if (!quantity.parts.empty()) quantity.part_key = directions ? "by_direction" : "by_component";
  }
  if (!quantity.parts.empty())
    for (std::size_t k = 0; k < quantity.numbers.size(); ++k)
      quantity.numbers[k].part = static_cast<int>(k);
  return quantity;
}

bool is_answered(const std::string& name, const Job& job) {
  const std::vector<const QuantityRow*> rows = rows_of(name);
  return std::ranges::any_of(cases_of(job), [&](const JobCase& one) {
    return std::ranges::any_of(rows, [&](const QuantityRow* row) {
      return flexopt::is_answered(*row, one.request) && !row->of_kind &&
             !row->needs.has_any(where_listed);
    });
  });
}

}  // namespace

std::vector<std::string> comparable_quantities() {
  std::vector<std::string> names{"drive_load",  "support_stiffness",   "displacement",
                                 "frequencies", "parasitic_frequency", "max_stress"};
  for (const QuantityRow& row : quantity_rows())
    if (std::ranges::find(names, name_of(row)) == names.end()) names.push_back(name_of(row));
  return names;
}

std::vector<ComparedQuantity> compared_quantities(const Job& job) {
  assert(job.compare);
  const DriveList drives = drives_of(job, resolve(job.design)->family().drives);
  std::vector<ComparedQuantity> list;
  const std::vector<std::string>& listed = job.compare->quantities;
  for (const std::string& name : comparable_quantities()) {
    const bool wanted =
        listed.empty() ? is_answered(name, job) : std::ranges::find(listed, name) != listed.end();
    if (wanted) list.push_back(compared(name, job, drives));
  }
  for (int k = 0; k < std::ssize(job.quantities); ++k) {
    const auto& [name, formula] = job.quantities[static_cast<std::size_t>(k)];
    ComparedQuantity& own = list.emplace_back();
    own.name = name;
    own.numbers = {{&row_of_named_quantities(), k, -1}};
    for (const std::string& term : formula->quantities()) own.needs.add(flexopt::needs_of(term));
  }
  return list;
}

Outputs needs_of(const std::vector<ComparedQuantity>& quantities) {
  Outputs needs{Output::equilibrium};
  for (const ComparedQuantity& quantity : quantities) needs.add(quantity.needs);
  return needs;
}

Check check_comparison(const std::string& name, const StrokeRequest& request) {
  const std::vector<const QuantityRow*> rows = rows_of(name);
  assert(!rows.empty());
  const Outputs& needs = rows.front()->needs;
  if (needs.need_frequencies() && request.frequencies == 0)
    return Because("it needs \"frequencies\" of at least 1");
  if (needs.has(Output::frequency_derivatives) && !request.loads.driven())
    return Because("nothing is driven along a load_path: expected a stroke");
  if (needs.has(Output::buckling) && request.buckling_load.empty())
    return Because("it needs \"buckling\": {\"load\": …}, which says which load grows");
  if (needs.has(Output::load_capacity) && !request.capacity.any())
    return Because("it needs \"load_capacity\": {\"directions\": […]}");
  if (needs.has(Output::stroke_capacity) && request.stroke_capacity.empty())
    return Because("it needs \"stroke_capacity\": {…}");
  if (rows.front()->of_names && !is_answered(*rows.front(), request))
    return Because(fmt::format("the job names no such numbers: it needs {}",
                               name == "point"           ? "\"points\" with directions"
                               : name.starts_with("tra") ? "\"transfers\" of \"dynamics\""
                                                         : "\"gauges\" and \"bridges\""));
  if (Check answered = check_stress(name, request); !answered) return answered;
  return check_dynamics(name, request);
}

}  // namespace flexopt
