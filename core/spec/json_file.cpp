#include "core/spec/json_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string_view>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

constexpr std::size_t largest_file = 16u << 20;  // [bytes]
constexpr int deepest_level = 32;                // levels; a job needs 6

/// nlohmann's message without its "[json.exception.parse_error.101] parse error at ".
std::string reason(const json::exception& error) {
  std::string text = error.what();
  if (const auto id = text.find("] "); text.starts_with('[') && id != std::string::npos)
    text.erase(0, id + 2);
  if (const std::string lead = "parse error at "; text.starts_with(lead))
    text.erase(0, lead.size());
  return text;
}

struct Place {
  int line = 0, column = 0;  ///< from 1, columns in letters
};

/// Moves through a JSON text from token to token, in step with the parser.
class Cursor {
 public:
  explicit Cursor(const std::string& text) : text_(text) {
    if (text_.starts_with("\xEF\xBB\xBF")) at_ = line_start_ = 3;  // UTF-8's mark of byte order
  }

  /// Goes to the next token and says where it begins.
  void find_token() {
    while (at_ < text_.size() && std::string_view(" \t\r\n,:").find(text_[at_]) != text_npos) {
      if (text_[at_] == '\n') next_line();
      ++at_;
    }
  }

  /// Goes to a byte further on.
  void go_to(std::size_t byte) {
    for (const std::size_t end = std::min(byte, text_.size()); at_ < end; ++at_)
      if (text_[at_] == '\n') next_line();
  }

  /// Goes behind the token that begins here.
  void skip_token() {
    if (at_ >= text_.size()) return;
    const char first = text_[at_++];
    if (first == '"') {
      while (at_ < text_.size() && text_[at_] != '"') at_ += text_[at_] == '\\' ? 2 : 1;
      ++at_;
    } else if (std::string_view("{}[]").find(first) == text_npos) {
      while (at_ < text_.size() && std::string_view(" \t\r\n,:{}[]").find(text_[at_]) == text_npos)
        ++at_;
    }
  }

  int line() const { return line_; }

  Place place() const {
    const std::size_t end = std::min(at_, text_.size());
    int column = 1;
    for (std::size_t i = line_start_; i < end; ++i)
      if ((static_cast<unsigned char>(text_[i]) & 0xC0) != 0x80) ++column;  // starts a letter
    return {line_, column};
  }

 private:
  static constexpr std::size_t text_npos = std::string_view::npos;

  void next_line() {
    ++line_;
    line_start_ = at_ + 1;
  }

  const std::string& text_;
  std::size_t at_ = 0, line_start_ = 0;
  int line_ = 1;
};

std::string escaped(const std::string& key) {
  std::string text;
  for (const char c : key)
    text += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
  return text;
}

/// Watches the parser go by: where it stands, keys met twice in one object, and nesting.
class Watch {
 public:
  using Event = json::parse_event_t;

  struct Found {
    Place key, value;  ///< of what an array holds, both are the value's
  };

  explicit Watch(const JsonText& text) : origin_(text.origin), cursor_(text.text) {}

  /// Places whose positions are wanted and, after parsing, these positions.
  std::map<std::string, std::optional<Found>> wanted;
  std::vector<Fault> repeated;

  bool operator()(int depth, Event event, json& parsed) {
    cursor_.find_token();
    if (depth > deepest_level)
      throw fault(fmt::format("nested deeper than {} levels", deepest_level));
    if (event == Event::object_end || event == Event::array_end) {
      levels_.pop_back();
    } else if (event == Event::key) {
      note_key(parsed.get<std::string>());
    } else {
      note_value();
      if (event != Event::value) levels_.push_back({.is_array = event == Event::array_start});
    }
    cursor_.skip_token();
    return true;
  }

  /// A complaint about the text as a whole, at a byte of it or where the next token is.
  SpecError fault(const std::string& rule, std::optional<std::size_t> byte = std::nullopt) {
    if (byte)
      cursor_.go_to(*byte);
    else
      cursor_.find_token();
    return SpecError({here({.pointer = "", .value = origin_, .rule = rule})});
  }

