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

// Stroke of a design in its first job.

/// "stroke" of a new job: from rest to the largest of 1, 2, 5, 10 … mm or deg, of all drives alike,
/// up to which the path is stable and the stress stays below `allowed` [Pa], on a coarse mesh by
/// this model. Throws SpecError where not even a thousandth can be followed.
OrderedJson first_stroke(const StartDesign& start, const ModelOptions& model, double allowed);

// What the first optimisation of a design looks for, and among what.

/// "optimise" of a new job: the highest parasitic frequency over the stroke, at no more than the
/// allowable stress and in a tenth more room than the start takes. Sizes, angles and ratios vary
/// between half and twice the start (angles by 17°), or less, so that the design is sound at the
/// corners of their box; counts and masses do not.
OrderedJson first_goals(const StartDesign& start);

}  // namespace flexopt
