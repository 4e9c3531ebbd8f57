#include "results/run/join_crew.hpp"

#include <dlfcn.h>
#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "core/spec/spec_error.hpp"
#include "optim/job/job_in_folder.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

/// Beside the program, or where it was installed.
fs::path library() {
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path();
  const fs::path beside = program / "flexopt_mpi.so";
  return fs::exists(beside) ? beside : program.parent_path() / FLEXOPT_LIBDIR / "flexopt_mpi.so";
}

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
  const fs::path file = library();
  if (!fs::exists(file)) throw no_mpi("no " + file.filename().string());
  // global: Open MPI loads parts of its own that look for it
  void* const loaded = ::dlopen(file.c_str(), RTLD_NOW | RTLD_GLOBAL);
  if (!loaded) throw no_mpi(::dlerror());
  using Join = Crew* (*)();
  const auto join = reinterpret_cast<Join>(::dlsym(loaded, "flexopt_join_crew"));
  if (!join) throw no_mpi(::dlerror());
  return std::unique_ptr<Crew>(join());
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
