#pragma once
// The program as a child that a test starts, kills and waits for.
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "support/binary.hpp"
#include "support/temporary_folder.hpp"

namespace child {

using Folder = flexopt::test::TemporaryFolder;

inline std::string read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

/// `flexopt run JOB --out OUT --quiet --threads N`
inline pid_t start(const std::filesystem::path& job, const std::filesystem::path& out,
                   const char* threads) {
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

/// Its exit code, -1 where it was killed.
inline int finished(pid_t child) {
  int status = 0;
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

}  // namespace child
