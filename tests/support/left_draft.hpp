#pragma once
// What a killed process leaves of a file that it was writing.
#include <sys/wait.h>
#include <unistd.h>

#include <string>

namespace flexopt::test {

inline std::string this_host() {
  char name[256] = {};
  return ::gethostname(name, sizeof name - 1) == 0 ? name : "";
}

/// A process of this machine that is gone.
inline pid_t gone_process() {
  const pid_t gone = ::fork();
  if (gone == 0) ::_exit(0);
  ::waitpid(gone, nullptr, 0);
  return gone;
}

/// The name of the draft that such a process left of the file `name`.
inline std::string left_draft(const std::string& name) {
  return "." + name + "." + this_host() + "." + std::to_string(gone_process()) + ".part";
}

}  // namespace flexopt::test
