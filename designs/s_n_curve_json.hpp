#pragma once
// The S-N curve of a material as it stands in jobs and design files.
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "core/mechanism/s_n_curve.hpp"

namespace flexopt {

struct Field;

/// The key "s_n_curve" of a material.
Field s_n_curve_field();

/// `read` has passed the shape and stands at `at`. Throws SpecError where it is no curve.
SnCurve s_n_curve_of(const nlohmann::json& read, const nlohmann::json_pointer<std::string>& at);
/// JSON that reads as this curve.
nlohmann::json written_s_n_curve(const SnCurve& curve);

}  // namespace flexopt
