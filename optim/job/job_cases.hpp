#pragma once
// A job with several load cases: as many jobs of one case each, which share all else.
#include <functional>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "core/spec/fault_list.hpp"
#include "core/spec/field_table.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

/// The load cases of a job, in alphabetical order, and which of them is being read.
struct CaseNames {
  std::vector<std::string> all;  ///< empty: a job with one case, which has no name
  std::string own;
};

/// Keys of a job that a case may have instead: what acts on the mechanism, and where it goes.
const std::vector<std::string>& case_keys();

/// Whether the document has "cases".
bool lists_cases(const nlohmann::json& document);

/// What "cases" may hold, from the fields of a whole job.
Field cases_field(const std::vector<Field>& of_job);

/// Reads every case with the rest of the document by `read_one`: a key that the case has stands in
/// the place of the job's own (a stroke in that of a load_path, too, and the other way round), all
/// others are the job's. The job that comes back is that of the first case, with all of them in
/// `Job::cases`. Faults stand where the document has what is wrong: /cases/up/loads/0/force, say.
Job read_cases(const nlohmann::json& document, FaultList& faults,
               const std::function<Job(const nlohmann::json& document, const CaseNames& cases,
                                       FaultList& faults)>& read_one);

}  // namespace flexopt
