#include "core/spec/json_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <set>
#include <system_error>
#include <vector>

#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

constexpr std::size_t largest_file = 16u << 20;  // [bytes]
constexpr int deepest = 32;                      // levels; a job needs 6

/// nlohmann's message without its "[json.exception.parse_error.101] parse error at ".
std::string reason(const json::exception& error) {
  std::string text = error.what();
  if (const auto id = text.find("] "); text.starts_with('[') && id != std::string::npos)
    text.erase(0, id + 2);
  if (const std::string lead = "parse error at "; text.starts_with(lead))
    text.erase(0, lead.size());
  return text;
}

/// Watches the parser go by: keys met twice in one object, and nesting.
class Watch {
 public:
  explicit Watch(const std::string& origin) : origin_(origin) {}

  bool operator()(int depth, json::parse_event_t event, json& parsed) {
    using Event = json::parse_event_t;
    if (depth > deepest)
      throw SpecError("", origin_, fmt::format("nested deeper than {} levels", deepest));
    if (event == Event::object_start) keys_.emplace_back();
    if (event == Event::object_end) keys_.pop_back();
    if (event == Event::key && !keys_.back().insert(parsed.get<std::string>()).second)
      throw SpecError(
          "", origin_,
          fmt::format("the key {} stands twice in one object; keep one", shown(parsed)));
    return true;
  }

 private:
  std::string origin_;
  std::vector<std::set<std::string>> keys_;
};

}  // namespace

std::string shown(const json& value) {
  constexpr std::size_t longest = 80;
  std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  if (text.size() > longest) {
    std::size_t cut = longest - 4;
    while (cut > 0 && (static_cast<unsigned char>(text[cut]) & 0xC0) == 0x80) --cut;  // whole UTF-8
    text = text.substr(0, cut) + " ...";
  }
  return text;
}

json parse_json(const std::string& text, const std::string& origin) {
  if (text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw SpecError("", origin, "it is empty; expected a JSON object");
  Watch watch(origin);
  try {
    return json::parse(text, std::ref(watch));
  } catch (const json::exception& error) {
    throw SpecError("", origin, "not JSON: " + reason(error));
  }
}

json read_json_file(const std::string& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw SpecError("", file, "there is no such file");
  if (std::filesystem::is_directory(status))
    throw SpecError("", file, "it is a folder; expected a JSON file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw SpecError("", file, "it cannot be read: " + std::generic_category().message(errno));
  std::string text(largest_file + 1, '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  if (stream.bad()) throw SpecError("", file, "reading it failed");
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text.size() > largest_file)
    throw SpecError("", file, fmt::format("it is larger than {} MiB", largest_file >> 20));
  return parse_json(text, file);
}

void apply_override(json& document, const std::string& assignment) {
  const std::size_t equals = assignment.find('=');
  if (assignment.empty() || assignment.front() != '/' || equals == std::string::npos)
    throw SpecError("", assignment,
                    "an override is written /pointer=value, such as /stroke/to=10 deg");
  const std::string pointer = assignment.substr(0, equals), text = assignment.substr(equals + 1);
  json value;
  const json tried = json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (tried.is_discarded()) {
    value = text;
    try {
      static_cast<void>(value.dump());  // strict about UTF-8
    } catch (const json::exception&) {
      throw SpecError(pointer, shown(value), "the value is not valid UTF-8");
    }
  } else {
    value = parse_json(text, text);  // again, with the checks of a file
  }
  json::json_pointer path;
  try {
    path = json::json_pointer(pointer);
  } catch (const json::exception& error) {
    throw SpecError(pointer, text, "not a JSON pointer: " + reason(error));
  }
  std::vector<std::string> keys;
  for (json::json_pointer p = path; !p.empty(); p.pop_back()) keys.insert(keys.begin(), p.back());
  json* place = &document;
  json::json_pointer here;
  for (const std::string& key : keys) {
    if (place->is_null() && !here.empty()) *place = json::object();
    if (place->is_object()) {
      place = &(*place)[key];
    } else if (place->is_array()) {
      const bool digits =
          !key.empty() && key.size() < 9 &&
          std::all_of(key.begin(), key.end(), [](char c) { return c >= '0' && c <= '9'; });
      const std::size_t size = place->size(), at = key == "-" ? size
                                                   : digits   ? std::stoul(key)
                                                              : size + 1;
      if (at > size || (at == size && key != "-"))
        throw SpecError(pointer, text,
                        fmt::format("{} has {} elements; '{}' is none of 0..{} or -",
                                    here.to_string(), size, key, size == 0 ? 0 : size - 1));
      if (at == size) place->push_back(nullptr);
      place = &(*place)[at];
    } else {
      throw SpecError(pointer, text,
                      fmt::format("{} holds {}, which has no parts",
                                  here.empty() ? "/" : here.to_string(), shown(*place)));
    }
    here /= key;
  }
  *place = std::move(value);
}

}  // namespace flexopt
