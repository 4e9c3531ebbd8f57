#include "core/spec/spec_error.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>

namespace flexopt {

namespace {

std::string message_of(const std::vector<Fault>& faults) {
  constexpr std::size_t most = 50;
  std::string text;
  for (std::size_t i = 0; i < std::min(faults.size(), most); ++i)
    text += (i == 0 ? "" : "\n") + faults[i].text();
  if (faults.size() > most) text += fmt::format("\n... and {} more", faults.size() - most);
  return text;
}

}  // namespace

std::string Fault::text() const {
  std::string text = source;
  if (line > 0) text += fmt::format(":{}:{}", line, column);
  if (!text.empty()) text += ": ";
  if (pointer.empty() && !source.empty() && value == source) return text + rule;  // a whole file
  return text + (pointer.empty() ? "/" : pointer) + " = " + value + "; " + rule;
}

SpecError::SpecError(std::string pointer, std::string value, std::string rule)
    : SpecError(std::vector<Fault>{
          {.pointer = std::move(pointer), .value = std::move(value), .rule = std::move(rule)}}) {}

SpecError::SpecError(const JsonPointer& pointer, std::string value, std::string rule)
    : SpecError(pointer.to_string(), std::move(value), std::move(rule)) {}

SpecError::SpecError(std::vector<Fault> faults)
    : std::runtime_error(message_of(faults)), faults_(std::move(faults)) {}

}  // namespace flexopt
