#pragma once
// A job as something to try numbers on: a move of its sliders → what the page shows.
#include <string>
#include <vector>

#include "results/files/json_text.hpp"
#include "results/server/sliders.hpp"

namespace flexopt {

class Explorer {
 public:
  /// Throws as sliders_of does.
  explicit Explorer(Job job);

  const Job& job() const { return job_; }
  const std::vector<Slider>& sliders() const { return sliders_; }
  /// What the page needs of them: [{"name", "unit", "meaning", "value", "min", "max", "whole"}].
  OrderedJson slider_table() const;

  /// The design with these numbers, evaluated as a run of a job "evaluate" does it but for maps and
  /// tolerances:
  ///     {"ok": true, "seconds", "result", "scene", "goals"}
  /// `goals` are objective and constraints of an optimisation, without what tolerances do to them:
  /// {"label", "role", "sense" or "min", "max", "met", "value", "unit", "as"}. Where the design
  /// breaks a rule or has no equilibrium: {"ok": false, "seconds", "message"}. Thread-safe.
  OrderedJson evaluate(const ParameterValues& values) const;

  /// The job file with these numbers.
  std::string job_text(const ParameterValues& values) const;

 private:
  Job job_;
  std::vector<Slider> sliders_;
};

}  // namespace flexopt
