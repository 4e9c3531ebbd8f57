#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string_view>

#include "results/cli/printed.hpp"
#include "results/files/result_parts.hpp"

namespace flexopt {

namespace {

std::string shown(const std::optional<double>& value, const std::string& unit) {
  return value ? quantity_text(*value, unit) : "-";
}

/// Whether the numbers of a path are those of some reduced leaf: else full accuracy says the same.
bool some_leaf_reduced(const std::vector<PathPoint>& path) {
  return std::ranges::any_of(path, [](const PathPoint& p) {
    return std::ranges::any_of(p.leaves, [](const LeafReport& l) { return l.model != "full"; });
  });
}

/// Shows rounding noise as zero: relative to the largest value of its kind, and where a mechanism
/// at rest has nothing else.
double without_noise(double value, double largest, const std::string& unit) {
  const double nothing = unit == "N" || unit == "N m" ? 1e-12 : unit == "Pa" ? 1e-2 : 0;
  return std::abs(value) <= std::max(1e-9 * largest, nothing) ? 0 : value;
}

std::string line(const std::string& name, const std::vector<std::string>& cells) {
  std::string text = fmt::format("  {:<28}", name);
  for (const std::string& cell : cells) text += fmt::format(" {:>22}", cell);
  return text + "\n";
}

/// The largest stroke of each drive either way, the load there, and what ends it.
std::string stroke_capacity_lines(const PathPoint& point, const DriveList& drives) {
  std::string text;
  for (const Quantity& q : quantities(drives)) {
    const auto k = static_cast<std::size_t>(q.component);
    if (!q.row->needs.has(Output::stroke_capacity) || k >= point.stroke_capacity.size()) continue;
    const auto& capacity = point.stroke_capacity[k];
    if (!capacity) continue;
    const bool open = capacity->limit == StrokeLimit::none;
    text += line(q.label, {(open ? "> " : "") + shown(capacity->value, q.unit),
                           shown(capacity->drive_load, load_unit(drives.items[k / 2].direction))});
    text += fmt::format("    {}\n", capacity->reason);
  }
  return text;
}

/// The rows of the table with a designer's units.
std::string stroke_lines(const StrokeResponse& response, const DriveList& drives,
                         const StrokeRequest& request) {
  std::string text, reasons;
  const std::vector<StrokeRow> table = stroke_table(response, drives, request);
  for (const StrokeRow& row : table) {
    std::vector<std::string> cells;
    for (const StrokeCell& cell : row.cells) {
      std::optional<double> value = cell.value;
      if (value) value = without_noise(*value, row.largest, row.unit);
      cells.push_back((cell.direction.empty() ? "" : cell.direction + " ") +
                      (cell.at_least ? "> " : "") + (value ? shown(value, row.unit) : row.absent));
    }
    text += line(row.label, cells);
    for (std::size_t k = 0; k < row.cells.size(); ++k)
      if (const std::string& why = row.cells[k].reason;
          !why.empty() && (k == 0 || why != row.cells[k - 1].reason))
        reasons += fmt::format("  {} at {} {}: {}\n", row.label, table.front().label,
                               shown(table.front().cells[k].value, table.front().unit), why);
  }
  if (!response.path.empty()) reasons += stroke_capacity_lines(response.path.front(), drives);
  return text + reasons;
}

std::string difference(double relative) { return fmt::format("{:+.3f} %", 100 * relative); }

std::string bound_of(const ConstraintState& state, const std::string& unit) {
  if (state.min && state.max)
    return fmt::format("{} .. {}", shown(state.min, unit), shown(state.max, unit));
  return state.max ? "<= " + shown(state.max, unit) : ">= " + shown(state.min, unit);
}

std::string optimum_lines(const Job& job, const Optimum& optimum, const DriveList& drives) {
  if (optimum.status == OptimumStatus::failed) return "";
  const OptimiseSpec& spec = *job.optimise;
  const Family& family = resolve(job.design)->family();
  std::string text;
  for (const Variable& variable : spec.variables)
    if (const auto found = optimum.parameters.find(variable.parameter);
        found != optimum.parameters.end())
      text += line(variable.parameter,
                   {shown(found->second, parameter_unit(family, variable.parameter)) +
                    (bound_at(variable, found->second) ? " *" : "")});
  const bool verified = optimum.verified && optimum.verified->outcome().status == Status::ok &&
                        some_leaf_reduced(optimum.response.path);
  std::vector<std::string> header{"value", "bound"};
  if (verified) header.insert(header.end(), {"full accuracy", "reduced/full - 1"});
  text += line("", header);
  const Objective& goal = spec.objective;
  std::vector<std::string> cells{shown(optimum.objective, goal_unit(goal, drives)),
                                 goal.maximise ? "maximised" : "minimised"};
  if (verified) {
    cells.push_back(shown(optimum.verified->objective, goal_unit(goal, drives)));
    cells.push_back(difference(optimum.verified->objective_difference));
  }
  text += line(goal.name() + label_suffix(goal.margin, goal.worst_assembly), cells);
  for (std::size_t i = 0; i < optimum.constraints.size(); ++i) {
    const ConstraintState& state = optimum.constraints[i];
    const std::string si =
        i < spec.constraints.size() ? goal_unit(spec.constraints[i], drives) : "";
    const char* mark = state.active ? " *" : state.margin < 0 ? " !" : "";
    cells = {shown(state.value, si) + mark, bound_of(state, si)};
    if (verified && i < optimum.verified->constraints.size()) {
      cells.push_back(shown(optimum.verified->constraints[i], si));
      cells.push_back(difference(optimum.verified->constraint_differences[i]));
    }
    text += line(state.label, cells);
  }
  text += "  (* at a bound, ! beyond it)\n";
  if (job.cases.empty()) return text;
  const auto decisive = [&](const std::string& label, const std::optional<GoalPlace>& place) {
    if (place)
      text += fmt::format("  {} is that of case {}, point {}\n", label,
                          job.cases[place->load_case].name, place->point);
  };
  decisive("the objective", optimum.decisive);
  for (const ConstraintState& state : optimum.constraints)
    if (state.active) decisive(state.label, state.decisive);
  return text;
}

/// "thickness 83 %": the entry of the job that makes most of the variance, with all of its leaves.
std::string largest_share(const std::vector<Tolerance>& entries, const ToleranceSlopes& slopes) {
  const VectorXd shares = variance_shares(entries, slopes);
  std::map<std::string, double> sums;
  for (std::size_t e = 0; e < entries.size(); ++e) sums[entries[e].entry] += shares[e];
  const auto& [name, share] =
      *std::ranges::max_element(sums, {}, &decltype(sums)::value_type::second);
  return share > 0 ? fmt::format("{} {:.0f} %", name, 100 * share) : "-";
}

std::string tolerated_line(const std::string& name, const ToleratedNumber& n,
                           const std::string& unit, const std::vector<Tolerance>& entries) {
  std::vector<std::string> cells{shown(n.value, unit), "-", "-", "-", "-"};
  if (n.slopes) {
    cells[1] = shown(farthest(*n.slopes), unit);
    cells[2] = shown(standard_deviation(entries, *n.slopes), unit);
    cells[4] = largest_share(entries, *n.slopes);
  }
  if (n.sampled) cells[3] = shown(n.sampled->standard_deviation, unit);
  return line(name, cells);
}

/// The goals; of a job without any, what a summary shows of the path and how the end-effector
/// moves, each where it spreads most.
std::string tolerated_lines(const RunRecord& record, const DriveList& drives) {
  const std::vector<Tolerance>& entries = record.job.tolerances->entries;
  std::string text =
      line("within the tolerances:",
           {"value", "+- first order", "standard deviation", "sampled", "largest share"});
  for (const ToleratedGoal& goal : record.tolerances->goals)
    text += tolerated_line(
        goal.label == "objective" && !goal.quantity.empty() ? goal.quantity : goal.label,
        goal.number, goal.quantity.empty() ? goal.unit : quantity_unit(goal.quantity, drives),
        entries);
  if (!record.tolerances->goals.empty()) return text;
  const std::vector<Quantity> known = quantities(drives);
  for (const ToleratedQuantity* q : widest_spreads(record)) {
    const QuantityRow& row = *std::ranges::find(known, q->name, &Quantity::name)->row;
    if (row.in_summary == SummaryLine::none && row.name != "displacement" && row.name != "rotation")
      continue;
    const std::string of_case = cases_of(record.job)[q->load_case].name;
    text += tolerated_line(
        fmt::format("{}, {}point {}", q->name, of_case.empty() ? "" : of_case + " ", q->point),
        q->number, quantity_unit(q->name, drives), entries);
  }
  return text;
}

std::string tolerance_lines(const RunRecord& record, const DriveList& drives) {
  if (!record.tolerances) return "";
  const ToleranceReport& report = *record.tolerances;
  std::string text = tolerated_lines(record, drives);
  if (report.room && *report.room > 1e-4)
    text += fmt::format(
        "  room: all tolerances times {:.3g} keep every constraint (first order); "
        "{} ends it\n",
        *report.room, report.room_of);
  else if (report.room)
    text += fmt::format("  no room for any tolerance: {} is at its bound or beyond it\n",
                        report.room_of);
  if (report.yield)
    text += fmt::format("  {:.1f} % of {} sampled designs keep every constraint",
                        100 * *report.yield, report.samples);
  else if (report.samples > 0)
    text += fmt::format("  {} sampled designs", report.samples);
  if (report.failed > 0) text += fmt::format(" ({} failed)", report.failed);
  for (const ToleratedGoal& goal : report.goals)
    if (goal.missed.value_or(0) > 0)
      text += fmt::format("; {:.1f} % miss {}", 100 * *goal.missed, goal.label);
  if (report.samples > 0) text += "\n";
  if (!report.message.empty()) text += "  tolerances: " + report.message + "\n";
  return text;
}

std::string assembly_lines(const RunRecord& record, const DriveList& drives) {
  if (!record.assembly) return "";
  const AssemblyReport& report = *record.assembly;
  std::string text;
  if (!report.quantities.empty())
    text += line("errors of assembly:", {"as designed", "worst in the box"});
  for (const WorstAssembly& one : report.quantities) {
    const std::string unit = goal_unit(one.of, drives);
    text += line(one.of.label,
                 {shown(one.nominal, unit), one.worst ? shown(*one.worst, unit) : one.reason});
  }
  if (report.critical)
    text += fmt::format("  critical errors of assembly: the box times {:.4g}; {}\n",
                        report.critical->scale, report.critical->text);
  if (!report.message.empty()) text += "  errors of assembly: " + report.message + "\n";
  return text;
}

std::string comparison_lines(const Comparison& comparison) {
  const auto percent = [](double share) { return fmt::format("{:.3g} %", 100 * share); };
  std::string text;
  for (const ModelComparison& model : comparison.models) {
    text += line(model.name + ", errors:", {"99th percentile", "worst", "median"});
    const auto add = [&](const std::string& name, const std::optional<ErrorFigures>& figures) {
      if (figures)
        text +=
            line(name, {percent(figures->p99), percent(figures->worst), percent(figures->median)});
    };
    for (std::size_t q = 0; q < comparison.quantities.size(); ++q)
      add(comparison.quantities[q].name, error_figures(model.errors, static_cast<int>(q)));
    if (!model.missing.empty())
      text += line("numbers that only one has", {fmt::format("{}", model.missing.size())});
    text += line("failures", {fmt::format("{}", model.failures)});
    if (model.fallback_designs > 0)
      text += line("full leaves instead", {fmt::format("{} points", model.fallback_points),
                                           fmt::format("{} designs", model.fallback_designs)});
    if (model.speed_up && model.speed_up_with_reduction)
      text +=
          line("speed-up, with reduction", {fmt::format("{:.3g}", *model.speed_up),
                                            fmt::format("{:.3g}", *model.speed_up_with_reduction)});
  }
  return text;
}

using Points = std::vector<const PathPoint*>;

/// First, unmoved and last converged point, each once.
Points shown_points(const StrokeResponse& response) {
  Points points;
  for (const PathPoint& point : response.path)
    if (point.status == PointStatus::converged) points.push_back(&point);
  if (points.size() <= 2) return points;
  const auto rest = std::ranges::min_element(points, {}, [](const PathPoint* point) {
    double farthest = point->drive_names.empty() ? std::abs(point->stroke) : 0;
    for (const double stroke : point->strokes) farthest = std::max(farthest, std::abs(stroke));
    return farthest;
  });
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
      weakest.direction = direction_names[d];
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
  for (const PathPoint* p : points) {
    StrokeCell& cell = added.cells.emplace_back(StrokeCell{row.value(*p, component)});
    if (cell.value) continue;
    if (row.at_least) cell.value = row.at_least(*p, component);
    cell.at_least = cell.value.has_value();
    if (!cell.value) cell.reason = why_missing(*p, row, component);
  }
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
      const auto& capacity = p->load_capacity[k];
      StrokeCell& cell = added.cells.emplace_back();
      if (capacity) cell.value = capacity->value;
      cell.at_least = capacity && capacity->limit == CapacityLimit::none;
      if (cell.at_least) cell.reason = capacity->reason;
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
  const std::string direction(direction_names[index(drives.first())]);
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

std::string summary_of(const RunRecord& record) {
  const Verdict verdict = verdict_of(record);
  std::string text = fmt::format("{}: {}. {}\n", record.job.name.empty() ? "run" : record.job.name,
                                 verdict.word, verdict.text);
  if (verdict.text.find(record.message) == std::string::npos)
    text += fmt::format("  {}\n", record.message);
  const DriveList drives(record.mechanism, record.job.request);
  if (record.comparison) return text + comparison_lines(*record.comparison);
  if (record.optimum) text += optimum_lines(record.job, *record.optimum, drives);
  text += tolerance_lines(record, drives);
  text += assembly_lines(record, drives);
  if (record.job.cases.empty())
    return text + stroke_lines(response_of(record), drives, record.job.request);
  const auto responses = responses_of(record);
  for (std::size_t k = 0; k < responses.size(); ++k)
    text += fmt::format("load case {}\n", record.job.cases[k].name) +
            stroke_lines(*responses[k], drives, record.job.cases[k].request);
  return text;
}

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
