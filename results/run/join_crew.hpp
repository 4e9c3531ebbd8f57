#pragma once
// Joins the processes that mpirun has started to a crew.
#include <filesystem>
#include <memory>

#include "optim/job/job.hpp"
#include "optim/numerics/sharing.hpp"

namespace flexopt {

/// How many processes the launcher of MPI says that it started; 0 where none did.
int started_together();

/// The crew of these processes; null where this process was started alone. MPI is in a library of
/// its own, flexopt_mpi.so, which nothing else loads. Throws SpecError where it is not there.
std::unique_ptr<Crew> join_crew();

/// Leader: tells the others the job, and the folder that files it names are relative to.
void tell_job(Crew& crew, const Job& job, const std::filesystem::path& job_folder);
/// The others: the job of the leader. Throws SpecError where that is another build of flexopt.
Job hear_job(Crew& crew);

}  // namespace flexopt
