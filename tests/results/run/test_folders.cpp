// Folders and clocks as they are on shared machines: read-only, removed, shared, going back.
#include <atomic>
#include <cstdlib>
#include <map>
#include <optional>
#include <thread>

#include "tests/results/results_tests.hpp"

using namespace flexopt::test;

namespace {

// Jobs of each kind that writes other files.
std::map<std::string, OrderedJson> jobs_of_all_kinds() {
  return {{"evaluate", leaf_job()}, {"optimise", optimised_leaf()}, {"compare", compared_leaf()}};
}

/// All files of a folder but those that say how long something took.
std::map<std::string, std::string> files_of(const fs::path& folder) {
  std::map<std::string, std::string> files;
  for (const fs::directory_entry& entry : fs::recursive_directory_iterator(folder)) {
    const std::string name = entry.path().filename().string();
    if (entry.is_regular_file() && name != "timings.json" && name != "evaluations.seconds.jsonl")
      files[fs::relative(entry.path(), folder).string()] = content_of(entry.path());
  }
  return files;
}

/// What the root must say before a command so that permissions count; nothing where it cannot.
std::optional<std::string> as_anyone() {
  if (::geteuid() != 0) return std::string();
  const std::string prefix = "setpriv --reuid=65534 --regid=65534 --clear-groups ";
  if (run_program("/", "--version", prefix).code == 0) return prefix;
  WARN("permissions mean nothing to root, and the program cannot be run as somebody else");
  return std::nullopt;
}

/// The program in the background, until it has ended. Nothing is asserted in its thread.
class Running {
 public:
  Running(const fs::path& folder, const std::string& arguments)
      : thread_([this, command = "cd '" + folder.string() + "' && '" + test::binary() + "' " +
                                 arguments + " >/dev/null 2>'" + words().string() +
                                 "' </dev/null"] {
          status_ = std::system(command.c_str());
          ended_ = true;
        }) {}
  ~Running() {
    if (thread_.joinable()) thread_.join();
  }
  Running(const Running&) = delete;
  Running& operator=(const Running&) = delete;
  bool has_ended() const { return ended_; }
  Outcome end() {
    thread_.join();
    REQUIRE(WIFEXITED(status_));
    return {WEXITSTATUS(status_), {}, content_of(words())};
  }

 private:
  fs::path words() const { return own_.path() / "err"; }

  TemporaryFolder own_;
  std::atomic<bool> ended_ = false;
  int status_ = -1;
  std::thread thread_;
};

}  // namespace

TEST_CASE("a folder that is read-only is refused before anything is computed") {
  const auto anyone = as_anyone();
  if (!anyone) return;
  const Workplace folder;
  fs::permissions(folder.path(), fs::perms(0755));
  for (const auto& [kind, job] : jobs_of_all_kinds()) {
    CAPTURE(kind);
    folder.put("leaf.json", job);
    const fs::path locked = folder / (kind + ".out");
    fs::create_directory(locked);
    fs::permissions(locked, fs::perms(0555));
    for (const char* out : {"", "/new"}) {
      const Outcome refused =
          folder.run("run leaf.json --quiet --out " + kind + ".out" + out, *anyone);
      CAPTURE(refused.err);
      CHECK(refused.code == 2);
      CHECK_THAT(refused.err, Contains(kind + ".out") && Contains("can be written"));
      CHECK(fs::is_empty(locked));
    }
    fs::permissions(locked, fs::perms(0755));
  }
}

TEST_CASE("a finished run in a folder that has become read-only stays as it is") {
  const auto anyone = as_anyone();
  if (!anyone) return;
  const Workplace folder;
  fs::permissions(folder.path(), fs::perms(0755));
  folder.put("leaf.json", optimised_leaf());
  REQUIRE(folder.run("run leaf.json --quiet --out out").code == 0);
  const auto before = files_of(folder / "out");
  for (const auto& [name, text] : before) fs::permissions(folder / "out" / name, fs::perms(0444));
  fs::permissions(folder / "out", fs::perms(0555));
  const Outcome again = folder.run("run leaf.json --quiet --out out", *anyone);
  CAPTURE(again.err);
  CHECK(again.code == 2);
  CHECK_THAT(again.err, Contains("can be written"));
  CHECK(files_of(folder / "out") == before);
  fs::permissions(folder / "out", fs::perms(0755));
}

