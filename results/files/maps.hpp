#pragma once
// Quantities over two parameters: the part "maps" of result.json, and maps.csv.
#include <filesystem>
#include <string>

#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

OrderedJson make_maps(const RunRecord& record);

/// One row for each design of each map and each of its quantities.
std::string maps_csv(const RunRecord& record);

/// Writes maps.csv, or removes that of an earlier run where the record has no maps.
void write_maps_csv(const std::filesystem::path& folder, const RunRecord& record);

}  // namespace flexopt
