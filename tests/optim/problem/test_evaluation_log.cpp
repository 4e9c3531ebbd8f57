// An interrupted run goes on where it stopped, and ends as if it had never been interrupted.
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

using namespace flexopt::guide;

namespace {

json small_job(const std::string& algorithm) {
  json document = stiff_guide(algorithm);
  document["optimise"]["starts"] = 2;
  document["optimise"]["max_evaluations"] = 40;
  return document;
}

struct Run {
  Optimum optimum;
  int calls = 0, replayed = 0;
  std::string log;
};

Run run(const json& document, const fs::path& log, int threads = 1, OptimiseOptions options = {}) {
  Calls calls;
  Run r;
  options.log = log;
  options.threads = threads;
  options.progress = [&](const EvaluationRecord&, const Progress& p) { r.replayed = p.replayed; };
  r.optimum = guide::run(document, calls, false, options);
  r.calls = calls.reduced;
  r.log = test::content_of(log);
  return r;
}

/// Everything but the responses, which follow from the parameters.
void check_same(const Optimum& a, const Optimum& b) {
  CHECK(a.status == b.status);
  CHECK(a.stop_reason == b.stop_reason);
  CHECK(a.parameters == b.parameters);
  CHECK(a.objective == b.objective);
  CHECK(a.best_start == b.best_start);
  CHECK(a.evaluations == b.evaluations);
  const auto numbers = [](const EvaluationRecord& r) {
    return std::tie(r.variables, r.objective, r.constraints, r.violation);
  };
  CHECK(std::ranges::equal(a.history, b.history, {}, numbers, numbers));
}

}  // namespace

TEST_CASE("a run cut off anywhere resumes to the same end", "[slow]") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LD_SLSQP", "ipopt");
  CAPTURE(name);
  const test::TemporaryFolder folder;
  const auto logged = [&] { return run(small_job(name), folder / "log"); };
  const Run whole = logged();
  CHECK(whole.replayed == 0);
  const std::vector<std::size_t> begins = test::line_begins(whole.log);
  REQUIRE(static_cast<int>(begins.size()) == whole.optimum.evaluations + 2);
  for (std::size_t i = 0; i < begins.size(); ++i) {
    // just after line i, and in the midst of line i + 1
    std::vector<std::size_t> cuts{begins[i]};
    if (i + 1 < begins.size()) cuts.push_back((begins[i] + begins[i + 1]) / 2);
    for (const std::size_t cut : cuts) {
      CAPTURE(i, cut);
      test::put(folder / "log", whole.log.substr(0, cut));
      const Run resumed = logged();
      const int kept = std::max(0, static_cast<int>(i) - 1);
      CHECK(resumed.replayed >= kept);
      CHECK(resumed.calls == whole.calls - resumed.replayed);
      check_same(resumed.optimum, whole.optimum);
      CHECK(resumed.log == whole.log);
    }
  }
}

TEST_CASE("the threads change neither the result nor a byte of the log") {
  const auto name = GENERATE(as<std::string>(), "LN_COBYLA", "LD_SLSQP", "ipopt", "GN_ISRES");
  CAPTURE(name);
  const test::TemporaryFolder folder;
  json document = small_job(name);
  document["optimise"]["starts"] = 5;
  const Run one = run(document, folder / "1.jsonl", 1);
  for (const int threads : {2, 3, 8}) {
    const Run more = run(document, folder / (std::to_string(threads) + ".jsonl"), threads);
    check_same(more.optimum, one.optimum);
    CHECK(more.log == one.log);
  }
}

TEST_CASE("the log of another job is refused, unless it is overwritten") {
  const test::TemporaryFolder folder;
  run(small_job("LN_COBYLA"), folder / "log");
  const std::string before = test::content_of(folder / "log");
  json other = small_job("LN_COBYLA");
  other["design"]["parameters"]["width"] = "31 mm";
  CHECK_THROWS_AS(run(other, folder / "log"), SpecError);
  CHECK_THROWS_WITH(run(other, folder / "log"), Contains("another job") &&
                                                    Contains("/job/design/parameters/width") &&
                                                    Contains("0.031"));
  CHECK(test::content_of(folder / "log") == before);
  OptimiseOptions newer;
  newer.version = "2.0";
  CHECK_THROWS_WITH(run(small_job("LN_COBYLA"), folder / "log", 1, newer), Contains("/version"));
  OptimiseOptions overwrite;
  overwrite.overwrite_log = true;
  const Run r = run(other, folder / "log", 1, overwrite);
  CHECK(r.replayed == 0);
  CHECK(run(other, folder / "log").replayed == r.optimum.evaluations);
}

TEST_CASE("name, more starts and more evaluations keep the log of use") {
  const test::TemporaryFolder folder;
  json document = small_job("LN_COBYLA");
  document["optimise"]["max_evaluations"] = 15;
  const Run first = run(document, folder / "log");
  document["name"] = "the same, longer";
  document["optimise"]["max_evaluations"] = 40;
  document["optimise"]["starts"] = 3;
  const Run second = run(document, folder / "log");
  CHECK(second.replayed >= first.optimum.evaluations - 8);  // but for the last look at derivatives
  // nothing that was evaluated is thrown away
  CHECK(std::count(second.log.begin(), second.log.end(), '\n') > second.optimum.evaluations);
}

TEST_CASE("what is no log is left alone") {
  const test::TemporaryFolder folder;
  for (const char* text : {"hello\n", "hello", "{\"a\": 1}\n", "[]\n"}) {
    test::put(folder / "log", text);
    CHECK_THROWS_AS(run(small_job("LN_COBYLA"), folder / "log"), SpecError);
    CHECK(test::content_of(folder / "log") == text);
  }
  const Run good = run(small_job("LN_COBYLA"), folder / "good.jsonl");
  const std::size_t second = good.log.find('\n') + 1;
  test::put(folder / "log",
            good.log.substr(0, second) + "{\"start\": 0}\n" + good.log.substr(second));
  CHECK_THROWS_WITH(run(small_job("LN_COBYLA"), folder / "log"), Contains("line 2"));
  CHECK_THROWS_WITH(run(small_job("LN_COBYLA"), folder / "missing" / "log"),
                    Contains("not writable"));
}

TEST_CASE("the log holds one self-contained line for each evaluation") {
  const test::TemporaryFolder folder;
  const Run r = run(small_job("LD_SLSQP"), folder / "log");
  std::istringstream lines(r.log);
  std::string line;
  std::getline(lines, line);
  CHECK(json::parse(line)["flexopt_evaluations"]["job"]["design"]["family"] == "parallel_guide");
  std::size_t i = 0;
  bool any_difference = false;
  for (; std::getline(lines, line); ++i) {
    const auto j = json::parse(line);
    REQUIRE(i < r.optimum.history.size());
    const EvaluationRecord& e = r.optimum.history[i];
    CHECK(j["variables"]["length"].get<double>() == e.variables.at("length"));  // to the bit
    CHECK(j["objective"].get<double>() == e.objective);
    CHECK(j["values"][0].size() == 3);  // the stiffness at three stroke points
    any_difference = any_difference || j["difference"].get<bool>();
  }
  CHECK(i == r.optimum.history.size());
  CHECK(any_difference);
}
