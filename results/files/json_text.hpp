#pragma once
// JSON as text that a person can read: one line for what fits on a line, such as a matrix row.
#include <cstddef>
#include <cstdint>
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

// Arrays of numbers as text inside a JSON document: compressed by zlib, then base64.

/// {"type": "float32", "shape": [...], "data"}: the bytes of little-endian numbers, all first bytes
/// before all second ones and so on, compressed and in base64. The first index runs slowest; the
/// product of `shape` is the number of values.
OrderedJson packed_floats(const std::vector<float>& values, const std::vector<std::size_t>& shape);

/// {"type": "int16", "shape", "data"}: as packed_floats, each row of the first index less the row
/// before it, which compresses better where rows are alike.
OrderedJson packed_rows(const std::vector<std::int16_t>& values,
                        const std::vector<std::size_t>& shape);

std::string base64(const std::string& bytes);

}  // namespace flexopt
