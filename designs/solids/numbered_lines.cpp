#include "designs/solids/numbered_lines.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>

#include "core/spec/spec_error.hpp"

namespace flexopt {

NumberedLines::NumberedLines(const std::string& file) : file_(file), stream_(file) {
  if (std::filesystem::is_directory(file)) fail("it is a folder; expected a file", true);
  if (!stream_) fail("there is no such file, or it cannot be read", true);
}

bool NumberedLines::next() {
  if (!std::getline(stream_, line_)) return false;
  ++number_;
  text_ = trimmed(line_);
  return true;
}

void NumberedLines::need() {
  if (!next()) fail("the file ends too early", true);
}

const std::vector<double>& NumberedLines::numbers(std::size_t least) {
  numbers_.clear();
  constexpr std::string_view separators = " \t,";
  for (std::string_view rest = text_;;) {
    rest.remove_prefix(std::min(rest.find_first_not_of(separators), rest.size()));
    if (rest.empty()) break;
    std::string_view word = rest.substr(0, rest.find_first_of(separators));
    rest.remove_prefix(word.size());
    const char* first = word.data() + (word.starts_with('+') ? 1 : 0);
    double value = 0;
    const auto [end, error] = std::from_chars(first, word.data() + word.size(), value);
    if (error != std::errc() || end != word.data() + word.size())
      fail(fmt::format("'{}' is no number", word));
    numbers_.push_back(value);
  }
  if (numbers_.size() < least)
    fail(fmt::format("{} numbers; expected {} at least", numbers_.size(), least));
  return numbers_;
}

int NumberedLines::whole(double number) const {
  if (number != std::rint(number) || std::abs(number) > std::numeric_limits<int>::max())
    fail(fmt::format("{:g} is no whole number of at most {}", number,
                     std::numeric_limits<int>::max()));
  return static_cast<int>(number);
}

void NumberedLines::fail(const std::string& rule, bool of_file) const {
  const int line = of_file ? 0 : number_;
  throw SpecError({Fault{
      .value = file_, .rule = rule, .source = file_, .line = line, .column = line > 0 ? 1 : 0}});
}

std::string_view trimmed(std::string_view text) {
  constexpr std::string_view blanks = " \t\r";
  text.remove_prefix(std::min(text.find_first_not_of(blanks), text.size()));
  return text.substr(0, text.find_last_not_of(blanks) + 1);
}

std::string capitals(std::string_view text) {
  std::string upper(text);
  std::ranges::transform(upper, upper.begin(),
                         [](char c) { return c >= 'a' && c <= 'z' ? char(c - 'a' + 'A') : c; });
  return upper;
}

}  // namespace flexopt
