#pragma once
// What the sources of flexopt.hpp share: the public names beside ours.
#define FLEXOPT_MAKES_LIBRARY  // public names are flexopt::v0::Job, ours flexopt::Job
#include <string>
#include <vector>

#include "core/spec/spec_error.hpp"
#include "optim/job/job.hpp"
#include "results/library/flexopt.hpp"
#include "results/library/runs.hpp"

namespace flexopt::v0 {

struct Job::Impl {
  flexopt::Job job;
};

struct Result::Impl {
  FinishedRun run;
  std::vector<std::string> gradients;  ///< names
};

/// Throws the exception of flexopt.hpp that corresponds to the error.
[[noreturn]] void raise(const SpecError& error);

/// What `work` returns; its SpecError becomes a JobError.
template <class Work>
auto translated(Work work) {
  try {
    return work();
  } catch (const SpecError& error) {
    raise(error);
  }
}

}  // namespace flexopt::v0
