#pragma once
// What a job may say, but probably means otherwise.
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "optim/job/job.hpp"

namespace flexopt {

/// A sentence for each thing that is odd: JSON pointer, value with unit, why it is odd, and what is
/// probably meant. They change no number and no status. `mechanism`: of the job, at its own
/// parameters. `written`: the job as its file has it.
std::vector<std::string> warnings_of(const Job& job, const Mechanism& mechanism,
                                     const nlohmann::json& written);

}  // namespace flexopt
