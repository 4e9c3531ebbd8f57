#pragma once
// Arrays of numbers as text inside a JSON document: compressed by zlib, then base64.
#include <cstdint>
#include <string>
#include <vector>

#include "results/files/json_text.hpp"

namespace flexopt {

/// {"type": "float32", "shape": [...], "data"}: the bytes of little-endian numbers, all first bytes
/// before all second ones and so on, compressed and in base64. The first index runs slowest; the
/// product of `shape` is the number of values.
OrderedJson packed_floats(const std::vector<float>& values, const std::vector<std::size_t>& shape);

/// {"type": "int16", "shape", "data"}: the same, each row of the first index less the row before
/// it, which compresses better where rows are alike.
OrderedJson packed_rows(const std::vector<std::int16_t>& values,
                        const std::vector<std::size_t>& shape);

std::string base64(const std::string& bytes);

}  // namespace flexopt
