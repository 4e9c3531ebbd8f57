#pragma once
// Cells and rows of comma separated tables.
#include <optional>
#include <string>
#include <vector>

namespace flexopt::csv {

/// RFC 4180: quoted where a comma, a quote or a line break would be misread.
std::string text_cell(const std::string& text);

/// Shortest text that reads back to the same double; empty where there is no finite number.
std::string number_cell(const std::optional<double>& value);

std::string row(const std::vector<std::string>& cells);

}  // namespace flexopt::csv
