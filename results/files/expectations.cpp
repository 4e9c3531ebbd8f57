#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "results/files/result_json.hpp"

namespace flexopt {

namespace {

/// The number at the pointer, or why there is none.
std::optional<double> number_at(const OrderedJson& result, const std::string& pointer,
                                std::string& why) try {
  const OrderedJson& found = result.at(OrderedJson::json_pointer(pointer));
  if (found.is_number()) return found.get<double>();
  why =
      fmt::format("{} is {}, not a number", pointer, found.is_null() ? "null" : found.type_name());
  return std::nullopt;
} catch (const OrderedJson::exception&) {
  why = fmt::format("{} is not in the result", pointer);
  return std::nullopt;
}

}  // namespace

std::vector<std::string> check_expectations(const std::vector<Expectation>& expectations,
                                            OrderedJson& result) {
  OrderedJson list = OrderedJson::array();
  std::vector<std::string> failures;
  for (const Expectation& expected : expectations) {
    std::string why;
    const auto value = number_at(result, expected.pointer, why);
    const bool ok = value && std::abs(*value - expected.value) <= expected.tolerance;
    if (value && !ok)
      why = fmt::format("{} = {}, expected {} ± {} ({})", expected.pointer, *value, expected.value,
                        expected.tolerance, expected.source);
    if (!ok) failures.push_back(why);
    list.push_back({{"pointer", expected.pointer},
                    {"expected", expected.value},
                    {"tolerance", expected.tolerance},
                    {"value", value ? OrderedJson(*value) : OrderedJson()},
                    {"ok", ok},
                    {"source", expected.source}});
  }
  if (expectations.empty()) return failures;
  result["expectations"] = std::move(list);
  if (!failures.empty() && result["status"] == "ok") {
    result["status"] = "expectation_failed";
    result["message"] = fmt::format("{} of {} expected numbers differ; first: {}.", failures.size(),
                                    expectations.size(), failures.front());
  }
  return failures;
}

}  // namespace flexopt
