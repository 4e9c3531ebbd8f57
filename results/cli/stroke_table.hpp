#pragma once
// The few numbers of a path that its summary shows, in SI.
#include <optional>
#include <string>
#include <vector>

#include "core/response/quantities.hpp"
#include "core/response/response.hpp"

namespace flexopt {

struct StrokeCell {
  std::optional<double> value;  ///< SI
  std::string direction;        ///< of the weakest of several; empty: there is one number
  bool at_least = false;        ///< where nothing ended its growth: what is borne at least
};

struct StrokeRow {
  std::string label;         ///< as a designer says it
  std::string quantity;      ///< key in result.json: "max_stress", "drive_load.x"
  std::string unit;          ///< SI
  std::string absent = "-";  ///< shown where a point has no such number
  double largest = 0;        ///< of its kind on the whole path; beside it rounding noise is zero
  std::vector<StrokeCell> cells;  ///< a point each
};

/// Rows at the first, the unmoved and the last converged point, each once; strokes (or the load
/// factor) come first. No rows where no point converged.
std::vector<StrokeRow> stroke_table(const StrokeResponse& response, const DriveList& drives,
                                    const StrokeRequest& request);

}  // namespace flexopt
