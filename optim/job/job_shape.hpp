#pragma once
// The tables that describe a job file: keys, units, ranges, defaults, meaning.
#include <string>
#include <vector>

#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"
#include "optim/job/job_cases.hpp"
#include "optim/job/job_goals.hpp"

namespace flexopt {

/// The job of a family: its parameters, and the unit of its stroke. Without a family: what any job
/// may hold, for the schema and for jobs whose family is not readable.
Shape job_shape(const Family* family);
/// Schema of a job with "accuracy": "auto", whose model.tolerance bounds the estimated errors.
Shape with_error_tolerance(Shape job);
/// Whether a job's document asks for that.
bool chooses_accuracy(const nlohmann::json& document);

/// The numbers of a family parameter: unit and range.
Shape parameter_shape(const Parameter& parameter);

/// The section "model", and an entry of "models": a name and any keys of the model.
Shape model_shape();
Shape model_entry_shape();

/// What the section "model" says; `at` is its place. What its keys contradict is added to `faults`.
ModelChoice read_model(const nlohmann::json& read, const JsonPointer& at, FaultList& faults);

/// Refuses a model that the design's leaves do not allow: plates of wires, or of a material with a
/// Poisson's ratio above a half. Throws SpecError.
void check_leaf_model(const DesignSpec& design, const ModelOptions& model, const JsonPointer& at);

/// Fills in the section "optimise". `read` has passed its table; bounds get their units here, and
/// `read` is completed with what was decided; `job` is read but for its sections, and takes notes.
/// What is wrong is added to `faults`; parts that depend on something wrong are not checked.
/// Goals may name one of `cases`, and count `tolerances` where the job has some.
OptimiseSpec read_optimise(nlohmann::json& read, const Family& family, Job& job,
                           const CaseNames& cases, Borne borne, FaultList& faults);

/// Fills in the sections "samples" and "models" of a job that has passed its table, and completes
/// them in `read` with what was decided. Faults as in read_optimise.
CompareSpec read_compare(nlohmann::json& read, const Family& family, const Job& job,
                         FaultList& faults);

}  // namespace flexopt
