// Errors against full accuracy by their definition, and batches that are killed and go on.
#include "optim/studies/compare.hpp"

#include <fstream>

#include "support/guide.hpp"
#include "tests/optim/optim_tests.hpp"

namespace {

json job_document(int count = 6) {
  json job = guide::stiff_guide();
  job["job"] = "compare";
  job.erase("optimise");
  job["frequencies"] = 3;
  job["samples"] = {{"count", count},
                    {"vary", {{{"parameter", "length"}, {"min", 0.05}, {"max", 0.15}}}}};
  job["models"] = json::parse(R"([{"name": "one"}, {"name": "two", "degree": 7}])");
  return job;
}

CompareRun run(const json& document, const fs::path& log = {}, int threads = 1,
               double breaks_at = 1e99, guide::Calls* calls = nullptr) {
  guide::Calls own;
  CompareOptions options;
  options.log = log;
  options.threads = threads;
  options.evaluator = guide::evaluator(calls ? *calls : own, breaks_at);
  return compare(parse_job(document), options);
}

/// Of the guide's job, in the order of the contract.
enum Place { drive_load, support_stiffness, displacement, frequencies, parasitic, max_stress };

const std::vector<ComparedQuantity>& compared() {
  static const std::vector<ComparedQuantity> list = compared_quantities(parse_job(job_document()));
  return list;
}

/// A point with room for these numbers, none of which it has.
ComparedPoint point_of(const std::vector<ComparedQuantity>& list) {
  ComparedPoint p;
  p.converged = true;
  for (const ComparedQuantity& quantity : list) {
    p.numbers.emplace_back(quantity.numbers.size());
    p.reasons.emplace_back(quantity.numbers.size());
  }
  return p;
}

ComparedPath path_of(std::initializer_list<double> loads) {
  ComparedPath path;
  for (const double load : loads) {
    ComparedPoint p = point_of(compared());
    p.numbers[drive_load] = {load};
    p.numbers[displacement] = {load, 0, 0};
    p.numbers[support_stiffness][0] = 1000 + load;
    p.numbers[frequencies][3] = 10;  // the drive locked
    p.numbers[frequencies][4] = 20 + load;
    path.points.push_back(p);
  }
  return path;
}

std::vector<PointError> errors_between(const ComparedPath& model, const ComparedPath& full) {
  return errors_of(compared(), model, full).errors;
}

}  // namespace

TEST_CASE("errors are relative to full accuracy, with a floor where it vanishes") {
  const ComparedPath full = path_of({0, 1, 2});
  CHECK(errors_between(full, full).size() == 2 + 3 + 2 + 6);  // loads and motion not at rest
  for (const PointError& e : errors_between(full, full)) CHECK(e.value == 0);

  ComparedPath model = path_of({0, 1.01, 2});
  const std::vector<PointError> errors = errors_between(model, full);
  const auto worst = [&](Place quantity) { return error_figures(errors, quantity)->worst; };
  CHECK(worst(drive_load) == Approx(0.01));
  CHECK(worst(displacement) == Approx(0.01 / 2));  // of the largest of the path
  CHECK(worst(support_stiffness) == Approx(0.01 / 1001));
  CHECK(worst(frequencies) == Approx(0.01 / 21));
  CHECK_FALSE(error_figures(errors, max_stress));
  CHECK(error_figures(errors, drive_load)->worst_point == 1);
  CHECK(error_figures(errors, support_stiffness, 0)->count == 3);
  CHECK_FALSE(error_figures(errors, support_stiffness, 1));

  model = path_of({0.5, 1, 2});  // where full accuracy vanishes and the model does not
  CHECK(error_figures(errors_between(model, full), drive_load)->worst == Approx(0.5 / (1e-6 * 2)));
  model.points[2].converged = false;  // only points that both reach
  CHECK(error_figures(errors_between(model, full), frequencies)->count == 4);
}

TEST_CASE("what is rounding at rest has no error") {
  const auto errors = errors_between(path_of({-3e-16}), path_of({1e-16}));
  CHECK_FALSE(error_figures(errors, drive_load));
  CHECK_FALSE(error_figures(errors, displacement));
  CHECK(error_figures(errors, support_stiffness));
}

TEST_CASE("of several drives the load of each has its own floor") {
  json document = job_document();
  document["design"] = json::parse(R"({"family": "tip_tilt_stage", "material": "stavax"})");
  document["stroke"] =
      json::parse(R"({"at": [{"tip": 0, "tilt": 0}, {"tip": 0.01, "tilt": 0.01}]})");
  document["samples"]["vary"][0] = {{"parameter", "thickness"}, {"min", 2e-4}, {"max", 3e-4}};
  const auto list = compared_quantities(parse_job(document));
  REQUIRE(list[drive_load].parts.size() == 2);
  CHECK(list[drive_load].part_key == "by_component");
  ComparedPath full;
  for (int i = 0; i < 3; ++i) {
    full.points.push_back(point_of(list));
    full.points.back().numbers[drive_load] = {i, 100};
  }
  ComparedPath model = full;
  model.points[2].numbers[drive_load][1] = 103;
  const std::vector<PointError> errors = errors_of(list, model, full).errors;
  CHECK(error_figures(errors, drive_load)->worst == Approx(0.03));
  CHECK(error_figures(errors, drive_load)->worst_point == 2);
  CHECK(error_figures(errors, drive_load)->count == 2 + 3);
  CHECK(error_figures(errors, drive_load, 0)->worst == 0);
  CHECK(error_figures(errors, drive_load, 1)->worst == Approx(0.03));
}

