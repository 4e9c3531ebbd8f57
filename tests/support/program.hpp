#pragma once
// The program as a user starts it.
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "support/binary.hpp"
#include "support/temporary_folder.hpp"

namespace flexopt::test {

struct Outcome {
  int code = -1;
  std::string out, err;
};

/// Runs the program in a folder. Arguments are the shell's; `environment`: "NAME=VALUE " before it.
inline Outcome run_program(const std::filesystem::path& folder, const std::string& arguments,
                           const std::string& environment = {}) {
  const TemporaryFolder streams;
  const auto file = [&](const char* name) { return (streams.path() / name).string(); };
  const std::string command = "cd '" + folder.string() + "' && " + environment + "'" + binary() +
                              "' " + arguments + " >'" + file("out") + "' 2>'" + file("err") +
                              "' </dev/null";
  const int status = std::system(command.c_str());
  REQUIRE(WIFEXITED(status));
  return {WEXITSTATUS(status), content_of(file("out")), content_of(file("err"))};
}

/// The same with stdout and stderr on a terminal of so many columns; `out` has all that it got.
inline Outcome run_on_terminal(const std::filesystem::path& folder, const std::string& arguments,
                               unsigned short columns) {
  winsize size{};
  size.ws_row = 24;
  size.ws_col = columns;
  int terminal = -1;
  const pid_t child = ::forkpty(&terminal, nullptr, nullptr, &size);
  REQUIRE(child >= 0);
  if (child == 0) {
    const std::string command =
        "cd '" + folder.string() + "' && TERM=xterm exec '" + binary() + "' " + arguments;
    ::execl("/bin/sh", "sh", "-c", command.c_str(), static_cast<char*>(nullptr));
    ::_exit(127);
  }
  Outcome outcome;
  std::array<char, 4096> some;
  for (ssize_t n = 0; (n = ::read(terminal, some.data(), some.size())) > 0;)
    outcome.out.append(some.data(), static_cast<std::size_t>(n));
  ::close(terminal);
  int status = 0;
  REQUIRE(::waitpid(child, &status, 0) == child);
  REQUIRE(WIFEXITED(status));
  outcome.code = WEXITSTATUS(status);
  return outcome;
}

/// A folder in which the program runs; files are named from there.
class Workplace : public TemporaryFolder {
 public:
  Outcome run(const std::string& arguments, const std::string& environment = {}) const {
    return run_program(path(), arguments, environment);
  }
  template <class Content>
  void put(const std::string& name, const Content& content) const {
    test::put(*this / name, content);
  }
  std::string content(const std::string& name) const { return content_of(*this / name); }
  nlohmann::ordered_json json(const std::string& name) const {
    return nlohmann::ordered_json::parse(content(name));
  }
  bool has(const std::string& name) const { return std::filesystem::exists(*this / name); }
  std::vector<std::string> names() const { return names_in(path()); }
};

}  // namespace flexopt::test
