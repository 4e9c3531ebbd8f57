#pragma once
// JSON texts from users: strict, with line and column in every complaint.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/spec/spec_error.hpp"

namespace flexopt {

/// A JSON text and what it is called in messages: its file, say.
struct JsonText {
  std::string text, origin;
};

/// Reads a file of at most 16 MiB. Throws SpecError (missing, a folder, unreadable).
JsonText read_text(const std::string& file);

/// Parses strictly: no comments, at most 32 levels deep. Keys that stand twice in one object are
/// added to `faults`, with both their lines, and the last one counts. Throws SpecError, with line
/// and column, for what is no JSON.
nlohmann::json parse_json(const JsonText& text, std::vector<Fault>& faults);

/// Parses JSON text; keys that occur twice are thrown as SpecError, too.
nlohmann::json parse_json(const std::string& text, const std::string& origin);

/// The keys of a section in the order in which they are written; none where there is no text.
std::vector<std::string> keys_in_text(const std::string& text, const char* section);

/// Fills in where the faults stand in the text, and sorts them by that. What is missing is missed
/// in the object around it. Faults at or below a pointer of `overridden` stand in no file: their
/// source is "--set", and they come last.
void locate(std::vector<Fault>& faults, const JsonText& text,
            const std::vector<std::string>& overridden);

/// Carries out `--set /pointer=value`. The value is JSON where it parses, else a text: 3, [1, 2],
/// "0.3 mm" and 0.3 mm all work. The place's parent must exist, or is made where it is an object;
/// "-" appends to an array. Returns the pointer of the outermost value that is new. Throws
/// SpecError.
std::string apply_override(nlohmann::json& document, const std::string& assignment);

/// The value as one short line of a message.
std::string shown(const nlohmann::json& value);

}  // namespace flexopt
