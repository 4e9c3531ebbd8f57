#pragma once
// The design that a new job begins with, and its numbers as a designer writes them.
#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "designs/family.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// A design at its defaults and examples, of steel.
struct StartDesign {
  std::shared_ptr<const Family> family;
  FamilyChoices choices;
  ParameterValues values;
  Material material;
  Mechanism mechanism;  ///< without payload

  Mechanism make(const ParameterValues& of) const {
    return family->make(of, choices, material, {});
  }
};

/// Design to start from, read and checked as new_job does; throws as new_job does.
StartDesign start_design(const nlohmann::json& design, const std::string& folder);

/// 1, 2 or 5 times a power of ten: the largest that is not above the value, which is above zero.
double round_below(double value);

/// "0.4 mm", "45 deg", "20 g" of a value in SI; plain numbers and zero stay numbers.
OrderedJson readable(double value, const std::string& unit);

}  // namespace flexopt
