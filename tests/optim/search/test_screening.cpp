// A box with a wide hill and a narrow, higher one: what a screening sees that a few starts do not.
#include <atomic>

#include "optim/problem/line_log.hpp"
#include "optim/search/optimise.hpp"
#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

constexpr double least_length = 0.05, least_thickness = 0.2e-3;  // of the box, as is its size
constexpr double lengths = 0.1, thicknesses = 0.8e-3;

struct Counted {
  std::atomic<int> reduced{0}, full{0}, differentiable{0};
};

/// Drive stiffness of two hills in the box of `stiff_guide`: 1 at (0.3, 0.3), wide, and 1.5 at
/// (0.8, 0.7), of a twentieth of the box. No equilibrium below 0.1 of the thickness. The drive load
/// is the length's share of its range.
StrokeEvaluator two_hills(Counted& counted) {
  return [&counted](const Mechanism& mechanism, const ModelOptions& model,
                    const StrokeRequest& request) {
    ++(model.accuracy == Accuracy::full ? counted.full : counted.reduced);
    if (request.values == PathValues::differentiable) ++counted.differentiable;
    const double a = (mechanism.leaves.front().length - least_length) / lengths,
                 b = (mechanism.leaves.front().thickness - least_thickness) / thicknesses;
    const auto hill = [&](double x, double y, double size) {
      return std::exp(-(std::pow(a - x, 2) + std::pow(b - y, 2)) / (size * size));
    };
    StrokeResponse response;
    for (const double x : request.points) {
      PathPoint p;
      p.stroke = x;
      if (b < 0.1) {
        p.status = PointStatus::no_equilibrium;
        p.message = "Newton stopped after 25 iterations";
        response.status = Status::no_equilibrium;
      } else {
        p.status = PointStatus::converged;
        p.drive_stiffness = hill(0.3, 0.3, 0.5) + 1.5 * hill(0.8, 0.7, 0.04);
        p.drive_load = a;
      }
      response.path.push_back(p);
    }
    return response;
  };
}

json global_job() {
  json document = guide::stiff_guide();
  json& o = document["optimise"];
  o["objective"] = {{"maximise", "drive_stiffness"}};
  o["constraints"] = json::array();
  o["max_evaluations"] = 200;
  o["search"] = "global";
  o["screened_designs"] = 1024;
  o["starts"] = 4;
  return document;
}

struct Run {
  Optimum optimum;
  int replayed = 0;
};

Run run(const json& document, Counted& counted, const fs::path& log = {}, int threads = 1) {
  OptimiseOptions options;
  options.evaluators = {two_hills(counted), by_differences};
  options.threads = threads;
  options.log = log;
  Run r;
  options.screening_progress = [&](const LoopState& p) { r.replayed = p.replayed; };
  r.optimum = optimise(parse_job(document), options);
  return r;
}

}  // namespace

TEST_CASE("a global search finds the narrow hill that starts pass by") {
  Counted counted;
  json document = global_job();
  const Optimum found = run(document, counted).optimum;
  INFO(found.stop_reason);
  CHECK(found.objective == Approx(1.5 + std::exp(-(0.25 + 0.16) / 0.25)).epsilon(1e-2));
  CHECK(found.parameters.at("length") == Approx(least_length + 0.8 * lengths).epsilon(0.01));
  REQUIRE(found.screening);
  CHECK(found.screening->designs == 1024);
  CHECK(found.screening->evaluated + found.screening->failed == 1024);
  CHECK(found.screening->clusters >= 2);
  REQUIRE(found.screening->searched.size() == 4);
  CHECK(found.screening->searched[0].objective >= found.screening->searched[1].objective);
  REQUIRE(found.optima.size() >= 2);  // the wide hill is among them
  CHECK(found.optima[1].ok);
  const StartSummary& second = found.starts[static_cast<std::size_t>(found.optima[1].start)];
  CHECK(second.objective == Approx(1).epsilon(1e-2));

  document["optimise"].erase("screened_designs");
  document["optimise"]["search"] = "starts";
  const Optimum plain = run(document, counted).optimum;
  CHECK(plain.objective < 1.1);
  CHECK_FALSE(plain.screening);
  CHECK(plain.optima.empty());
}

