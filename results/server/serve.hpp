#pragma once
// The two pages that are served: a design whose numbers can be moved, and a run that goes on.
#include <filesystem>
#include <functional>
#include <string>

#include "optim/job/job.hpp"

namespace flexopt {

/// Is told the page's address once it can be opened.
using SayAddress = std::function<void(const std::string& address)>;

/// Serves the page of a job until Ctrl-C. Throws SpecError for a port that is taken, and for a job
/// without a design to look at. Nothing is written to disk.
void serve_explorer(const Job& job, int port, const SayAddress& say);

/// Serves the page of the run in a folder until Ctrl-C. Throws SpecError for a port that is taken,
/// and where there is no such folder. Nothing is written to disk.
void serve_watch(const std::filesystem::path& folder, int port, const SayAddress& say);

}  // namespace flexopt