TEST_CASE("a folder that is removed while a run goes on ends it in words", "[slow]") {
  const Workplace folder;
  OrderedJson job = leaf_job();  // as many points as fit into some tenths of a second
  job["stroke"]["points"] = 201;
  std::map<std::string, OrderedJson> jobs{{"evaluate", job}};
  job = optimised_leaf();
  job["stroke"]["points"] = 41;
  jobs["optimise"] = job;
  for (const auto& [kind, document] : jobs) {
    CAPTURE(kind);
    folder.put("leaf.json", document);
    const fs::path out = folder / "out";
    Running running(folder.path(), "run leaf.json --quiet --threads 1 --out out");
    // whether the run has begun is seen in its folder; how fast it is does not matter
    while (!fs::exists(out / "job.json") && !running.has_ended()) std::this_thread::yield();
    fs::remove_all(out);
    const Outcome outcome = running.end();
    CAPTURE(outcome.err);
    // a folder that went between two of its files may be there again, with whole files alone
    CHECK((outcome.code == 0 || outcome.code == 2));
    if (outcome.code == 2) CHECK_THAT(outcome.err, Contains("out") && Contains("expected"));
    if (fs::exists(out)) {
      for (const auto& [name, text] : files_of(out)) {
        CAPTURE(name);
        if (name.ends_with(".json")) CHECK(json::accept(text));
        CHECK_FALSE(name.ends_with(".new"));
      }
    }
    fs::remove_all(out);
    CHECK(folder.run("run leaf.json --quiet --out out").code == 0);
    fs::remove_all(out);
  }
}

TEST_CASE("two runs of one job in one folder leave the bytes of one") {
  for (const auto& [kind, job] : jobs_of_all_kinds()) {
    if (kind == "compare") continue;  // its result has times
    CAPTURE(kind);
    const Workplace folder;
    folder.put("leaf.json", job);
    REQUIRE(folder.run("run leaf.json --quiet --out alone").code == 0);
    {
      Running one(folder.path(), "run leaf.json --quiet --out out"),
          other(folder.path(), "run leaf.json --quiet --out out");
      for (Running* running : {&one, &other}) {
        const Outcome outcome = running->end();
        CAPTURE(outcome.err);
        CHECK((outcome.code == 0 || outcome.code == 2));
        if (outcome.code == 2) CHECK_THAT(outcome.err, Contains("expected"));
      }
    }
    CHECK(folder.run("run leaf.json --quiet --out out").code == 0);
    CHECK(files_of(folder / "out") == files_of(folder / "alone"));
  }
}

TEST_CASE("a clock that goes back changes no byte") {
  const Workplace folder;
  // sanitized programs want to be told that their library is not the first one
  const std::string preload =
      "ASAN_OPTIONS=\"$ASAN_OPTIONS:verify_asan_link_order=0\" LD_PRELOAD='" FLEXOPT_BACKWARD_CLOCK
      "' ";
  // the clock is another one
  REQUIRE(std::system((preload + "date +%Y | grep -q 2001").c_str()) == 0);
  for (auto& [kind, job] : jobs_of_all_kinds()) {
    if (kind == "compare") continue;
    CAPTURE(kind);
    OrderedJson limited = job;
    limited["limits"] = {{"seconds", "10 min"}};
    folder.put("leaf.json", limited);
    REQUIRE(folder.run("run leaf.json --quiet --out " + kind).code == 0);
    const Outcome back = folder.run("run leaf.json --quiet --out " + kind + ".back", preload);
    CAPTURE(back.err);
    CHECK(back.code == 0);
    CHECK(files_of(folder / (kind + ".back")) == files_of(folder.path() / kind));
  }
}
