#pragma once
// The worst and the critical errors of assembly in result.json.
#include "results/files/json_text.hpp"
#include "results/files/run_record.hpp"

namespace flexopt {

/// Of a record that has them.
OrderedJson make_assembly(const RunRecord& record);

}  // namespace flexopt
