#include <fmt/format.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "optim/job/job_sections.hpp"
#include "results/files/program_part.hpp"
#include "results/files/version.hpp"
#include "results/run/shard.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

SpecError no_mpi(const std::string& why) {
  return {"mpirun", std::to_string(started_together()) + " processes",
          "this flexopt cannot share a run by MPI (" + why +
              "): build it where Open MPI is (libopenmpi-dev), or use --shard"};
}

}  // namespace

int started_together() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* size = std::getenv(name)) return std::atoi(size);
  return 0;
}

std::unique_ptr<Crew> join_crew() {
  if (started_together() < 2) return nullptr;
  // global: Open MPI loads parts of its own that look for it
  const PartFunction join = part_function("flexopt_mpi.so", "flexopt_join_crew", PartNames::global);
  if (!join.address) throw no_mpi(join.missing);
  return std::unique_ptr<Crew>(reinterpret_cast<Crew* (*)()>(join.address)());
}

void tell_job(Crew& crew, const Job& job, const fs::path& job_folder) {
  crew.tell(nlohmann::json{build_id(), document_of(job), job_folder.string()}.dump());
}

Job hear_job(Crew& crew) {
  const auto told = nlohmann::json::parse(crew.hear());
  if (told.at(0) != build_id())
    throw SpecError("mpirun", build_id(),
                    fmt::format("expected the flexopt of the first process, {}",
                                told.at(0).get<std::string>()));
  return parse_job_in(told.at(2).get<std::string>(), told.at(1));
}

}  // namespace flexopt