 private:
  struct Level {
    bool is_array = false;
    std::size_t next = 0;  ///< of an array
    std::string key;       ///< of an object
    Place key_place;
    std::map<std::string, int> lines;  ///< of the keys of an object
  };

  Fault here(Fault fault) const {
    const Place at = cursor_.place();
    fault.source = origin_;
    fault.line = at.line;
    fault.column = at.column;
    return fault;
  }

  std::string pointer() const {
    std::string text;
    for (const Level& level : levels_)
      text += "/" + (level.is_array ? std::to_string(level.next - 1) : escaped(level.key));
    return text;
  }

  void note_key(const std::string& key) {
    Level& level = levels_.back();
    level.key = key;
    if (!wanted.empty()) level.key_place = cursor_.place();
    const auto [it, is_new] = level.lines.try_emplace(key, cursor_.line());
    if (is_new) return;
    const int line = cursor_.line();
    Fault fault{.pointer = pointer(), .value = shown(key)};
    fault.rule = fmt::format("the key {} stands twice in one object, in {}; keep one", shown(key),
                             line == it->second ? fmt::format("line {}", line)
                                                : fmt::format("lines {} and {}", it->second, line));
    fault.of_key = true;
    repeated.push_back(here(std::move(fault)));
  }

  void note_value() {
    if (!levels_.empty() && levels_.back().is_array) ++levels_.back().next;
    if (wanted.empty()) return;
    const auto it = wanted.find(pointer());
    if (it == wanted.end()) return;
    const Place value = cursor_.place();
    const bool keyed = !levels_.empty() && !levels_.back().is_array;
    it->second = Found{keyed ? levels_.back().key_place : value, value};
  }

  std::string origin_;
  Cursor cursor_;
  std::vector<Level> levels_;
};

std::string around(std::string pointer) {
  const std::size_t slash = pointer.rfind('/');
  pointer.resize(slash == std::string::npos ? 0 : slash);
  return pointer;
}

bool at_or_below(const std::string& pointer, const std::string& place) {
  return pointer == place || pointer.starts_with(place + "/");
}

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

JsonText read_text(const std::string& file) {
  std::error_code error;
  const auto status = std::filesystem::status(file, error);
  if (!std::filesystem::exists(status)) throw SpecError("", file, "there is no such file");
  if (std::filesystem::is_directory(status))
    throw SpecError("", file, "it is a folder; expected a JSON file");
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw SpecError("", file, "it cannot be read: " + std::generic_category().message(errno));
  constexpr std::size_t piece = 1u << 16;
  std::string text;
  while (stream && text.size() <= largest_file) {
    const std::size_t before = text.size();
    text.resize(before + piece);
    stream.read(text.data() + before, static_cast<std::streamsize>(piece));
    if (stream.bad()) throw SpecError("", file, "reading it failed");
    text.resize(before + static_cast<std::size_t>(stream.gcount()));
  }
  if (text.size() > largest_file)
    throw SpecError("", file, fmt::format("it is larger than {} MiB", largest_file >> 20));
  return {std::move(text), file};
}

namespace {
/// `byte`: where the text stops being JSON, if the parser says so.
SpecError not_json(Watch& watch, std::string why, std::optional<std::size_t> byte) {
  Fault fault = watch.fault(why, byte).faults().front();
  if (const auto lead = why.find(": "); why.starts_with("line ") && lead != std::string::npos)
    why.erase(0, lead + 2);
  fault.rule = fmt::format("not JSON: line {}, column {}: {}", fault.line, fault.column, why);
  return SpecError({fault});
}
}  // namespace

