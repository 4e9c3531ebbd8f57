#pragma once
// JSON texts from users: strict, with line and column in every complaint.
#include <nlohmann/json.hpp>
#include <string>

namespace flexopt {

/// Parses strictly: no comments, no duplicate keys, at most 32 levels deep. Throws SpecError whose
/// value is `origin` (a file name, say) and whose rule has line and column.
nlohmann::json parse_json(const std::string& text, const std::string& origin);

/// Reads and parses a file of at most 16 MiB. Throws SpecError (missing, a folder, unreadable).
nlohmann::json read_json_file(const std::string& file);

/// Carries out `--set /pointer=value`. The value is JSON where it parses, else a text: 3, [1, 2],
/// "0.3 mm" and 0.3 mm all work. The place's parent must exist, or is made where it is an object;
/// "-" appends to an array. Throws SpecError.
void apply_override(nlohmann::json& document, const std::string& assignment);

/// The value as one short line of a message.
std::string shown(const nlohmann::json& value);

}  // namespace flexopt
