#pragma once
// The worst and the critical errors of assembly in result.json.
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// Writes the study of assembly errors of a record that has one.
OrderedJson make_assembly(const RunRecord& record);

}  // namespace flexopt
