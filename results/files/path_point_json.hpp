#pragma once
// A stroke point in result.json.
#include <string>

#include "core/response/request.hpp"
#include "core/response/response.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// One stroke point; numbers that a point without equilibrium does not have are null.
OrderedJson make_path_point(const PathPoint& point, const Mechanism& mechanism,
                            const StrokeRequest& request);

/// First part of a name with dots: the key of the result that the number stands in.
std::string key_of(const std::string& name);

/// [x, y, z]
OrderedJson vector_json(const Vector3d& v);

}  // namespace flexopt
