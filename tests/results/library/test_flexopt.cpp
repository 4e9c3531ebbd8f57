// flexopt.hpp from outside: only the shared library is linked, and what it answers is compared with
// files of the program.
#include "results/library/flexopt.hpp"

#include <algorithm>
#include <atomic>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>

#include "support/temporary_folder.hpp"

using Catch::Contains;
using flexopt::test::content_of, flexopt::test::TemporaryFolder;
namespace fs = std::filesystem;

namespace {

const fs::path jobs = FLEXOPT_SOURCE_DIR "/designs/jobs";

/// A failure shall not print both.
bool same(const std::string& one, const std::string& other) { return one == other; }

const flexopt::Values numbers{{"length", "100 mm"},
                              {"width", 0.03},
                              {"thickness", "0.5 mm"},
                              {"spacing", "100 mm"},
                              {"material", "stavax"}};

const std::string keys = R"({
  "end_effector": {"mass": "1 kg", "inertia": ["9.08e-4 kg m^2", "8.33e-5 kg m^2", "8.42e-4 kg m^2"]},
  "stroke": {"from": 0, "to": "20 mm", "points": 3}, "frequencies": 3})";

flexopt::Job guide(const flexopt::Values& changed = {}) {
  return flexopt::Job::of_design(
      flexopt::Design::of_family("parallel_guide", numbers).with(changed), keys);
}

flexopt::Job hinge(const std::vector<std::string>& overrides = {}) {
  return flexopt::Job::of_file(jobs / "three_flexure_cross_hinge.json", overrides);
}

double last(const flexopt::Path& path, const std::string& quantity) {
  return path.values(quantity).back().value();
}

}  // namespace

TEST_CASE("the library tells its version and the formats that it knows") {
  CHECK(flexopt::version() == std::to_string(FLEXOPT_VERSION_MAJOR) + "." +
                                  std::to_string(FLEXOPT_VERSION_MINOR) + "." +
                                  std::to_string(FLEXOPT_VERSION_PATCH));
  CHECK_FALSE(flexopt::commit().empty());
  const auto job = [](int format) {
    return R"({"name": "a", "job": "evaluate", "design": {"family": "leaf_spring", "parameters":
      {"length": "100 mm", "width": "30 mm", "thickness": "0.5 mm"}, "material": "stavax"},
      "stroke": {"from": 0, "to": "1 mm", "points": 2}, "end_effector": {"mass": "1 kg",
      "inertia": ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]}, "flexopt": )" +
           std::to_string(format) + "}";
  };
  CHECK(flexopt::Job::of_json(job(flexopt::job_format())).kind() == "evaluate");
  CHECK_THROWS_AS(flexopt::Job::of_json(job(flexopt::job_format() + 1)), flexopt::JobError);
  CHECK_THAT(flexopt::evaluate(guide()).json(),
             Contains("\"format\": " + std::to_string(flexopt::result_format())));
}

TEST_CASE("a job of the library leaves the files of the program") {
  const TemporaryFolder folder;
  const auto file = jobs / "parallel_guide.json";
  const std::string command = "'" FLEXOPT_BINARY "' run --quiet --set '/expect=[]' '" +
                              file.string() + "' --out '" + (folder / "theirs").string() +
                              "' >/dev/null";
  REQUIRE(std::system(command.c_str()) == 0);
  flexopt::Options options;
  options.folder = folder / "ours";
  const flexopt::Evaluation result =
      flexopt::evaluate(flexopt::Job::of_file(file, {"/expect=[]"}), options);
  CHECK(result.usable());
  CHECK_THAT(result.message(), Contains("11 stroke points"));
  for (const char* name : {"result.json", "path.csv", "job.json", "report.html"})
    CHECK(same(content_of(folder / "ours" / name), content_of(folder / "theirs" / name)));
  CHECK(same(result.json(), content_of(folder / "ours/result.json")));
  CHECK(same(result.html(), content_of(folder / "ours/report.html")));
}

TEST_CASE("a design is of a family, of a file, or of JSON") {
  const flexopt::Design design = flexopt::Design::of_family("parallel_guide", numbers);
  const flexopt::Path path = flexopt::evaluate(guide()).path();
  CHECK(
      last(flexopt::evaluate(flexopt::Job::of_design(flexopt::Design::of_json(design.json()), keys))
               .path(),
           "drive_load") == last(path, "drive_load"));
  const TemporaryFolder folder;
  const auto file = (folder / "own.json").string();
  REQUIRE(std::system(
              ("'" FLEXOPT_BINARY "' designs --export parallel_guide >'" + file + "'").c_str()) ==
          0);
  const auto of_file = flexopt::Design::of_file(file, numbers);
  const auto of_content = flexopt::Design::of_json(content_of(file)).with(numbers);
  for (const flexopt::Design& other : {of_file, of_content})
    CHECK(last(flexopt::evaluate(flexopt::Job::of_design(other, keys)).path(), "drive_load") ==
          last(path, "drive_load"));
  CHECK_THROWS_AS(flexopt::Design::of_family("no_such_family"), flexopt::JobError);
  CHECK_THROWS_AS(flexopt::Design::of_file(folder / "none.json"), flexopt::JobError);
  CHECK_THROWS_AS(flexopt::Design::of_json("[1]"), flexopt::JobError);
}

