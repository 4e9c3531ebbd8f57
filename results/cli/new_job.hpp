#pragma once
// A job to start from, for a design that has none yet.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "optim/job/found_design.hpp"
#include "results/files/json_text.hpp"

namespace flexopt {

/// An evaluation of the design at its defaults and examples, to be run and edited: of steel, with a
/// payload of some thirty times the mass of the leaves, over the largest round stroke at which the
/// stress stays below half of what the steel may see, accuracy and mesh chosen by estimated errors.
/// With `optimise`, a search for the dimensions that raise the parasitic frequency within the
/// allowable stress and some more than the room of that design.
///
/// `design`: {"family": NAME}, or {"file": FILE} relative to `folder`. Throws SpecError where the
/// design is wrong, has no drive or parameters without default and example, and where no stroke of
/// it can be followed.
OrderedJson new_job(const nlohmann::json& design, const std::string& folder, bool optimise);

struct NextJob {
  nlohmann::json job;
  std::vector<std::string> left_out;  ///< sections of the run's job
};

/// The job of a run as an evaluation at the design that it found: its load cases, surroundings,
/// stroke and model stay; what looks at many designs is left out. With `optimise`, a search as that
/// of new_job. Throws SpecError where the search has nothing to vary.
NextJob next_job(const FoundDesign& found, bool optimise);

/// 1, 2 or 5 times a power of ten: the largest that is not above the value, which is above zero.
double round_below(double value);

/// "0.4 mm", "45 deg", "20 g" of a value in SI; plain numbers and zero stay numbers.
OrderedJson readable(double value, const std::string& unit);

}  // namespace flexopt
