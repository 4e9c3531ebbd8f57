#include "results/files/result_parts.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <functional>

#include "optim/job/job_numbers.hpp"
#include "optim/problem/evaluation_log.hpp"

namespace flexopt {

namespace csv {

std::string text_cell(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string number_cell(const std::optional<double>& value) {
  return value && std::isfinite(*value) ? fmt::format("{}", *value) : "";
}

std::string row(const std::vector<std::string>& cells) {
  return fmt::format("{}\n", fmt::join(cells, ","));
}

}  // namespace csv

using csv::number_cell;
using csv::row;
using csv::text_cell;

namespace {

std::string headed(const std::string& name, const std::string& unit) {
  return text_cell(unit.empty() ? name : name + " [" + unit + "]");
}

/// The number of this name; empty where there is none.
std::string own(const ParameterValues& values, const std::string& name) {
  const auto found = values.find(name);
  return found == values.end() ? std::string() : number_cell(found->second);
}

struct Column {
  std::string header;
  std::function<std::string(const PathPoint&)> cell;
};

bool converged(const PathPoint& point) { return point.status == PointStatus::converged; }

/// C_ij with i ≤ j; the matrices are symmetric.
void add_compliance(std::vector<Column>& columns, const std::string& name,
                    Matrix6d PathPoint::*matrix) {
  for (int i = 0; i < 6; ++i)
    for (int j = i; j < 6; ++j)
      columns.push_back(
          {headed(fmt::format("{}.{}_{}", name, direction_names[i], direction_names[j]),
                  fmt::format("{}/{}", i < 3 ? "m" : "rad", j < 3 ? "N" : "(N m)")),
           [=](const PathPoint& point) {
             if (!converged(point)) return std::string();
             return number_cell((point.*matrix)(i, j));
           }});
}

void add_frequencies(std::vector<Column>& columns, const StrokeResponse& response,
                     const std::string& drive, std::vector<double> PathPoint::*frequencies,
                     std::vector<Mode> PathPoint::*modes) {
  std::size_t count = 0;
  for (const PathPoint& point : response.path) count = std::max(count, (point.*frequencies).size());
  for (std::size_t k = 0; k < count; ++k) {
    columns.push_back({headed(fmt::format("frequencies.drive_{}.{}", drive, k), "Hz"),
                       [=](const PathPoint& point) {
                         const auto& list = point.*frequencies;
                         return k < list.size() ? number_cell(list[k]) : std::string();
                       }});
    columns.push_back(
        {headed(fmt::format("kind.drive_{}.{}", drive, k), ""), [=](const PathPoint& point) {
           const auto& list = point.*modes;
           return k < list.size() ? name_of(list[k].kind) : std::string();
         }});
  }
}

/// Estimated errors, of the quantities that have columns and of the frequencies, absolute.
void add_errors(std::vector<Column>& columns, const StrokeResponse& response,
                const DriveList& drives, const StrokeErrors& errors) {
  for (const Quantity& quantity : quantities(drives)) {
    bool some = false;
    for (std::size_t k = 0; k < response.path.size(); ++k)
      some = some || errors.find(k, quantity.name);
    if (!some) continue;
    columns.push_back({headed("estimated_error." + quantity.name, quantity.unit),
                       [&response, &errors, name = quantity.name](const PathPoint& point) {
                         const auto k = static_cast<std::size_t>(&point - response.path.data());
                         const EstimatedError* error = errors.find(k, name);
                         return error ? number_cell(error->absolute()) : std::string();
                       }});
  }
}

void add_points(std::vector<Column>& columns, const StrokeRequest& request) {
  for (std::size_t k = 0; k < request.named_points.size(); ++k) {
    const NamedPoint named = request.named_points[k];
    const std::string name = fmt::format("{}s.{}", named.kind, named.name);
    const auto add = [&](const std::string& of, const char* unit, const auto& value) {
      columns.push_back({headed(name + of, unit), [=](const PathPoint& point) {
                           return converged(point) ? number_cell(value(point)) : std::string();
                         }});
    };
    for (int i = 0; i < 3; ++i)
      add({'.', "xyz"[i]}, "m", [=](const PathPoint& point) { return point.named_points[k][i]; });
    if (named.direction)
      add("", named.turns() ? "rad" : "m",
          [=](const PathPoint& point) { return point.motions_along[k]; });
  }
}

std::vector<Column> path_columns(const StrokeResponse& response, const DriveList& drives,
                                 const StrokeRequest& request, const StrokeErrors* errors) {
  std::vector<Column> columns;
  if (drives.named() && request.loads.driven())
    for (std::size_t k = 0; k < drives.items.size(); ++k)
      columns.push_back({headed("stroke." + drives.items[k].name,
                                is_rotation(drives.items[k].direction) ? "rad" : "m"),
                         [k](const PathPoint& point) { return number_cell(point.strokes[k]); }});
  else
    columns.push_back({headed("stroke", stroke_unit(drives, request)),
                       [](const PathPoint& point) { return number_cell(point.stroke); }});
  const std::vector<Column> solution{
      {"status", [](const PathPoint& point) { return name_of(point.status); }},
      {"newton_iterations",
       [](const PathPoint& point) { return fmt::format("{}", point.newton_iterations); }},
      {"sub_steps", [](const PathPoint& point) { return fmt::format("{}", point.sub_steps); }}};
  columns.insert(columns.end(), solution.begin(), solution.end());
  for (const Quantity& quantity : quantities(drives)) {
    if (!quantity.row->in_csv) continue;  // the frequencies follow below, each with its kind
    if (!is_answered(quantity, request)) continue;
    columns.push_back({headed(quantity.name, quantity.unit), [=](const PathPoint& point) {
                         return converged(point) ? number_cell(quantity.value(point)) : "";
                       }});
  }
  add_points(columns, request);
  columns.push_back({"stable", [](const PathPoint& point) {
                       return !converged(point) ? "" : point.stable ? "true" : "false";
                     }});
  columns.push_back({"negative_pivots", [](const PathPoint& point) {
                       return converged(point) ? fmt::format("{}", point.negative_pivots) : "";
                     }});
  add_frequencies(columns, response, "free", &PathPoint::frequencies_free, &PathPoint::modes_free);
  add_frequencies(columns, response, "locked", &PathPoint::frequencies_locked,
                  &PathPoint::modes_locked);
  add_compliance(columns, "compliance.drive_free", &PathPoint::compliance_free);
  add_compliance(columns, "compliance.drive_locked", &PathPoint::compliance_locked);
  if (errors) add_errors(columns, response, drives, *errors);
  return columns;
}

std::string objective_cell(const Objective& goal, const DriveList& drives) {
  return headed(
      "objective: " + goal.name() + (goal.of_parameters() ? "" : " " + name_of(goal.over_stroke)),
      goal_unit(goal, drives));
}

std::vector<std::string> history_header(const Job& job, const Family& family,
                                        const DriveList& drives) {
  const OptimiseSpec& spec = *job.optimise;
  std::vector<std::string> cells{"start", "number", "ok", "difference"};
  for (const Variable& variable : spec.variables)
    cells.push_back(headed(variable.parameter, parameter_unit(family, variable.parameter)));
  cells.push_back(objective_cell(spec.objective, drives));
  for (const Constraint& constraint : spec.constraints)
    cells.push_back(headed(constraint.label, goal_unit(constraint, drives)));
  cells.insert(cells.end(), {"violation [1]", "best", "message", "stage", "accuracy"});
  return cells;
}

/// Worst error of a quantity at one design; nothing where none was compared.
std::optional<double> worst_at(const std::vector<PointError>& errors, int design, int quantity,
                               int part = -1) {
  std::optional<double> worst;
  for (const PointError& e : errors)
    if (e.design == design && e.quantity == quantity && (part < 0 || e.part == part) &&
        (!worst || e.value > *worst))
      worst = e.value;
  return worst;
}

/// Whether a part has a column: not a support that a drive holds, nor a load nobody asked for.
bool has_column(const Job& job, const DriveList& drives, const ComparedQuantity& quantity,
                std::size_t part) {
  const ComparedQuantity::Number& number = quantity.numbers[part];
  const auto component = static_cast<std::size_t>(number.component);
  if (!drives.offers(*number.row, number.component)) return false;
  return !number.row->needs.has(Output::load_capacity) ||
         job.request.capacity.directions[component];
}

/// Calls take(quantity, part, name) for each column of errors: a part is −1 for all together.
template <class Take>
void each_error_column(const Job& job, const DriveList& drives,
                       const std::vector<ComparedQuantity>& quantities, const Take& take) {
  for (std::size_t q = 0; q < quantities.size(); ++q)
    take(static_cast<int>(q), -1, quantities[q].name);
  for (std::size_t q = 0; q < quantities.size(); ++q)
    for (std::size_t k = 0; k < quantities[q].parts.size(); ++k)
      if (has_column(job, drives, quantities[q], k))
        take(static_cast<int>(q), static_cast<int>(k),
             quantities[q].name + "." + quantities[q].parts[k]);
}

std::vector<std::string> comparison_header(const Job& job, const DriveList& drives,
                                           const std::vector<ComparedQuantity>& quantities) {
  std::vector<std::string> cells{"design", "model", "status"};
  for (const Parameter& p : parameters_of(job)) cells.push_back(headed(p.name, p.unit));
  for (const SampleRange& range : job.compare->samples.ranges)
    if (range.symbol) cells.push_back(headed(range.name, "SI"));
  cells.insert(cells.end(),
               {headed("largest stroke", stroke_unit(drives, job.request)), "length/width [1]",
                "thickness/length [1]", "width^2/(length thickness) [1]", "points",
                "points at full accuracy", "fallback points"});
  each_error_column(job, drives, quantities, [&](int, int, const std::string& name) {
    cells.push_back(headed("error: " + name, "1"));
  });
  cells.push_back("numbers that only one has");
  cells.insert(cells.end(), {"fallback reason", "message"});
  return cells;
}

/// The paths of several load cases, one after the other, with the column "case" first. A cell is
/// empty where its case has no such column.
std::string cases_csv(const std::vector<const StrokeResponse*>& responses, const DriveList& drives,
                      const std::vector<JobCase>& cases, const std::vector<StrokeErrors>& errors) {
  std::vector<std::vector<Column>> columns;
  std::vector<std::string> headers{"case"};
  for (std::size_t k = 0; k < responses.size(); ++k)
    columns.push_back(path_columns(*responses[k], drives, cases[k].request,
                                   k < errors.size() ? &errors[k] : nullptr));
  for (const bool strokes : {true, false})  // strokes of all cases come first
    for (const std::vector<Column>& of_case : columns)
      for (const Column& column : of_case)
        if (column.header.starts_with("stroke") == strokes &&
            std::ranges::find(headers, column.header) == headers.end())
          headers.push_back(column.header);
  std::string text = row(headers);
  for (std::size_t k = 0; k < responses.size(); ++k)
    for (const PathPoint& point : responses[k]->path) {
      std::vector<std::string> cells{text_cell(cases[k].name)};
      for (std::size_t h = 1; h < headers.size(); ++h) {
        const auto found = std::ranges::find(columns[k], headers[h], &Column::header);
        cells.push_back(found == columns[k].end() ? "" : found->cell(point));
      }
      text += row(cells);
    }
  return text;
}

}  // namespace

std::string path_csv(const StrokeResponse& response, const DriveList& drives,
                     const StrokeRequest& request, const StrokeErrors* errors) {
  const auto columns = path_columns(response, drives, request, errors);
  std::vector<std::string> cells;
  for (const Column& column : columns) cells.push_back(column.header);
  std::string text = row(cells);
  for (const PathPoint& point : response.path) {
    cells.clear();
    for (const Column& column : columns) cells.push_back(column.cell(point));
    text += row(cells);
  }
  return text;
}

std::string history_csv(const Job& job, const Optimum& optimum, const DriveList& drives) {
  assert(job.optimise);
  const OptimiseSpec& spec = *job.optimise;
  std::string text = row(history_header(job, resolve(job.design)->family(), drives));
  std::optional<double> best;
  for (const EvaluationRecord& record : optimum.history) {
    const bool feasible = record.ok && !record.difference && !record.full &&
                          record.stage == Stage::search &&
                          record.violation <= spec.constraint_tolerance;
    if (feasible &&
        (!best || (spec.objective.maximise ? record.objective > *best : record.objective < *best)))
      best = record.objective;
    const auto when_ok = [&](double value) {
      return record.ok ? number_cell(value) : std::string();
    };
    std::vector<std::string> cells{fmt::format("{}", record.start),
                                   fmt::format("{}", record.number), record.ok ? "true" : "false",
                                   record.difference ? "true" : "false"};
    for (const Variable& v : spec.variables) cells.push_back(own(record.variables, v.parameter));
    cells.push_back(when_ok(record.objective));
    for (std::size_t i = 0; i < spec.constraints.size(); ++i)
      cells.push_back(i < record.constraints.size() ? when_ok(record.constraints[i]) : "");
    cells.push_back(when_ok(record.violation));
    cells.push_back(number_cell(best));
    cells.push_back(text_cell(record.message));
    cells.push_back(name_of(record.stage));
    cells.push_back(record.full || job.model.accuracy == Accuracy::full ? "full" : "reduced");
    text += row(cells);
  }
  return text;
}

std::string pareto_csv(const Job& job, const ParetoFront& front, const DriveList& drives) {
  assert(job.optimise && job.optimise->pareto);
  const OptimiseSpec& spec = *job.optimise;
  const std::string unit = goal_unit(*spec.pareto, drives);
  std::vector<std::string> cells{
      "point", headed("bound", unit), objective_cell(spec.objective, drives),
      headed("second: " + spec.pareto->label, unit), headed("d objective / d bound", "SI")};
  for (const Parameter& p : parameters_of(job)) cells.push_back(headed(p.name, p.unit));
  cells.insert(cells.end(), {"violation [1]", "feasible", "status", "evaluations", "message"});
  std::string text = row(cells);
  for (std::size_t i = 0; i < front.points.size(); ++i) {
    const ParetoPoint& p = front.points[i];
    const auto when_ok = [&](double value) { return p.ok ? number_cell(value) : std::string(); };
    cells = {fmt::format("{}", i), number_cell(p.bound), when_ok(p.objective), when_ok(p.second),
             number_cell(p.trade_off)};
    for (const Parameter& of : parameters_of(job)) cells.push_back(own(p.parameters, of.name));
    cells.insert(cells.end(), {when_ok(p.violation), p.feasible ? "true" : "false", p.status,
                               fmt::format("{}", p.evaluations), text_cell(p.stop_reason)});
    text += row(cells);
  }
  return text;
}

std::string comparison_csv(const Job& job, const Comparison& comparison, const DriveList& drives) {
  assert(job.compare);
  const std::vector<ComparedQuantity>& quantities = comparison.quantities;
  std::string text = row(comparison_header(job, drives, quantities));
  for (std::size_t d = 0; d < comparison.designs.size(); ++d) {
    const ComparedDesign& design = comparison.designs[d];
    const Sample& sample = design.sample;
    double largest_stroke = 0;
    for (const double s : sample.stroke)
      if (std::abs(s) > std::abs(largest_stroke)) largest_stroke = s;
    for (const ModelComparison& model : comparison.models) {
      const ModelDesign& result = model.designs[d];
      std::vector<std::string> cells{fmt::format("{}", d), text_cell(model.name),
                                     design.failed   ? "full accuracy failed"
                                     : result.failed ? "failed"
                                                     : "ok"};
      for (const Parameter& p : parameters_of(job)) cells.push_back(own(sample.parameters, p.name));
      for (const SampleRange& range : job.compare->samples.ranges)
        if (range.symbol) cells.push_back(own(sample.symbols, range.name));
      for (const double value : {largest_stroke, design.length_over_width,
                                 design.thickness_over_length, design.width2_over_length_thickness})
        cells.push_back(number_cell(value));
      for (const int count : {result.points, design.points, result.fallback_points})
        cells.push_back(fmt::format("{}", count));
      const int at = static_cast<int>(d);
      each_error_column(job, drives, quantities, [&](int q, int part, const std::string&) {
        cells.push_back(number_cell(worst_at(model.errors, at, q, part)));
      });
      cells.push_back(
          fmt::format("{}", std::ranges::count(model.missing, at, &MissingNumber::design)));
      cells.push_back(text_cell(result.fallback_reason));
      cells.push_back(text_cell(design.failed ? design.message : result.message));
      text += row(cells);
    }
  }
  return text;
}

std::string path_csv(const RunRecord& record) {
  const DriveList drives = drives_of(record);
  if (!record.job.cases.empty())
    return cases_csv(responses_of(record), drives, record.job.cases, record.errors);
  return path_csv(response_of(record), drives, record.job.request,
                  record.errors.empty() ? nullptr : &record.errors.front());
}

}  // namespace flexopt