TEST_CASE("values that JSON does not have are wrong input") {
  const auto design = [](const char* name, const flexopt::Value& value) {
    return flexopt::Design::of_family("leaf_spring", {{name, value}});
  };
  for (const double value : {std::nan(""), HUGE_VAL})
    CHECK_THROWS_WITH(design("length", value),
                      Contains("/design/parameters/length") && Contains("a finite number"));
  CHECK_THROWS_AS(design("length", "\xff"), flexopt::JobError);
  CHECK_THROWS_AS(design("l\xc3", 0.1), flexopt::JobError);
  CHECK_NOTHROW(design("length", "100\u00a0mm"));
}

TEST_CASE("wrong input tells every fault and where it stands") {
  const std::string text = "{\n\"flexopt\": 1,\n\"stroke\": {\"from\": 0, \"to\": \"2 N\"}}";
  try {
    flexopt::Job::of_json(text);
    FAIL("was taken");
  } catch (const flexopt::JobError& error) {
    REQUIRE_FALSE(error.faults().empty());
    for (const flexopt::Fault& fault : error.faults()) CHECK_FALSE(fault.rule.empty());
    CHECK_THAT(error.what(), Contains("/design"));
  }
  try {
    guide({{"thickness", "5 N"}, {"length", "2 deg"}});
    FAIL("was taken");
  } catch (const flexopt::JobError& error) {
    REQUIRE(error.faults().size() == 2);
    CHECK(error.faults()[0].pointer == "/design/parameters/length");
    CHECK(error.faults()[1].value == "\"5 N\"");
  }
  CHECK_THROWS_AS(flexopt::optimise(guide()), flexopt::JobError);
}

TEST_CASE("numbers of a path have the shapes that the header says") {
  const flexopt::Job job = guide();
  CHECK(job.parameters().at("length") == 0.1);
  const flexopt::Evaluation result = flexopt::evaluate(job);
  REQUIRE(result.paths().size() == 1);
  const flexopt::Path path = result.path();
  REQUIRE(path.size() == 3);
  CHECK(path.name().empty());
  CHECK(path.status() == "ok");
  CHECK(path.stroke() == std::vector<double>{0, 0.01, 0.02});
  CHECK(path.displacement().rows == 3);
  CHECK(path.displacement()(2, 1) == Approx(0.02).epsilon(1e-12));
  CHECK(path.rotation().numbers.size() == 9);
  const auto compliance = path.compliance(2, flexopt::Drive::held);
  CHECK(1 / compliance[0] == Approx(last(path, "support_stiffness.ux")).epsilon(1e-12));
  for (std::size_t i = 0; i < 6; ++i)
    for (std::size_t j = 0; j < i; ++j) {
      const double size = std::sqrt(compliance[7 * i] * compliance[7 * j]);
      CHECK(std::abs(compliance[6 * i + j] - compliance[6 * j + i]) <= 1e-9 * size);
    }
  CHECK(path.compliance(2, flexopt::Drive::free)[7] ==
        Approx(1 / last(path, "drive_stiffness")).epsilon(1e-9));
  const auto held = path.frequencies(2, flexopt::Drive::held);
  REQUIRE(held.size() == 3);
  CHECK(held[0] < held[1]);
  CHECK(path.unit("drive_load") == "N");
  CHECK_THROWS_AS(path.values("no_such_number"), std::out_of_range);
  CHECK_THROWS_AS(path.compliance(3, flexopt::Drive::free), std::out_of_range);
  const auto names = path.names();
  CHECK(std::find(names.begin(), names.end(), "parasitic_frequency") != names.end());
}

TEST_CASE("gradients of a path are its differences") {
  flexopt::Options options;
  options.gradients = {"thickness", "material.youngs_modulus"};
  const auto result = flexopt::evaluate(guide(), options);
  REQUIRE(result.gradients_by() == options.gradients);
  const flexopt::Table exact = result.path().gradient("drive_load");
  REQUIRE(exact.rows == 3);
  REQUIRE(exact.columns == 2);
  const double thickness = 0.5e-3, step = 1e-3 * thickness;
  const auto load = [&](double of) {
    return last(flexopt::evaluate(guide({{"thickness", of}})).path(), "drive_load");
  };
  const double difference = (8 * (load(thickness + step) - load(thickness - step)) -
                             (load(thickness + 2 * step) - load(thickness - 2 * step))) /
                            (12 * step);
  // the derivative of a path is that of full leaves, the loads are those of looked-up ones
  CHECK(exact(2, 0) == Approx(difference).epsilon(2e-5));
  // The load is proportional to Young's modulus, which is that of a steel.
  const double modulus = last(result.path(), "drive_load") / exact(2, 1);
  CHECK(modulus > 1.9e11);
  CHECK(modulus < 2.3e11);
  CHECK_THROWS_AS(flexopt::evaluate(guide()).path().gradient("drive_load"), flexopt::NoGradient);
  options.gradients = {"no_such_parameter"};
  CHECK_THROWS_AS(flexopt::evaluate(guide(), options), flexopt::JobError);
}