json parse_json(const JsonText& text, std::vector<Fault>& faults) {
  if (text.text.find_first_not_of(" \t\r\n") == std::string::npos)
    throw SpecError("", text.origin, "it is empty; expected a JSON object");
  Watch watch(text);
  try {
    json document = json::parse(text.text, std::ref(watch));
    for (Fault& fault : watch.repeated) {
      const json::json_pointer at(fault.pointer);
      if (document.contains(at)) fault.value = shown(document[at]);
      faults.push_back(std::move(fault));
    }
    return document;
  } catch (const json::parse_error& error) {
    throw not_json(watch, reason(error), std::max<std::size_t>(error.byte, 1) - 1);
  } catch (const json::exception& error) {
    throw not_json(watch, reason(error), std::nullopt);
  }
}

std::vector<std::string> keys_in_text(const std::string& text, const char* section) {
  std::vector<std::string> keys;
  if (text.empty()) return keys;
  const auto document = nlohmann::ordered_json::parse(text, nullptr, false);
  if (!document.is_object() || !document.contains(section)) return keys;
  for (const auto& [key, value] : document[section].items())
    if (std::ranges::find(keys, key) == keys.end()) keys.push_back(key);
  return keys;
}

json parse_json(const std::string& text, const std::string& origin) {
  std::vector<Fault> faults;
  json document = parse_json(JsonText{text, origin}, faults);
  if (!faults.empty()) throw SpecError(faults);
  return document;
}

void locate(std::vector<Fault>& faults, const JsonText& text,
            const std::vector<std::string>& overridden) {
  constexpr const char* from_command = "--set";
  Watch watch(text);
  for (Fault& fault : faults) {
    if (!fault.source.empty()) continue;  // known already
    if (std::any_of(overridden.begin(), overridden.end(),
                    [&](const std::string& place) { return at_or_below(fault.pointer, place); }))
      fault.source = from_command;
    for (std::string at = fault.pointer;; at = around(at)) {
      watch.wanted.try_emplace(at);
      if (at.empty()) break;
    }
  }
  [[maybe_unused]] const json again = json::parse(text.text, std::ref(watch));
  for (Fault& fault : faults) {
    if (!fault.source.empty()) continue;
    std::string at = fault.pointer;
    while (!at.empty() && !watch.wanted[at]) at = around(at);
    const Watch::Found found = watch.wanted[at].value_or(Watch::Found{});
    const Place place = fault.of_key && at == fault.pointer ? found.key : found.value;
    fault.source = text.origin;
    fault.line = place.line;
    fault.column = place.column;
  }
  std::stable_sort(faults.begin(), faults.end(), [&](const Fault& a, const Fault& b) {
    const auto rank = [&](const Fault& fault) {
      return std::tuple(fault.source == from_command, fault.line, fault.column);
    };
    return rank(a) < rank(b);
  });
}

namespace {

/// An override's JSON value, with the checks of a file; `pointer` is where it goes.
json checked_value(const std::string& text, const std::string& pointer) {
  try {
    return parse_json(text, text);
  } catch (const SpecError& error) {
    std::vector<Fault> faults = error.faults();
    for (Fault& fault : faults) {
      fault.pointer = pointer + fault.pointer;
      fault.source.clear();  // there are no lines
      fault.line = fault.column = 0;
    }
    throw SpecError(faults);
  }
}

}  // namespace

std::string apply_override(json& document, const std::string& assignment) {
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
    value = checked_value(text, pointer);
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
  std::optional<std::string> outermost;  // of what is new
  for (const std::string& key : keys) {
    if (place->is_null() && !here.empty()) *place = json::object();
    if (place->is_object()) {
      if (!outermost && !place->contains(key)) outermost = (here / key).to_string();
      place = &(*place)[key];
      here /= key;
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
      if (!outermost && at == size) outermost = (here / at).to_string();
      if (at == size) place->push_back(nullptr);
      place = &(*place)[at];
      here /= at;
    } else {
      throw SpecError(pointer, text,
                      fmt::format("{} holds {}, which has no parts",
                                  here.empty() ? "/" : here.to_string(), shown(*place)));
    }
  }
  *place = std::move(value);
  return outermost.value_or(here.to_string());
}

}  // namespace flexopt
