#pragma once
// JSON as text that a person can read: one line for what fits on a line, such as a matrix row.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

namespace flexopt {

/// Keeps the order in which keys were added.
using OrderedJson = nlohmann::ordered_json;

/// Numbers in the shortest form that reads back to the same double. Ends with a newline.
std::string json_text(const OrderedJson& document);

/// JSON text without any blanks. Strings that are not UTF-8 (a file name, say) are repaired instead
/// of causing an exception.
std::string compact_text(const OrderedJson& value);

/// The number, or null.
OrderedJson optional_json(const std::optional<double>& value);

/// JSON has no NaN and no infinity: these become null. Returns the pointers of what was replaced.
std::vector<std::string> remove_non_finite(OrderedJson& document, const std::string& pointer = "");

}  // namespace flexopt
