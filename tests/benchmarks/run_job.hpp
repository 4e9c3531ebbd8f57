#pragma once

#include <sys/resource.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

namespace flexopt {

/// Processor time of all programs that were run so far [s].
inline double seconds_of_children() {
  rusage use{};
  getrusage(RUSAGE_CHILDREN, &use);
  return static_cast<double>(use.ru_utime.tv_sec + use.ru_stime.tv_sec) +
         1e-6 * static_cast<double>(use.ru_utime.tv_usec + use.ru_stime.tv_usec);
}

/// The result of a job that the program runs, with `options` ("--set /optimise/starts=8"). Ends
/// this program where the job could not be run. A result that is not usable is one, too.
inline nlohmann::json run_job(const std::filesystem::path& job, const std::string& options = "") {
  const std::filesystem::path out =
      std::filesystem::temp_directory_path() /
      ("flexopt_bench_" + std::to_string(getpid()) + "_" + job.stem().string());
  std::filesystem::remove_all(out);
  const std::string command = "\"" FLEXOPT_PROGRAM "\" run \"" + job.string() +
                              "\" --quiet --out \"" + out.string() + "\" " + options + " >&2";
  const int status = std::system(command.c_str());
  nlohmann::json result = nlohmann::json::parse(std::ifstream(out / "result.json"), nullptr, false);
  std::filesystem::remove_all(out);
  if (status == -1 || result.is_discarded()) {
    std::fprintf(stderr, "no result from: %s\n", command.c_str());
    std::exit(1);
  }
  return result;
}

}  // namespace flexopt
