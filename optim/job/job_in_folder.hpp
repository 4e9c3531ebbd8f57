#pragma once
#include <string>

#include "optim/job/job.hpp"

namespace flexopt {

/// Parses a job as parse_job does; files that the job names are relative to `folder`.
Job parse_job_in(const std::string& folder, const nlohmann::json& document);

}  // namespace flexopt
