#pragma once
// A job at another design: at given numbers, or at what a finished run found.
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// What a finished run is about.
struct FoundDesign {
  nlohmann::json job;          ///< as read; its "design" is whole: no other file is needed
  ParameterValues parameters;  ///< of the optimum, or of the design that was evaluated; SI
  FamilyChoices choices;       ///< of the design's options
};

/// What the run in `folder` found; of ranked designs the best. Throws SpecError at `pointer`: no
/// such folder, no finished run, no design.
FoundDesign found_design(const std::string& folder, const std::string& pointer);

/// "design" of a job at what was found: whole, with the material.
nlohmann::json design_of(const FoundDesign& found);

/// The document with what is found in the place of "design": {"result": folder}; other keys that
/// the job's design has go before.
nlohmann::json with_found_design(nlohmann::json document, const std::string& folder,
                                 FaultList& faults);
/// The document of a job that was read, with these numbers in the place of its own, and without
/// numbers that are expected of the old ones. Formulas stay.
nlohmann::json moved_job(const Job& job, const ParameterValues& values);
/// Reads a job as read_job does; where `result` is the folder of a run, at the numbers and options
/// of the design that was found there, but for those that `overrides` give. Throws SpecError:
/// several designs, a run of another design.
Job read_job_at(const std::string& file, const std::vector<std::string>& overrides,
                const std::string& result);
/// An evaluation as one of two designs: "elastic", as it is, and "rigid", whose frames, stages and
/// levers weigh the same and do not bend. Throws SpecError: another job, nothing that could be
/// rigid.
Job beside_rigid(const Job& job);

}  // namespace flexopt
