#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "results/cli/printed.hpp"
#include "results/files/units.hpp"

namespace flexopt {

namespace {

using Points = std::vector<const PathPoint*>;

/// First, unmoved and last converged point, each once.
Points shown_points(const StrokeResponse& response) {
  Points points;
  for (const PathPoint& point : response.path)
    if (point.status == PointStatus::converged) points.push_back(&point);
  if (points.size() <= 2) return points;
  const auto rest = std::ranges::min_element(
      points, {}, [](const PathPoint* point) { return std::abs(point->stroke); });
  Points chosen{points.front()};
  if (*rest != points.front() && *rest != points.back()) chosen.push_back(*rest);
  chosen.push_back(points.back());
  return chosen;
}

/// The softest of three directions from `first` on.
StrokeCell weakest_of(const QuantityRow& row, const PathPoint& point, int first) {
  StrokeCell weakest;
  for (int d = first; d < first + 3; ++d) {
    const auto value = row.value(point, d);
    if (value && (!weakest.value || *value < *weakest.value)) {
      weakest.value = value;
      weakest.direction = direction_names[static_cast<std::size_t>(d)];
    }
  }
  return weakest;
}

/// Rows of the weakest translation and rotation.
void add_weakest(const QuantityRow& row, const Points& points, std::vector<StrokeRow>& table) {
  for (const auto& [first, kind] : {std::pair{0, "translation"}, {3, "rotation"}}) {
    StrokeRow& added =
        table.emplace_back(StrokeRow{.label = fmt::format("weakest support, {}", kind),
                                     .quantity = row.name,
                                     .unit = row.unit(static_cast<Direction>(first), first)});
    for (const PathPoint* p : points) added.cells.push_back(weakest_of(row, *p, first));
  }
}

void add_number(const QuantityRow& row, const StrokeResponse& response, const Points& points,
                Direction drive, int component, const std::string& drive_name,
                std::vector<StrokeRow>& table) {
  StrokeRow& added = table.emplace_back(
      StrokeRow{.label = row.label + (drive_name.empty() ? "" : " " + drive_name),
                .quantity = row.name + (drive_name.empty() ? "" : "." + drive_name),
                .unit = row.unit(drive, row.components.empty() ? 0 : component)});
  for (const PathPoint& p : response.path)
    if (p.status == PointStatus::converged)
      added.largest = std::max(added.largest, std::abs(row.value(p, component).value_or(0)));
  for (const PathPoint* p : points) added.cells.push_back({row.value(*p, component)});
}

/// A row for each load that a capacity was asked for.
void add_capacities(const QuantityRow& row, const Points& points, const StrokeRequest& request,
                    std::vector<StrokeRow>& table) {
  for (std::size_t k = 0; k < request.capacity.directions.size(); ++k) {
    if (!request.capacity.directions[k]) continue;
    StrokeRow& added = table.emplace_back(StrokeRow{.label = row.label + " " + row.components[k],
                                                    .quantity = row.name + "." + row.components[k],
                                                    .unit = row.unit({}, static_cast<int>(k)),
                                                    .absent = "none"});
    for (const PathPoint* p : points) {
      StrokeCell& cell = added.cells.emplace_back();
      if (const auto& capacity = p->load_capacity[k]) {
        cell.value = capacity->value;
        cell.at_least = capacity->limit == CapacityLimit::none;
      }
    }
  }
}

void add_strokes(const Points& points, const DriveList& drives, const StrokeRequest& request,
                 std::vector<StrokeRow>& table) {
  const bool driven = request.loads.driven();
  if (drives.named() && driven) {
    for (std::size_t k = 0; k < drives.items.size(); ++k) {
      const auto& drive = drives.items[k];
      StrokeRow& added =
          table.emplace_back(StrokeRow{.label = "stroke " + drive.name,
                                       .quantity = "stroke." + drive.name,
                                       .unit = is_rotation(drive.direction) ? "rad" : "m"});
      for (const PathPoint* p : points) added.cells.push_back({p->strokes[k]});
    }
    return;
  }
  const std::string direction(direction_names[static_cast<std::size_t>(index(drives.first()))]);
  StrokeRow& added =
      table.emplace_back(StrokeRow{.label = driven ? "stroke " + direction : "load factor",
                                   .quantity = driven ? "stroke" : "load_factor",
                                   .unit = stroke_unit(drives, request)});
  for (const PathPoint* p : points) added.cells.push_back({p->stroke});
}

/// What the summary has in every job that asks for it, and what it has where it was asked for.
bool is_shown(const QuantityRow& row, const StrokeRequest& request) {
  constexpr std::array<std::string_view, 8> where_asked{
      "buckling_load_factor", "load_capacity", "notch_stress", "yield_safety",
      "fatigue_safety",       "fatigue_life",  "bandwidth",    "transmissibility"};
  if (row.in_summary != SummaryLine::none) return true;
  return std::ranges::find(where_asked, row.name) != where_asked.end() && is_answered(row, request);
}

}  // namespace

std::vector<StrokeRow> stroke_table(const StrokeResponse& response, const DriveList& drives,
                                    const StrokeRequest& request) {
  std::vector<StrokeRow> table;
  const Points points = shown_points(response);
  if (points.empty()) return table;
  add_strokes(points, drives, request, table);
  for (const QuantityRow& row : quantity_rows()) {
    if (!is_shown(row, request)) continue;
    if (row.needs.has(Output::load_capacity)) {
      add_capacities(row, points, request, table);
    } else if (row.in_summary == SummaryLine::weakest) {
      add_weakest(row, points, table);
    } else if (!row.of_drives) {
      add_number(row, response, points, drives.first(), 0, "", table);
    } else {
      for (std::size_t k = 0; k < drives.items.size(); ++k)
        add_number(row, response, points, drives.items[k].direction, static_cast<int>(k),
                   drives.named() ? drives.items[k].name : "", table);
    }
  }
  return table;
}

}  // namespace flexopt
