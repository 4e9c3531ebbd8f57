#pragma once
// The designs of a job "compare".
#include <string>
#include <vector>

#include "optim/job/job.hpp"

namespace flexopt {

struct Sample {
  ParameterValues parameters;  ///< all of the family's; only the sampled ones where `refused`
  ParameterValues symbols;     ///< sampled numbers that only formulas use
  std::vector<double> stroke;  ///< [m or rad]; of several load cases one after the other
  /// For several drives, the strokes of all of them, point by point; `stroke` holds those of the
  /// first.
  std::vector<VectorXd> strokes;
  std::string refused;  ///< why there is no such design; empty otherwise
};

/// The job's designs in their order. A design whose formulas have no value or leave a parameter's
/// range is refused in words, not left out.
std::vector<Sample> make_samples(const Job& job);

/// The mechanism of a sample. Throws SpecError where the parameters contradict each other.
Mechanism make_mechanism(const Job& job, const Sample& sample);

}  // namespace flexopt
