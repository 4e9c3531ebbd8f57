#pragma once
// Values and choices for tests that go through all families.
#include <map>
#include <string>
#include <vector>

#include "core/mechanism/each_number.hpp"
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

/// What an end-effector may carry, with a centre of mass and moments of inertia of its own.
inline EndEffector some_payload() {
  EndEffector e;
  e.mass = 0.5;
  e.inertia = Vector3d(1e-4, 2e-4, 2.5e-4).asDiagonal();
  e.center_of_mass = Vector3d(0.01, -0.02, 0.03);
  return e;
}

/// All numbers of a mechanism, in the order of each_number.
inline std::vector<double> numbers_of(const Mechanism& mechanism) {
  std::vector<double> all;
  each_number(mechanism, [&](double x) { all.push_back(x); });
  return all;
}

}  // namespace flexopt
