#pragma once
// Values and choices for tests that go through all families.
#include <map>
#include <string>
#include <vector>

#include "designs/family.hpp"

namespace flexopt {

/// A sensible design of a family: its defaults, and values where it has none.
inline ParameterValues sample_values(const Family& family) {
  const std::map<std::string, double> usual{
      {"length", 0.08},      {"width", 0.03},        {"thickness", 4e-4},
      {"spacing", 0.06},     {"gap", 1e-3},          {"outer_width", 0.02},
      {"inner_width", 0.05}, {"load_point_x", 0.03}, {"load_point_z", 0.01}};
  ParameterValues values;
  for (const Parameter& p : family.parameters)
    values[p.name] = p.default_value ? *p.default_value : usual.at(p.name);
  if (values.contains("half_angle") && values.contains("gap")) values["half_angle"] = 0.6;
  return values;
}

/// Every combination of a family's choices.
inline std::vector<FamilyChoices> all_choices(const Family& family) {
  std::vector<FamilyChoices> all{{}};
  for (const FamilyOption& option : family.options) {
    std::vector<FamilyChoices> next;
    for (const FamilyChoices& chosen : all)
      for (const std::string& choice : option.choices) {
        next.push_back(chosen);
        next.back()[option.name] = choice;
      }
    all = std::move(next);
  }
  return all;
}

}  // namespace flexopt
