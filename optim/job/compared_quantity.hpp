#pragma once
// What a job "compare" compares: rows of the table of quantities.
#include <string>
#include <vector>

#include "core/response/quantities.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// Numbers that are compared under one name: those of a row of the table, or the natural
/// frequencies of both lists.
struct ComparedQuantity {
  std::string name;  ///< "drive_load", "frequencies", "load_capacity"
  struct Number {
    const QuantityRow* row = nullptr;
    int component = 0;
    int part = -1;  ///< among `parts`
  };
  std::vector<Number> numbers;
  std::vector<std::string> parts;  ///< that have figures of their own: directions, drives, …
  std::string part_key;            ///< "by_direction" or "by_component"; empty without parts
  Outputs needs;                   ///< of an evaluation
  /// One motion: the error is that of the vector, over the largest vector of the path.
  bool motion = false;
  bool of_design = false;  ///< one number of the design, which is compared once
};

/// Every name that "quantities" of a job may list: the contract's six first.
std::vector<std::string> comparable_quantities();

/// What the job compares: what it lists in "quantities"; else the drive load, motion, stiffness,
/// stress and frequencies, and what its other sections ask for (buckling, load_capacity, dynamics,
/// fillet, fatigue and the strengths of its materials); then the quantities that it defines.
std::vector<ComparedQuantity> compared_quantities(const Job& job);

/// Outputs that an evaluation needs for these quantities.
Outputs needs_of(const std::vector<ComparedQuantity>& quantities);

/// Whether an evaluation by the request has such a quantity.
Check check_comparison(const std::string& name, const StrokeRequest& request);

}  // namespace flexopt
