#pragma once
// Comparison with numbers that CalculiX's solid elements gave, in files beside the tests. How they
// were made: tests/benchmarks/calculix/README.md.
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>

#include "core/response/response.hpp"
#include "support/nightly.hpp"
#include "support/temporary_folder.hpp"

namespace flexopt::solids {

inline nlohmann::json read(const std::string& name) {
  return nlohmann::json::parse(test::content_of(FLEXOPT_LITERATURE "/" + name));
}

/// look(name, solid) at all cases, or at every third one outside of nightly runs.
template <class Look>
void each_case(const nlohmann::json& cases, bool all, const Look& look) {
  int number = 0;
  for (const auto& [name, solid] : cases.items()) {
    if (number++ % 3 != 0 && !all && !test::nightly()) continue;
    CAPTURE(name);
    look(name, solid);
  }
}

/// Support stiffnesses, and frequencies with the drives held, of one point.
inline void compare_stiffness_and_modes(const PathPoint& ours, const nlohmann::json& theirs,
                                        double bar) {
  for (const auto& [name, value] : theirs.at("support_stiffness").items()) {
    CAPTURE(name);
    const auto found = std::ranges::find(direction_names, name);
    REQUIRE(found != direction_names.end());
    const auto& stiffness =
        ours.support_stiffness[static_cast<std::size_t>(found - direction_names.begin())];
    REQUIRE(stiffness.has_value());
    CHECK(*stiffness == Approx(value.get<double>()).epsilon(bar));
  }
  for (std::size_t i = 0; i < theirs.at("frequencies").size(); ++i) {
    CAPTURE(i);
    CHECK(ours.frequencies_locked.at(i) ==
          Approx(theirs.at("frequencies").at(i).get<double>()).epsilon(bar));
  }
}

}  // namespace flexopt::solids
