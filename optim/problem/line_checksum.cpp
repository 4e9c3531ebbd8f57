#include <fmt/format.h>
#include <zlib.h>

#include <cassert>
#include <optional>

#include "core/spec/spec_error.hpp"
#include "optim/problem/line_log.hpp"

namespace flexopt {
namespace {

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
  if (line.size() < added + 3) return std::nullopt;  // of a list or object that is not empty
  std::string before(line.substr(0, line.size() - 1 - added));
  before += bracket;
  return with_checksum(before) == line ? std::optional(before) : std::nullopt;
}

}  // namespace

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
