// Which design is best: the order, and what the whole result takes from it.
#include "tests/results/results_tests.hpp"

namespace {

Job job_of(const std::vector<std::string>& names, bool maximise) {
  Job job;
  job.name = "which";
  job.kind = JobKind::optimise;
  job.optimise.emplace().objective.maximise = maximise;
  for (const std::string& name : names)
    job.designs.push_back({name, "designs/" + name, std::make_shared<const Job>()});
  return job;
}

OrderedJson result_of(const std::string& status, const OrderedJson& objective, double margin) {
  OrderedJson result = OrderedJson::parse(R"({"message": "m", "optimum": {"evaluations": 7,
    "goal": {"quantity": "parasitic_frequency", "over_stroke": "min", "unit": "Hz"},
    "constraints": [
      {"label": "max_stress max over stroke", "bound": 500e6, "unit": "Pa"},
      {"label": "loose", "value": 1, "bound": 10, "unit": "m", "margin": 9}]}})");
  result["status"] = status == "optimal" ? "ok" : status;
  result["verdict"] = {{"tone", "good"}, {"word", status}, {"text", "of this design"}};
  result["optimum"].update({{"status", status}, {"objective", objective}});
  result["optimum"]["constraints"][0].update({{"value", 500e6 - margin}, {"margin", margin}});
  return result;
}

std::vector<std::string> names_in_order(const OrderedJson& result) {
  std::vector<std::string> names;
  for (const OrderedJson& entry : result["ranking"]) names.push_back(entry["name"]);
  return names;
}

}  // namespace

TEST_CASE("feasible designs by objective, then by least violation, then what failed") {
  const std::vector<std::string> names{"worse", "far off", "failed", "best", "near", "unfinished"};
  const std::vector<OrderedJson> results{
      result_of("optimal", 80, 5e6),      result_of("infeasible", 900, -250e6),
      result_of("failed", nullptr, 0),    result_of("optimal", 120, 0),
      result_of("infeasible", 300, -5e6), result_of("feasible", 100, 1e6)};
  const OrderedJson most = make_listed_result(job_of(names, true), results);
  CHECK(names_in_order(most) ==
        std::vector<std::string>{"best", "unfinished", "worse", "near", "far off", "failed"});
  CHECK(names_in_order(make_listed_result(job_of(names, false), results)) ==
        std::vector<std::string>{"worse", "unfinished", "best", "near", "far off", "failed"});
  CHECK(most["status"] == "ok");
  CHECK(most["optimum"] == results[3]["optimum"]);
  const OrderedJson& far = most["ranking"][4];
  CHECK(unlike_text(far, R"({"rank": 5, "design": 1, "feasible": false,
      "worst_constraint": {"label": "max_stress max over stroke"}})") == "");
  CHECK(far["worst_constraint"]["violation"] == Approx(0.5));
  CHECK(far["result"] == results[1]);
  CHECK(most["message"].get<std::string>().find("3 of 6 designs meet every constraint; best is "
                                                "\"best\" with parasitic_frequency min 120 Hz") !=
        std::string::npos);
}

TEST_CASE("without a feasible design the least violated one leads and the status says so") {
  const OrderedJson result =
      make_listed_result(job_of({"a", "b"}, true),
                         {result_of("infeasible", 1, -9e6), result_of("infeasible", 2, -5e6)});
  CHECK(result["status"] == "infeasible");
  CHECK(names_in_order(result) == std::vector<std::string>{"b", "a"});
  CHECK(result["message"].get<std::string>().find("0.01 of its bound") != std::string::npos);
}

TEST_CASE("designs that an interrupted run has not come to stand last") {
  const OrderedJson result =
      make_listed_result(job_of({"a", "b"}, true), {OrderedJson(), result_of("optimal", 2, 1e6)});
  CHECK(result["status"] == "interrupted");
  CHECK(names_in_order(result) == std::vector<std::string>{"b", "a"});
  CHECK(result["ranking"][1]["status"] == "not_begun");
}

TEST_CASE("the ranking as a table has a row a design") {
  const OrderedJson result =
      make_listed_result(job_of({"a, with comma", "b"}, true),
                         {result_of("optimal", 1, 5e6), result_of("failed", nullptr, 0)});
  std::istringstream lines(ranking_csv(result));
  std::string head, first, second, none;
  std::getline(lines, head);
  std::getline(lines, first);
  std::getline(lines, second);
  CHECK_FALSE(std::getline(lines, none));
  CHECK(head.starts_with("rank,design,family,status,feasible,"));
  CHECK(head.find("objective: parasitic_frequency min [Hz]") != std::string::npos);
  CHECK(first.starts_with("1,\"a, with comma\",,ok,true,1,max_stress max over stroke,"));
  CHECK(second.starts_with("2,b,,failed,false,,"));
}

TEST_CASE("the verdict on a list is that of the best design, or says what the whole did not find") {
  const auto verdict_in = [](OrderedJson result) {  // the summary says the same
    result["job"] = {{"name", "which"}};
    const std::string word = result["verdict"]["word"];
    CHECK(result["verdict"]["text"] == result["message"]);
    CHECK_THAT(listed_summary(result),
               Catch::Matchers::StartsWith("which: " + word + ". " +
                                           result["message"].get<std::string>() + "\n"));
    return word;
  };
  const OrderedJson good = result_of("optimal", 2, 1e6), missed = result_of("infeasible", 1, -9e6);
  CHECK(verdict_in(make_listed_result(job_of({"a", "b"}, true), {missed, good})) == "optimal");
  CHECK(verdict_in(make_listed_result(job_of({"a", "b"}, true), {missed, missed})) == "infeasible");
  CHECK(verdict_in(make_listed_result(job_of({"a", "b"}, true), {OrderedJson(), good})) ==
        "interrupted");
  Job evaluated = job_of({"a", "b"}, true);
  evaluated.optimise.reset();
  CHECK(verdict_in(make_listed_result(evaluated, {good, good})) == "done");
  const OrderedJson fell = make_listed_result(evaluated, {good, missed});
  CHECK(verdict_in(fell) == "no equilibrium");
  CHECK(fell["verdict"]["tone"] == "bad");
}
