#pragma once
// JSON against what is expected of it.
#include <nlohmann/json.hpp>
#include <string>

#include "results/files/json_text.hpp"

namespace flexopt::test {

/// Where `found` is not as expected, a line each with what is there: "" where it is. Its objects
/// may have more members, its arrays have as many.
inline std::string unlike(const OrderedJson& found, const OrderedJson& expected,
                          const std::string& at = {}) {
  const bool same_kind = found.type() == expected.type() && expected.is_structured();
  if (!same_kind || (expected.is_array() && found.size() != expected.size()))
    return found == expected ? "" : at + " is " + found.dump() + "\n";
  std::string all;
  for (const auto& [key, value] : expected.items()) {
    const OrderedJson::json_pointer here = OrderedJson::json_pointer() / key;
    all += found.contains(here) ? unlike(found[here], value, at + "/" + key)
                                : at + "/" + key + " is not there\n";
  }
  return all;
}

/// The same with a text as expected.
inline std::string unlike_text(const OrderedJson& found, const std::string& expected) {
  return unlike(found, OrderedJson::parse(expected));
}

}  // namespace flexopt::test
