// Jobs to start from, of every family and of design files: they are right, and worth running.
#include "results/cli/new_job.hpp"

#include "designs/describe.hpp"
#include "optim/job/job_sections.hpp"
#include "results/run/progress.hpp"
#include "results/run/run.hpp"
#include "tests/results/results_tests.hpp"

namespace {

json job_of(const std::string& family, bool optimise) {
  return json::parse(new_job({{"family", family}}, "", optimise).dump());
}

double largest_stress(const StrokeResponse& response) {
  double largest = 0;
  for (const PathPoint& point : response.path)
    if (point.max_stress) largest = std::max(largest, point.max_stress->value);
  return largest;
}

}  // namespace

TEST_CASE("the new job of every family runs to its stroke's end, within its stress", "[slow]") {
  for (const Family& family : families()) {
    CAPTURE(family.name);
    json written = job_of(family.name, false);
    const FamilyChoices choices = default_choices(family);
    // the mesh of an elastic body is that of the design
    const bool by_estimates =
        family.has_end_effector(choices) &&
        family.make(usual_values(family), choices, materials().front().material, {})
            .elastic_bodies.empty();
    CHECK(written["model"]["accuracy"] == (by_estimates ? "auto" : "full"));
    // the mesh is chosen in jobs that are tests of their own
    written["model"]["accuracy"] = "reduced";
    written["model"].erase("tolerance");
    written["model"]["mesh"] = {6, 3};
    const Job job = parse_job(written);
    CHECK(job.notes.empty());
    Silent listener;
    const RunRecord record = run_any(job, {}, listener);
    CAPTURE(record.message);
    CHECK(record.status == "ok");
    const PathPoint& last = record.response.path.back();
    CHECK(last.parasitic_frequency);
    // no larger round stroke would do, but where the path ends otherwise
    const double allowed = *job.design.material.allowable_stress,
                 stress = largest_stress(record.response);
    CHECK(stress < 0.55 * allowed);
    CHECK(stress > 0.05 * allowed);
  }
}

TEST_CASE("every family has its numbers at their defaults, as they are read back", "[slow]") {
  for (const Family& family : families()) {
    CAPTURE(family.name);
    const Job job = parse_job(job_of(family.name, false));
    const ParameterValues usual = usual_values(family);
    for (const Parameter& p : family.parameters) {
      CAPTURE(p.name);
      CHECK(job.design.parameters.at(p.name) == Approx(usual.at(p.name)).epsilon(1e-9));
    }
    CHECK(job.design.choices == default_choices(family));
  }
}

TEST_CASE("every family's new optimisation begins within bounds, sound at all corners", "[slow]") {
  for (const Family& family : families()) {
    CAPTURE(family.name);
    const Job job = parse_job(job_of(family.name, true));
    REQUIRE(job.kind == JobKind::optimise);
    REQUIRE_FALSE(job.optimise->variables.empty());
    const Mechanism start = make_mechanism(job, job.design.parameters);
    for (const Variable& v : job.optimise->variables) {
      CAPTURE(v.parameter);
      const double value = job.design.parameters.at(v.parameter);
      CHECK(v.min < value);
      CHECK(v.max > value);
      for (const double end : {v.min, v.max}) {
        ParameterValues values = job.design.parameters;
        values[v.parameter] = end;
        CHECK_NOTHROW(make_mechanism(job, values));
      }
    }
    const bool alone = start.leaves.empty() && !start.bodies[start.end_effector].box;
    CHECK(job.optimise->constraints.size() >= (alone ? 1 : 2));  // stress and room
  }
}

TEST_CASE("a new optimisation improves on its start within stress and room") {
  json written = job_of("parallel_guide", true);
  written["model"] = {{"mesh", {6, 3}}};
  written["stroke"]["points"] = 2;
  written["optimise"]["starts"] = 1;
  Silent listener;
  const Job job = parse_job(written);
  json evaluated = written;
  evaluated.erase("optimise");
  evaluated["job"] = "evaluate";
  const RunRecord start = run_any(parse_job(evaluated), {}, listener);
  const RunRecord found = run_any(job, {}, listener);
  CAPTURE(found.message);
  REQUIRE(found.optimum);
  CHECK(found.status == "ok");
  CHECK(found.optimum->objective > 1.5 * *start.response.path.back().parasitic_frequency);
}

TEST_CASE("round numbers and readable ones") {
  CHECK(round_below(1) == 1);
  CHECK(round_below(9.99) == 5);
  CHECK(round_below(0.02) == Approx(0.02));
  CHECK(round_below(0.0199) == Approx(0.01));
  CHECK(readable(4e-4, "m") == "0.4 mm");
  CHECK(readable(2, "m") == "2 m");
  CHECK(readable(5e-6, "m") == "5 um");
  CHECK(readable(0.78539816339744831, "rad") == "45 deg");
  CHECK(readable(0.02, "kg") == "20 g");
  CHECK(readable(0, "kg") == 0.0);
  CHECK(readable(0.5, "1") == 0.5);
}

TEST_CASE("flexopt new prints a job or writes it, and replaces none unasked") {
  const test::Workplace folder;
  const test::Outcome printed = folder.run("new parallel_guide");
  CHECK(printed.code == 0);
  CHECK(json::parse(printed.out)["model"] == json{{"accuracy", "auto"}, {"tolerance", 0.003}});
  const test::Outcome written = folder.run("new parallel_guide --out guide.json");
  CHECK(written.code == 0);
  CHECK(written.out == "guide.json\n");
  CHECK(folder.content("guide.json") == printed.out);
  CHECK(folder.run("validate guide.json").code == 0);

  const test::Outcome again = folder.run("new cross_hinge --out guide.json");
  CHECK(again.code == 2);
  CHECK_THAT(again.err, Contains("guide.json") && Contains("--overwrite"));
  CHECK(folder.content("guide.json") == printed.out);
  CHECK(folder.run("new cross_hinge --optimise --out guide.json --overwrite").code == 0);
  CHECK(folder.json("guide.json")["job"] == "optimise");
  CHECK_THAT(folder.run("new hinge").err, Contains("cross_hinge"));
}

TEST_CASE("a new job of a design file names it from where the job stands") {
  const test::Workplace folder;
  fs::create_directories(folder / "designs");
  fs::create_directories(folder / "jobs");
  const test::Outcome design = folder.run("designs --export curved_leaf");
  folder.put("designs/mine.json", design.out);
  const test::Outcome written = folder.run("new designs/mine.json --out jobs/first.json");
  CAPTURE(written.err);
  CHECK(written.code == 0);
  const json job = folder.json("jobs/first.json");
  CHECK(job["design"]["file"] == "../designs/mine.json");
  CHECK(folder.run("validate jobs/first.json").code == 0);

  json bare = json::parse(design.out);
  bare["parameters"]["chord"].erase("default");
  folder.put("designs/mine.json", bare);
  const test::Outcome wrong = folder.run("new designs/mine.json");
  CHECK(wrong.code == 2);
  CHECK_THAT(wrong.err, Contains("chord"));
}