TEST_CASE("a design without equilibrium is a status, with what was reached") {
  const auto job = flexopt::Job::of_design(flexopt::Design::of_family("parallel_guide", numbers),
                                           R"({"stroke": {"from": 0, "to": "400 mm", "points": 3},
       "end_effector": {"mass": "1 kg", "inertia": ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]}})");
  const auto result = flexopt::evaluate(job);
  CHECK(result.status() == "no_equilibrium");
  CHECK_FALSE(result.usable());
  CHECK_FALSE(result.message().empty());
  CHECK(result.path().converged(0));
  CHECK_FALSE(result.path().converged(2));
  CHECK_FALSE(result.path().values("drive_load")[2].has_value());
}

TEST_CASE("an optimisation finds the README's hinge, tells how far it is, can be stopped",
          "[slow]") {
  std::atomic<int> told = 0;
  flexopt::Options options;
  options.progress = [&](const flexopt::Progress& progress) {
    told += progress.total > 0;
    return true;
  };
  const flexopt::Job job = hinge({"/optimise/starts=1"});
  const flexopt::Optimum found = flexopt::optimise(job, options);
  CHECK(found.usable());
  CHECK(found.objective().value() == Approx(256.42).margin(0.03));
  CHECK(found.parameters().at("thickness") == Approx(0.0004).margin(5e-5));
  CHECK(found.evaluations() > 5);
  CHECK(told > 5);
  REQUIRE_FALSE(found.constraints().empty());
  CHECK_THAT(found.constraints()[0].label, Contains("max_stress"));
  CHECK(found.constraints()[0].active);
  CHECK(found.path().size() == 5);
  options.progress = [](const flexopt::Progress& progress) { return progress.done < 2; };
  CHECK_THROWS_AS(flexopt::optimise(job, options), flexopt::Stopped);
}

TEST_CASE("the goals of a job are functions with exact derivatives") {
  const flexopt::Problem problem(hinge());
  const auto x = problem.start();
  REQUIRE(problem.names().size() == x.size());
  const flexopt::Goals at = problem.at(x, true);
  REQUIRE(at.ok);
  REQUIRE(at.g.size() == problem.constraint_names().size());
  REQUIRE(at.dg.rows == at.g.size());
  REQUIRE(at.dg.columns == x.size());
  const double step = 1e-4;
  auto above = x, below = x;
  above[1] += step;
  below[1] -= step;
  const flexopt::Goals up = problem.at(above), down = problem.at(below);
  CHECK(up.df.empty());
  CHECK(at.df[1] == Approx((up.f - down.f) / (2 * step)).epsilon(1e-4));
  for (std::size_t i = 0; i < at.g.size(); ++i)
    CHECK(at.dg(i, 1) == Approx((up.g[i] - down.g[i]) / (2 * step)).epsilon(1e-4).margin(1e-6));
  CHECK(problem.lower() == std::vector<double>(x.size(), 0));
  CHECK(problem.parameters(x).count("thickness") == 1);
  CHECK_THROWS_AS(problem.at({1, 2}), flexopt::JobError);
  CHECK_THROWS_AS(flexopt::Problem(guide()), flexopt::JobError);
  const flexopt::Problem pointwise(hinge(), {false, true});
  CHECK(pointwise.names().back() == "t");
  CHECK(pointwise.constraint_names().size() > problem.constraint_names().size());
}

TEST_CASE("a design without values tells an optimiser to step back") {
  const flexopt::Job job = flexopt::Job::of_json(R"({"flexopt": 1, "name": "far", "job": "optimise",
    "design": {"family": "parallel_guide", "material": "stavax", "parameters": {"length": "250 mm",
      "width": "30 mm", "thickness": "0.5 mm", "spacing": "100 mm"}},
    "end_effector": {"mass": "1 kg", "inertia": ["1e-3 kg m^2", "1e-3 kg m^2", "1e-3 kg m^2"]},
    "stroke": {"from": 0, "to": "160 mm", "points": 4},
    "optimise": {"variables": [{"parameter": "length", "min": "100 mm", "max": "300 mm"}],
      "objective": {"minimise": "drive_load", "over_stroke": "max_abs"}}})");
  const flexopt::Problem problem(job);
  CHECK(problem.at(problem.start()).ok);
  const flexopt::Goals short_leaves = problem.at({0});
  CHECK_FALSE(short_leaves.ok);
  CHECK_FALSE(short_leaves.message.empty());
  CHECK(short_leaves.g.empty());
  REQUIRE(short_leaves.reached.has_value());
  CHECK(*short_leaves.reached < 0.16);
}
