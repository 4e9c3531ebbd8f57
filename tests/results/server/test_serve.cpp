// The two servers as a user starts them.
#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>

#include "results/files/folder.hpp"
#include "results/files/json_text.hpp"
#include "support/binary.hpp"
#include "support/loopback.hpp"
#include "tests/results/results_tests.hpp"

using Catch::StartsWith;

namespace {

class Program {
 public:
  Program(const std::string& command, const std::string& what) {
    int ends[2];
    REQUIRE(::pipe2(ends, O_CLOEXEC) == 0);
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, ends[1], STDOUT_FILENO);
    std::string name = test::binary(), verb = command, file = what;
    char* arguments[] = {name.data(), verb.data(), file.data(), nullptr};
    REQUIRE(::posix_spawn(&process_, name.c_str(), &actions, nullptr, arguments, environ) == 0);
    posix_spawn_file_actions_destroy(&actions);
    ::close(ends[1]);
    for (char letter; ::read(ends[0], &letter, 1) == 1 && letter != '\n';) address += letter;
    ::close(ends[0]);
    REQUIRE_THAT(address, StartsWith("http://127.0.0.1:"));
    const std::size_t colon = address.rfind(':'), equals = address.find("/?token=");
    port = std::stoi(address.substr(colon + 1));
    token = address.substr(equals + 8);
  }
  ~Program() {
    if (process_ > 0) (void)end(SIGKILL);
  }
  int end(int with) {
    ::kill(process_, with);
    int status = 0;
    ::waitpid(process_, &status, 0);
    process_ = -1;
    return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
  }
  std::string get(const std::string& path) const {
    return test::asked(
        port, "GET " + path + " HTTP/1.1\r\nHost: 127.0.0.1:" + std::to_string(port) + "\r\n\r\n");
  }
  std::string post(const std::string& path, const std::string& body) const {
    return test::asked(
        port, "POST " + path + " HTTP/1.1\r\nHost: localhost:" + std::to_string(port) +
                  "\r\nX-Flexopt-Token: " + token +
                  "\r\nContent-Length: " + std::to_string(body.size()) + "\r\n\r\n" + body);
  }

  std::string address, token;
  int port = 0;

 private:
  pid_t process_ = -1;
};

OrderedJson body_of(const std::string& answer) {
  return OrderedJson::parse(answer.substr(answer.find("\r\n\r\n") + 4));
}

const char* leaf = R"({
  "flexopt": 1, "name": "a </script> leaf", "job": "evaluate",
  "design": {"family": "leaf_spring",
             "parameters": {"length": "80 mm", "width": "20 mm", "thickness": "0.3 mm"},
             "material": {"youngs_modulus": "200 GPa", "poissons_ratio": 0.3,
                          "density": "7800 kg/m^3"}},
  "end_effector": {"mass": "20 g"}, "stroke": {"from": 0, "to": "4 mm", "points": 2},
  "model": {"accuracy": "full", "mesh": [4, 2]}, "frequencies": 0})";

}  // namespace

TEST_CASE("explore serves a page, evaluates moves, writes the job, and leaves nothing") {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "leaf.json", leaf);
  Program program("explore", (folder.path() / "leaf.json").string());
  const std::string page = program.get("/?token=" + program.token);
  CHECK_THAT(page, StartsWith("HTTP/1.1 200 OK\r\n"));
  for (const char* header :
       {"Content-Security-Policy: default-src 'none'; script-src 'nonce-", "nosniff", "no-store",
        "X-Frame-Options: DENY", "Cross-Origin-Resource-Policy: same-origin"})
    CHECK_THAT(page, Contains(header));
  CHECK_THAT(page, !Contains("a </script> leaf"));
  CHECK(page != program.get("/?token=" + program.token));  // another nonce
  CHECK_THAT(program.get("/"), StartsWith("HTTP/1.1 403"));
  CHECK_THAT(program.get("/?token=" + program.token.substr(1)), StartsWith("HTTP/1.1 403"));

  const std::string answer = program.post("/evaluate", R"({"parameters": {"length": 0.07}})");
  CHECK_THAT(answer, StartsWith("HTTP/1.1 200"));
  CHECK(body_of(answer)["result"]["job"]["design"]["parameters"]["length"] == 0.07);
  const std::string wrong = program.post("/evaluate", R"({"parameters": {"length": 7}})");
  CHECK_THAT(wrong, StartsWith("HTTP/1.1 400"));
  CHECK_THAT(wrong, Contains("expected a number from 0.04 to 0.16 m"));
  const OrderedJson job = body_of(program.post("/job", R"({"parameters": {"length": 0.07}})"));
  CHECK(job["design"]["parameters"]["length"] == 0.07);
  CHECK_THAT(program.post("/state", R"({"since": ""})"), StartsWith("HTTP/1.1 404"));
  CHECK(program.end(SIGINT) == 0);
  CHECK(std::distance(std::filesystem::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("watch serves a finished run and nothing else") {
  const test::TemporaryFolder folder;
  write_file(folder.path() / "result.json", R"({"status": "ok", "message": "fine"})");
  write_file(folder.path() / "scene.json", "null");
  Program program("watch", folder.path().string());
  CHECK_THAT(program.get("/?token=" + program.token), StartsWith("HTTP/1.1 200 OK\r\n"));
  const OrderedJson state = body_of(program.post("/state", R"({"since": ""})"));
  CHECK(state["finished"] == true);
  CHECK(state["result"]["message"] == "fine");
  CHECK_THAT(program.post("/evaluate", R"({"parameters": {}})"), StartsWith("HTTP/1.1 404"));
  CHECK(program.end(SIGTERM) == 0);
}
