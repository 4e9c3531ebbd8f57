#pragma once
// What a design lets its user choose.
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace flexopt {

/// One geometric parameter of a design.
struct Parameter {
  std::string name;
  std::string unit;                     ///< SI unit: "m", "rad", "1"
  std::optional<double> default_value;  ///< required when there is none
  /// Allowed range; an end is excluded where it is `open`.
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool open_min = false, open_max = false;
  std::string meaning;
};

/// A choice that a design offers by name, next to its numbers.
struct FamilyOption {
  std::string name;
  std::vector<std::string> choices;  ///< the first is the default
  std::string meaning;
};

using ParameterValues = std::map<std::string, double>;
using FamilyChoices = std::map<std::string, std::string>;  ///< option → choice

}  // namespace flexopt
