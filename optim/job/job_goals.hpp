#pragma once
// What goals and variables of a job have in common, whatever section they stand in.
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/response/quantities.hpp"
#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"
#include "optim/job/job_cases.hpp"

namespace flexopt {

/// What the job defines that its goals may take into account.
struct Borne {
  bool tolerances = false, assembly_tolerances = false;
};

/// What goals need to know of the rest of the job.
struct GoalContext {
  const Family& family;
  const DesignSpec& design;
  const StrokeRequest& request;
  std::vector<Quantity> quantities;
  ParameterValues values;          ///< that formulas may use: parameters, material, end-effector
  std::vector<FormulaName> names;  ///< of these, the family's first
  const CaseNames& cases;
  Borne borne;
  FaultList& faults;

  GoalContext(const Family& family, const Job& job, const CaseNames& cases, Borne borne,
              FaultList& faults);

  /// The load case that a goal names; empty where it is over all of them. Throws SpecError.
  std::string load_case(const nlohmann::json& goal, const JsonPointer& at) const;
  /// Whether what the goal asks of the job is for this load case to answer.
  bool counts(const std::string& load_case) const {
    return load_case.empty() || load_case == cases.own;
  }
  const Quantity* find_quantity(const std::string& name) const;
  /// The quantity of that name, with what it asks of the rest of the job. Throws SpecError.
  const Quantity& quantity(const std::string& name, const std::string& load_case,
                           const JsonPointer& at) const;
};

/// Throws SpecError where a formula of the parameters is asked for at places of the stroke.
void forbid_over_stroke(const nlohmann::json& read, const JsonPointer& at);

/// "max_stress max over stroke, case up"
std::string goal_label(const Constraint& goal);

/// A quantity over the stroke, or a formula, without bounds. `usual`: which value over the stroke
/// is meant where `read` does not say; nothing: it must. Throws SpecError.
Constraint read_measure(nlohmann::json& read, const GoalContext& context, const JsonPointer& at,
                        const std::optional<OverStroke>& usual);

/// Name and bounds of a parameter that may differ; the bounds are written back in SI. Faults of the
/// bounds go to the context. Throws SpecError for what cannot differ.
Variable read_range(nlohmann::json& read, const GoalContext& context, const JsonPointer& at);

}  // namespace flexopt
