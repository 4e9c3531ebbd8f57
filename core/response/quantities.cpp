#include "core/response/quantities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <stdexcept>

#include "core/mechanism/drive.hpp"
#include "core/response/quantity_readers.hpp"

namespace flexopt {
namespace {

int components_of(const QuantityRow& row) {
  return std::max(1, static_cast<int>(row.components.size()));
}

Quantity named(const QuantityRow& row, int component, const std::string& drive = "") {
  Quantity q{row.name, {}, row.label, &row, component};
  const auto add = [&](const std::string& of) {
    q.name += "." + of;
    q.label += " " + of;
  };
  if (!drive.empty()) add(drive);
  if (!row.components.empty()) add(row.components[component % components_of(row)]);
  return q;
}

Quantity named(const QuantityRow& row, const NamedNumber& number) {
  return {number.quantity(), number.unit, row.label + " " + number.name, &row, number.component};
}

const Quantity& find(std::string_view name) {
  static const std::map<std::string, Quantity, std::less<>> all = [] {
    std::map<std::string, Quantity, std::less<>> map;
    for (const QuantityRow& row : quantity_rows())
      for (int k = 0; k < components_of(row) && !row.of_names; ++k) {
        Quantity q = named(row, k);
        map.emplace(q.name, std::move(q));
      }
    return map;
  }();
  const auto found = all.find(name);
  if (found == all.end())
    throw std::invalid_argument(fmt::format("no quantity of a path point is called '{}'", name));
  return found->second;
}

}  // namespace

std::string load_unit(Direction direction) { return is_rotation(direction) ? "N m" : "N"; }

std::string stiffness_unit(Direction direction) {
  return is_rotation(direction) ? "N m/rad" : "N/m";
}

const QuantityRow& row_of_named_quantities() {
  static const QuantityRow row{.name = "quantities",
                               .layout = Layout::object,
                               .label = "quantities of the job",
                               .needs = {Output::equilibrium},
                               .value = [](const PathPoint& p, int k) -> std::optional<double> {
                                 if (k >= std::ssize(p.named_quantities)) return std::nullopt;
                                 return p.named_quantities[static_cast<std::size_t>(k)].value;
                               },
                               .gradient = entry<&PointGradients::named_quantities>,
                               .in_report = true};
  return row;
}

std::optional<double> Quantity::value(const PathPoint& point) const {
  if (point.status != PointStatus::converged && row->needs.need_path()) return std::nullopt;
  return row->value(point, component);
}

std::optional<VectorXd> Quantity::gradient(const PathPoint& point,
                                           const PointGradients& gradients) const {
  return row->gradient(point, gradients, component);
}

bool is_answered(const QuantityRow& row, const StrokeRequest& request) {
  if (row.needs.has(Output::buckling)) return !request.buckling_load.empty();
  if (row.name == "bandwidth") return request.dynamics && request.loads.driven();
  if (row.of_names)
    return std::ranges::any_of(named_numbers(request),
                               [&](const NamedNumber& number) { return number.row == row.name; });
  if (row.name == "transmissibility") return request.dynamics && request.dynamics->transmissibility;
  if (row.needs.has(Output::load_capacity)) return request.capacity.any();
  if (row.needs.has(Output::stroke_capacity)) return !request.stroke_capacity.empty();
  if (row.name == "notch_stress") return request.stress.fillet.has_value();
  if (row.name == "yield_safety") return request.stress.yield;
  if (row.name == "fatigue_safety") return request.stress.fatigue;
  if (row.name == "fatigue_life") return request.stress.life;
  return true;
}

bool is_answered(const Quantity& quantity, const StrokeRequest& request) {
  if (quantity.row->needs.has(Output::load_capacity))
    return request.capacity.directions[quantity.component];
  if (quantity.row->needs.has(Output::stroke_capacity))
    return std::ranges::any_of(request.stroke_capacity, [&](const StrokeCapacityRule& rule) {
      return rule.drive == quantity.component / 2 && rule.ways[quantity.component % 2];
    });
  return is_answered(*quantity.row, request);
}

std::string why_missing(const PathPoint& point, const QuantityRow& row, int component) {
  if (row.needs.has(Output::buckling) && point.buckling)
    return (component == 0 ? point.buckling->drive_locked : point.buckling->drive_free).reason;
  if (row.needs.has(Output::load_capacity)) {
    const auto& capacity = point.load_capacity[component];
    return capacity ? capacity->reason : "";
  }
  if (component < std::ssize(point.stroke_capacity) && row.needs.has(Output::stroke_capacity)) {
    const auto& capacity = point.stroke_capacity[component];
    return capacity ? capacity->reason : "";
  }
  if (row.name == "bandwidth")
    return component < std::ssize(point.no_bandwidth) ? point.no_bandwidth[component].reason : "";
  if (row.name == "transfer_bandwidth")
    return component < std::ssize(point.transfers) ? point.transfers[component].no_bandwidth.reason
                                                   : "";
  if (row.name == "transmissibility") return point.no_transmissibility;
  if (!row.needs.has(Output::stress)) return "";
  return row.name.starts_with("fatigue") && point.fillet_fault.empty() ? point.fatigue_fault
                                                                       : point.fillet_fault;
}

DriveList::DriveList(Direction drive) : items{{{}, drive}} { prescribed[index(drive)] = true; }

DriveList::DriveList(const Mechanism& mechanism) : prescribed(prescribed_directions(mechanism)) {
  for (const Drive& drive : mechanism.drives)
    items.push_back({drive.name, drive.direction, !end_effector_direction(mechanism, drive),
                     drive.voice_coil.has_value(), drive.piezo.has_value()});
}

bool DriveList::offers(const QuantityRow& row, int component) const {
  if (row.of_supports && prescribed[component % 6]) return false;
  const auto drive = static_cast<std::size_t>(component / components_of(row));
  return !row.of_kind || (drive < items.size() && items[drive].*row.of_kind);
}

std::vector<Quantity> quantities(const DriveList& drives) {
  std::vector<Quantity> list;
  for (const QuantityRow& row : quantity_rows()) {
    if (row.of_drives) {
      for (int k = 0; k < std::ssize(drives.items) * components_of(row); ++k)
        if (drives.offers(row, k)) {
          const DriveList::Item& drive = drives.items[k / components_of(row)];
          list.push_back(named(row, k, drives.named() ? drive.name : ""));
          list.back().unit = row.unit(drive.direction, k % components_of(row));
        }
      continue;
    }
    if (row.of_names) {
      for (const NamedNumber& number : drives.numbers)
        if (number.row == row.name) list.push_back(named(row, number));
      continue;
    }
    for (int k = 0; k < components_of(row); ++k) {
      if (!drives.offers(row, k)) continue;
      list.push_back(named(row, k));
      list.back().unit = row.unit(drives.first(), k);
    }
  }
  for (int k = 0; k < std::ssize(drives.named_quantities); ++k) {
    const auto& [name, unit] = drives.named_quantities[static_cast<std::size_t>(k)];
    list.push_back({name, unit, name, &row_of_named_quantities(), k});
  }
  return list;
}

namespace {

// "drive_load.x", "gain.x.uy", "gauge.g1": the row, of the name where the point has it; or a
// quantity of the job.
std::optional<Quantity> of_point(const PathPoint& point, std::string_view name) {
  const auto named_so = std::ranges::find(point.named_quantities, name, &NamedQuantity::name);
  if (named_so != point.named_quantities.end())
    return Quantity{std::string(name), "", "", &row_of_named_quantities(),
                    static_cast<int>(named_so - point.named_quantities.begin())};
  for (const QuantityRow& row : quantity_rows()) {
    if (row.of_names && name.starts_with(row.name + "."))
      for (const NamedNumber& number : point.numbers)
        if (number.quantity() == name) return named(row, number);
    if (!row.of_drives || !name.starts_with(row.name + ".")) continue;
    const int each = components_of(row);
    for (int k = 0; k < std::ssize(point.drive_names) * each; ++k)
      if (Quantity q = named(row, k, point.drive_names[k / each]); q.name == name) return q;
  }
  return std::nullopt;
}

}  // namespace

std::optional<double> value_of(const PathPoint& point, std::string_view name) {
  const auto own = of_point(point, name);
  return own ? own->value(point) : find(name).value(point);
}

std::optional<VectorXd> gradient_of(const PathPoint& point, const PointGradients& gradients,
                                    std::string_view name) {
  const auto own = of_point(point, name);
  return own ? own->gradient(point, gradients) : find(name).gradient(point, gradients);
}

std::optional<double> at_least(const PathPoint& point, std::string_view name) {
  const auto own = of_point(point, name);
  const Quantity& q = own ? *own : find(name);
  return q.row->at_least ? q.row->at_least(point, q.component) : std::nullopt;
}

namespace {
// Row of a number, also under the name of any drive, or any that a request gives.
const QuantityRow& row_of(std::string_view name) {
  for (const QuantityRow& row : quantity_rows())
    if ((row.of_drives || row.of_names) && name.starts_with(row.name + ".")) return row;
  return *find(name).row;
}
}  // namespace

std::string why_missing(const PathPoint& point, std::string_view name) {
  const auto own = of_point(point, name);
  const Quantity& q = own ? *own : find(name);
  return why_missing(point, *q.row, q.component);
}

bool is_of_design(std::string_view name) { return row_of(name).of_design; }

const Outputs& needs_of(std::string_view name) { return row_of(name).needs; }

}  // namespace flexopt