TEST_CASE("a number that only one of both has is missing, with its reason") {
  const ComparedPath full = path_of({0, 1, 2});
  ComparedPath model = full;
  model.points[1].numbers[support_stiffness][0].reset();
  model.points[1].reasons[support_stiffness][0] = "it fell off";
  model.points[2].numbers[max_stress] = {5};
  const PathErrors found = errors_of(compared(), model, full);
  REQUIRE(found.missing.size() == 2);
  CHECK(found.missing[0].quantity == support_stiffness);
  CHECK(found.missing[0].part == 0);
  CHECK(found.missing[0].point == 1);
  CHECK(found.missing[0].in_model);
  CHECK(found.missing[0].reason == "it fell off");
  CHECK(found.missing[1].quantity == max_stress);
  CHECK_FALSE(found.missing[1].in_model);
  CHECK(error_figures(found.errors, support_stiffness)->count == 2);
}

TEST_CASE("what is compared is what the job asks for") {
  const auto names = [](const json& document) {
    std::vector<std::string> list;
    for (const ComparedQuantity& q : compared_quantities(parse_job(document)))
      list.push_back(q.name);
    return list;
  };
  const std::vector<std::string> plain{
      "drive_load",          "support_stiffness", "displacement",    "frequencies",
      "parasitic_frequency", "max_stress",        "drive_stiffness", "rotation",
      "principal_stiffness"};
  CHECK(names(job_document()) == plain);
  json more = job_document();
  more["loads"] = json::parse(R"([{"name": "payload", "force": [-1, 0, 0]}])");
  more["buckling"] = {{"load", "payload"}};
  more["load_capacity"] = {{"directions", {"uz"}}};
  more["stroke_capacity"] = {{"up_to", 0.01}};
  more["dynamics"] = json::object();
  std::vector<std::string> all = plain;
  all.insert(all.end(),
             {"buckling_load_factor", "buckling", "bandwidth", "load_capacity", "stroke_capacity"});
  CHECK(names(more) == all);
  const auto outputs = [](const json& document) {
    return needs_of(compared_quantities(parse_job(document)));
  };
  for (const Output output :
       {Output::buckling, Output::load_capacity, Output::stroke_capacity, Output::dynamics}) {
    CHECK(outputs(more).has(output));
    CHECK_FALSE(outputs(job_document()).has(output));
  }
  // a list stands instead: nothing else is evaluated
  more["quantities"] = {"clearance", "drive_load"};
  CHECK(names(more) == std::vector<std::string>{"drive_load", "clearance"});
  CHECK(outputs(more) == Outputs{Output::equilibrium, Output::clearance});
}

TEST_CASE("percentiles are linear between the sorted errors") {
  std::vector<PointError> errors;
  for (int i = 100; i >= 0; --i) errors.push_back({drive_load, -1, i, 0, i * 1e-3});
  const auto figures = error_figures(errors, drive_load);
  REQUIRE(figures);
  CHECK(figures->count == 101);
  CHECK(figures->worst == Approx(0.1));
  CHECK(figures->worst_design == 100);
  CHECK(figures->p99 == Approx(0.099));
  CHECK(figures->median == Approx(0.05));
  errors.resize(2);  // 0.1, 0.099
  CHECK(error_figures(errors, drive_load)->p99 == Approx(0.09999));
}

TEST_CASE("a model 1 % below full accuracy has that error everywhere") {
  const CompareRun r = run(job_document());
  const Comparison& c = r.comparison;
  CHECK(c.designs.size() == 6);
  CHECK(c.failed_designs == 0);
  CHECK(c.evaluated == 18);
  REQUIRE(c.models.size() == 2);
  for (const ModelComparison& model : c.models) {
    CHECK(model.failures == 0);
    for (const Place quantity :
         {drive_load, support_stiffness, frequencies, parasitic, max_stress}) {
      const auto figures = error_figures(model.errors, quantity);
      REQUIRE(figures);
      CHECK(figures->worst == Approx(0.01 / 1.01));
      CHECK(figures->median == Approx(0.01 / 1.01));
    }
    CHECK_FALSE(error_figures(model.errors, displacement));  // the guide has none
  }
  const LeafSpring leaf =
      make_mechanism(parse_job(job_document()), c.designs[0].sample.parameters).leaves[0];
  CHECK(c.designs[0].length_over_width == Approx(leaf.length / leaf.width));
  CHECK(c.designs[0].width2_over_length_thickness ==
        Approx(leaf.width * leaf.width / (leaf.length * leaf.thickness)));
}

