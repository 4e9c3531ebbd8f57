#pragma once
// The program as a child that a test starts, kills and waits for.
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "support/binary.hpp"
#include "support/temporary_folder.hpp"

using nlohmann::json;
namespace fs = std::filesystem;

namespace child {

using Folder = flexopt::test::TemporaryFolder;

inline std::string read(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// `flexopt run JOB --out OUT --quiet --threads N`
inline pid_t start(const fs::path& job, const fs::path& out, const char* threads) {
  const std::string program = flexopt::test::binary();
  const pid_t child = fork();
  if (child == 0) {
    if (!freopen("/dev/null", "w", stdout)) _exit(127);
    execl(program.c_str(), program.c_str(), "run", job.c_str(), "--out", out.c_str(), "--quiet",
          "--threads", threads, static_cast<char*>(nullptr));
    _exit(127);
  }
  return child;
}

/// Writes the job and starts it.
inline pid_t start(const fs::path& job, const nlohmann::json& document, const fs::path& out,
                   const char* threads) {
  std::ofstream(job) << document.dump();
  return start(job, out, threads);
}

/// Whether it has ended by itself; else it is killed.
inline bool ended_or_killed(pid_t child) {
  int status = 0;
  if (waitpid(child, &status, WNOHANG) == child) return true;
  kill(child, SIGKILL);
  waitpid(child, &status, 0);
  return false;
}

/// That both folders have these files with the same bytes.
inline void check_same(const fs::path& one, const fs::path& other,
                       const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    CAPTURE(name);
    CHECK(read(one / name).size() > 100);
    CHECK(read(other / name) == read(one / name));
  }
}

/// Its exit code, -1 where it was killed.
inline int finished(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace child
