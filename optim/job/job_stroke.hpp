#pragma once
// Where the drives of a design go: the stroke of one, and the strokes of drives with names.
#include <nlohmann/json_fwd.hpp>

#include "core/response/quantities.hpp"
#include "core/spec/field_table.hpp"
#include "designs/family.hpp"

namespace flexopt {

/// What "stroke" may hold. Without drives (null) its unit is not known.
Shape stroke_shape(const DriveList* drives);

/// Sets the points of the request, and the strokes of drives with names. `read` has passed the
/// shape; it gets what was left to defaults. Throws SpecError.
void read_stroke(nlohmann::json& read, const nlohmann::json& as_written, const DriveList& drives,
                 StrokeRequest& request);

}  // namespace flexopt