TEST_CASE("failures are counted by reason, and constraints that are missed") {
  Counted counted;
  json document = global_job();
  json& o = document["optimise"];
  o["constraints"] = {{{"quantity", "drive_load"}, {"over_stroke", "max"}, {"max", 0.5}},
                      {{"expression", "length"}, {"max", "80 mm"}}};
  const Optimum found = run(document, counted).optimum;
  REQUIRE(found.screening);
  const ScreeningReport& s = *found.screening;
  // 1.5 · 80 mm is at 0.7 of the length's range, 0.1 of the thickness's below the equilibria
  CHECK(s.ruled_out == Approx(0.3 * 1024).margin(3));
  CHECK(s.failed == Approx(0.1 * 0.7 * 1024).margin(4));
  REQUIRE(s.failures.size() == 2);
  CHECK(s.failures[0].what == "formulas missed by more than half of their bounds");
  CHECK(s.failures[0].designs == s.ruled_out);
  CHECK(s.failures[1].what == "no equilibrium");
  CHECK(s.failures[1].designs == s.failed);
  REQUIRE(s.violated.size() == 2);
  CHECK(s.violated[0].what == "length");
  CHECK(s.violated[0].designs == Approx(0.4 * 0.9 * 1024).margin(6));
  CHECK(s.violated[1].designs == Approx(0.2 * 0.9 * 1024).margin(6));
  CHECK(s.feasible == Approx(0.3 * 0.9 * 1024).margin(6));
  CHECK(s.nearly_feasible > 0);
  CHECK(found.parameters.at("length") <= 0.08 * (1 + 1e-4));
}

TEST_CASE("screening is on reduced leaves, and asks for no derivatives") {
  Counted counted;
  json document = global_job();
  document["model"]["accuracy"] = "full";
  const Job job = parse_job(document);
  const Screening found = screen(job, {.evaluators = {two_hills(counted), by_differences}});
  CHECK(found.starts.size() == 4);
  CHECK(counted.reduced >= 1024);
  CHECK(counted.full == 0);
  CHECK(counted.differentiable == 0);
}

TEST_CASE("goals that bear tolerances are screened without them") {
  Counted counted;
  json document = global_job();
  document["tolerances"] = {{"length", "1 mm"}};
  document["optimise"]["objective"].update({{"under", "tolerances"}, {"as", "worst"}});
  const Screening with = screen(parse_job(document),
                                {.evaluators = {two_hills(counted), by_differences}}),
                  without = screen(parse_job(global_job()),
                                   {.evaluators = {two_hills(counted), by_differences}});
  CHECK(with.report.evaluated > 900);
  CHECK(with.starts == without.starts);
}

TEST_CASE("a screening has the same bytes for any number of threads, cut off or not") {
  Counted counted;
  const json document = global_job();
  const test::TemporaryFolder folder;
  const fs::path whole = folder / "a.jsonl", cut = folder / "b.jsonl";
  const Run first = run(document, counted, whole);
  const int once = counted.reduced;
  const std::string lines = test::content_of(screening_log(whole));
  // a log that ends within a line, written by many threads
  test::put(screening_log(cut), lines.substr(0, lines.size() / 2));
  const auto kept = static_cast<int>(read_log_lines(screening_log(cut)).size());
  counted.reduced = 0;
  const Run second = run(document, counted, cut, 3);
  CHECK(test::content_of(screening_log(cut)) == lines);
  CHECK(test::content_of(cut) == test::content_of(whole));
  CHECK(second.replayed == kept);
  CHECK(counted.reduced == once - kept);
  CHECK(second.optimum.parameters == first.optimum.parameters);

  SECTION("more designs begin with the same ones, and fewer lose none") {
    json more = document;
    more["optimise"]["screened_designs"] = 1500;
    CHECK(run(more, counted, cut).replayed == 1024);
    const std::string long_log = test::content_of(screening_log(cut));
    CHECK_THAT(long_log, Catch::Matchers::StartsWith(lines));
    CHECK(run(document, counted, cut).replayed == 1024);
    CHECK(test::content_of(screening_log(cut)) == long_log);
    CHECK(screened_so_far(screening_log(cut)) == 1500);
  }
  SECTION("a changed digit is refused") {
    std::string changed = lines;
    const std::size_t at = changed.find("\n[500,") + 8;
    const std::size_t digit = changed.find_first_of("123456", at);
    ++changed[digit];
    test::put(screening_log(cut), changed);
    CHECK_THROWS_WITH(run(document, counted, cut),
                      Contains("screening.jsonl") && Contains("line 502: [500,"));
  }
  SECTION("the log of another job is refused") {
    json other = document;
    other["end_effector"]["mass"] = "2 kg";
    CHECK_THROWS_AS(check_screening_log(parse_job(other), screening_log(cut), ""), SpecError);
    CHECK_NOTHROW(check_screening_log(parse_job(document), screening_log(cut), ""));
  }
}

TEST_CASE("a box in which nothing can be evaluated is said") {
  Counted counted;
  json document = global_job();
  document["optimise"]["variables"][1]["max"] = "0.22 mm";
  const Optimum found = run(document, counted).optimum;
  CHECK(found.status == OptimumStatus::failed);
  CHECK_THAT(found.stop_reason, Contains("no equilibrium"));
  REQUIRE(found.screening);
  CHECK(found.screening->failed == 1024);
  CHECK(found.screening->searched.empty());
}
