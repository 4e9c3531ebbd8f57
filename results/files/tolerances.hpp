#pragma once
// What tolerances do to a design: the part "tolerances" of result.json, and tolerances.csv.
#include <filesystem>
#include <string>

#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

OrderedJson make_tolerances(const RunRecord& record);

/// A row for each quantity at each stroke point, with a column for the share of each tolerance.
std::string tolerances_csv(const RunRecord& record);

/// Writes tolerances.csv, or removes that of an earlier run where the record has no tolerances.
void write_tolerances_csv(const std::filesystem::path& folder, const RunRecord& record);

}  // namespace flexopt
