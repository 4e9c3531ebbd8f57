#include "optim/problem/line_log.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cassert>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/spec/draft.hpp"
#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

namespace {

constexpr const char* heading = "flexopt_evaluations";

std::string content_of(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  return in ? std::string(std::istreambuf_iterator<char>(in), {}) : std::string();
}

// A line with its line break as it stands in the file, with checksum.
std::string written(std::string_view line) {
  return with_checksum(line.substr(0, line.size() - 1)) + "\n";
}

std::string checksum(std::string_view text) {
  const uLong sum = crc32_z(0, reinterpret_cast<const Bytef*>(text.data()), text.size());
  return fmt::format("{:08x}", sum);
}

// What with_checksum() puts before the last bracket.
std::string member(char bracket, std::string_view sum) {
  return bracket == '}' ? fmt::format(R"(,"crc32":"{}")", sum) : fmt::format(R"(,"crc32:{}")", sum);
}

// The line without its checksum; nothing where it has none that fits.
std::optional<std::string> without_checksum(std::string_view line) {
  if (line.empty()) return std::nullopt;
  const char bracket = line.back();
  const std::size_t added = member(bracket, "00000000").size();
  if (line.size() < added + 3) return std::nullopt;  // a list or object that is not empty is longer
  std::string before(line.substr(0, line.size() - 1 - added));
  before += bracket;
  return with_checksum(before) == line ? std::optional(before) : std::nullopt;
}

// The heading of logs of this identity, with checksum and line break.
std::string log_heading(const json& identity) {
  return written(log_line({{heading, OrderedJson(identity)}}));
}

}  // namespace

std::string first_difference(const json& theirs, const json& ours) {
  const json patch = json::diff(theirs, ours);
  if (patch.empty()) return "nothing";
  const std::string pointer = patch.front().at("path");
  const json::json_pointer at(pointer);
  const auto value = [&](const json& side) {
    return side.contains(at) ? side.at(at).dump() : std::string("nothing");
  };
  return fmt::format("{} was {} and is {}", pointer, value(theirs), value(ours));
}

std::string log_line(const OrderedJson& value) {
  return value.dump(-1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

json log_identity_of(const std::filesystem::path& path) {
  const std::string content = content_of(path);
  const json first =
      json::parse(CheckedLines(path).next(content.substr(0, content.find('\n'))), nullptr, false);
  return first.is_object() && first.contains(heading) ? first.at(heading) : json();
}

void LineLog::open(const std::filesystem::path& path, const json& identity, bool overwrite,
                   const std::function<void(const std::string&)>& read) {
  path_ = path;
  header_ = log_heading(identity);
  const auto refuse = [&](const std::string& found) {
    return SpecError(
        path_.string(), found,
        "expected the evaluations of this very job; write to another folder, or remove "
        "the file to start anew");
  };
  const std::string content = overwrite ? "" : content_of(path_);
  CheckedLines lines(path_);
  std::size_t kept = 0;  // bytes of whole lines
  for (std::size_t end; (end = content.find('\n', kept)) != std::string::npos; kept = end + 1) {
    const std::string line = lines.next(std::string_view(content).substr(kept, end - kept));
    try {
      if (lines.number() == 1) {
        const json first = json::parse(line), theirs = first.at(heading);
        if (first.size() != 1) throw refuse("a heading with more in it than its job");
        const json ours = json::parse(header_).at(heading);
        if (theirs != ours) throw refuse("a log of another job: " + first_difference(theirs, ours));
        continue;
      }
      read(line);
    } catch (const std::exception& error) {
      if (dynamic_cast<const SpecError*>(&error)) throw;
      throw refuse(
          fmt::format("line {}, which is no evaluation: {}", lines.number(), line.substr(0, 60)));
    }
  }
  if (kept == 0 && !header_.starts_with(content)) throw refuse("a file that is no log");
  if (kept < content.size()) std::filesystem::resize_file(path_, kept);
  out_.open(path_,
            overwrite ? std::ios::binary | std::ios::trunc : std::ios::binary | std::ios::app);
  if (out_ && kept == 0) out_ << header_ << std::flush;
  if (!out_) throw SpecError(path_.string(), "not writable", "expected a file that can be written");
}

void LineLog::append(const std::string& line) {
  if (path_.empty()) return;
  const std::lock_guard lock(mutex_);
  out_ << written(line) << std::flush;
  if (!out_)
    throw SpecError(path_.string(), "not writable", "expected room for one more evaluation");
}

void LineLog::finish(const std::vector<std::string>& lines) {
  if (path_.empty()) return;
  const std::lock_guard lock(mutex_);
  out_.close();
  std::string content = header_;
  for (const std::string& line : lines) content += written(line);
  if (write_whole(path_, content) != 0)
    throw SpecError(path_.string(), "not writable", "expected a file that can be written");
}

std::string log_text(const json& identity, const std::vector<std::string>& lines) {
  std::string text = log_heading(identity);
  for (const std::string& line : lines) text += with_checksum(line) + "\n";
  return text;
}

std::vector<std::string> read_log_lines(const std::filesystem::path& path) {
  const std::string content = content_of(path);
  CheckedLines checked(path);
  std::vector<std::string> lines;
  for (std::size_t begin = 0, end; (end = content.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    std::string line = checked.next(std::string_view(content).substr(begin, end - begin));
    if (checked.number() > 1) lines.push_back(std::move(line));
  }
  return lines;
}

std::string with_checksum(std::string_view line) {
  assert(line.size() > 2);
  const char bracket = line.back();
  return fmt::format("{}{}{}", line.substr(0, line.size() - 1), member(bracket, checksum(line)),
                     bracket);
}

std::string CheckedLines::next(std::string_view line) {
  ++number_;
  auto before = without_checksum(line);
  if (number_ == 1) all_have_ = before.has_value();
  if (before) return *before;
  // a heading or a line of a log from before there were checksums does not speak of one
  if (all_have_ || line.find("\"crc32") != std::string_view::npos)
    throw SpecError(file_.string(), fmt::format("line {}: {}", number_, line.substr(0, 60)),
                    number_ == 1
                        ? "it was changed after it was written: expected a heading that fits its "
                          "checksum; remove the file to start anew"
                        : "it was changed after it was written: expected a line that fits its "
                          "checksum; remove the line, and what it says is computed again");
  return std::string(line);
}

}  // namespace flexopt