TEST_CASE("failures are accounted for one by one and spoil no figure") {
  // 3 E t x / L² at 5 mm beyond 100 MPa: the short guides do not reach the end
  const double limit = 100e6, short_below = std::sqrt(3 * 200e9 * 0.25e-3 * 5e-3 / limit);
  const CompareRun r = run(job_document(16), {}, 1, limit);
  int expected = 0;
  for (const ComparedDesign& d : r.comparison.designs) {
    const bool is_short = d.sample.parameters.at("length") < short_below;
    CHECK(d.failed == is_short);
    CHECK(d.message.empty() != is_short);
    if (is_short) ++expected;
  }
  CHECK(expected > 2);
  CHECK(expected < 16);
  CHECK(r.comparison.failed_designs == expected);
  const ModelComparison& model = r.comparison.models[0];
  CHECK(model.failures == 0);  // it goes as far as full accuracy does
  CHECK(error_figures(model.errors, drive_load)->worst == Approx(0.01 / 1.01));

  json refused = job_document();
  refused["samples"]["vary"].push_back(
      {{"parameter", "width"}, {"expression", "sqrt(length - 0.1)"}});
  const CompareRun half = run(refused);
  CHECK(half.comparison.failed_designs == 3);
  for (const ComparedDesign& d : half.comparison.designs)
    if (d.failed) CHECK_THAT(d.message, Contains("no finite value"));
}

TEST_CASE("a batch cut off anywhere goes on to the same bytes") {
  const test::TemporaryFolder folder;
  const fs::path log = folder / "evaluations.jsonl";
  const CompareRun whole = run(job_document(), log);
  const std::string bytes = test::content_of(log);
  const std::vector<std::size_t> line_ends = test::line_begins(bytes);
  REQUIRE(line_ends.size() == 18 + 2);
  for (std::size_t i = 0; i + 1 < line_ends.size(); ++i)
    for (const std::size_t cut : {line_ends[i], (line_ends[i] + line_ends[i + 1]) / 2}) {
      CAPTURE(i, cut);
      test::put(log, bytes.substr(0, cut));
      guide::Calls calls;
      const CompareRun resumed = run(job_document(), log, 1, 1e99, &calls);
      CHECK(calls.full + calls.reduced == 18 - std::max(0, static_cast<int>(i) - 1));
      CHECK(test::content_of(log) == bytes);
      CHECK(resumed.comparison.models[1].errors.size() == whole.comparison.models[1].errors.size());
    }
  const Comparison logged = compare_logged(parse_job(job_document()), log);
  CHECK(logged.evaluated == 18);
  test::put(log, bytes.substr(0, line_ends[9] + 5));
  CHECK(compare_logged(parse_job(job_document()), log).evaluated == 8);
  CHECK(test::content_of(log) == bytes.substr(0, line_ends[9] + 5));  // a reader leaves it alone
}

TEST_CASE("the threads change no byte of a batch") {
  const test::TemporaryFolder folder;
  run(job_document(), folder / "1.jsonl", 1);
  const std::string bytes = test::content_of(folder / "1.jsonl");
  for (const int threads : {2, 5}) {
    const fs::path log = folder / (std::to_string(threads) + ".jsonl");
    run(job_document(), log, threads);
    CHECK(test::content_of(log) == bytes);
  }
}

TEST_CASE("the log of another batch is refused") {
  const test::TemporaryFolder folder;
  const fs::path log = folder / "evaluations.jsonl";
  run(job_document(), log);
  json other = job_document();
  other["models"][1]["degree"] = 5;
  CHECK_THROWS_WITH(run(other, log), Contains("another job") && Contains("/job/models/1/degree"));
  const std::string bytes = test::content_of(log);
  std::ofstream(log, std::ios::app) << R"({"design": 6, "model": 0})"
                                    << "\n";
  CHECK_THROWS_WITH(run(job_document(), log), Contains("line 20: {") && Contains("checksum"));
  CHECK(test::content_of(log).starts_with(bytes));
}

TEST_CASE("a digit of a comparison's logs that was changed is refused") {
  const test::TemporaryFolder folder;
  const fs::path log = folder / "evaluations.jsonl";
  run(job_document(), log);
  for (const fs::path& file : {log, folder / "evaluations.seconds.jsonl"}) {
    const std::string bytes = test::content_of(file);
    std::string changed = bytes;
    const std::size_t third = changed.find('\n', changed.find('\n') + 1) + 1;
    ++changed[changed.find_first_of("1234567", third + 12)];
    test::put(file, changed);
    CHECK_THROWS_WITH(run(job_document(), log),
                      Contains(file.filename().string()) && Contains("line 3: {"));
    CHECK_THROWS_WITH(compare_logged(parse_job(job_document()), log), Contains("line 3: {"));
    test::put(file, bytes);
  }
  CHECK_NOTHROW(run(job_document(), log));
}
