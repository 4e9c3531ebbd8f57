#pragma once
// Tables for spreadsheets and scripts: comma separated, one header line with units, SI.
#include <optional>
#include <string>
#include <vector>

#include "core/response/quantities.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

namespace csv {

/// RFC 4180: quoted where a comma, a quote or a line break would be misread.
std::string text_cell(const std::string& text);

/// Shortest text that reads back to the same double; empty where there is no finite number.
std::string number_cell(const std::optional<double>& value);

std::string row(const std::vector<std::string>& cells);

}  // namespace csv

/// One row for each stroke point; a cell without value is empty. `errors`: those of the response,
/// or null.
std::string path_csv(const StrokeResponse& response, const DriveList& drives,
                     const StrokeRequest& request, const StrokeErrors* errors = nullptr);

/// The path that a run is about, or those of all load cases.
std::string path_csv(const RunRecord& record);

/// One row for each evaluated design, in the order start, number; `best` is the objective of the
/// best feasible design up to and including this row, `difference` marks neighbours for
/// derivatives.
std::string history_csv(const Job& job, const Optimum& optimum, const DriveList& drives);

/// One row for each design of the front of two objectives.
std::string pareto_csv(const Job& job, const ParetoFront& front, const DriveList& drives);

/// One row for each design and model: parameters and symbols, ratios of the widest leaf, points
/// reached, and the worst error of each quantity.
std::string comparison_csv(const Job& job, const Comparison& comparison, const DriveList& drives);

}  // namespace flexopt
