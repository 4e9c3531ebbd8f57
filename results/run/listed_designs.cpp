#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <utility>

#include "core/spec/spec_error.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/files/scene.hpp"
#include "results/report/report.hpp"
#include "results/run/run.hpp"

namespace flexopt {

namespace fs = std::filesystem;

OrderedJson run_listed_designs(const Job& job, const fs::path& folder, int threads,
                               RunListener& listener, std::map<std::string, double>& timings,
                               Sharing* sharing) {
  const bool keeps = !sharing || !sharing->follows();
  if (keeps && fs::exists(folder / "evaluations.jsonl") && !holds_finished_run(folder))
    throw SpecError("--out", folder.string(),
                    "an interrupted run of one design is in this folder: expected another folder, "
                    "or remove its evaluations.jsonl");
  if (keeps) write_job(folder, job);
  std::vector<OrderedJson> results;
  for (std::size_t k = 0; k < job.designs.size(); ++k) {
    const ListedDesign& design = job.designs[k];
    listener.say(fmt::format("design {} of {}: {}", k + 1, job.designs.size(), design.label));
    const auto begin = std::chrono::steady_clock::now();
    const fs::path own = keeps ? folder / design.folder : fs::path();
    if (keeps) fs::create_directories(own);
    std::optional<RunRecord> found;
    try {
      found = run_any(*design.job, own, threads, listener, {}, sharing);
    } catch (const ShardEnds&) {
    }
    if (!found || (sharing && !sharing->complete())) continue;
    RunRecord& record = *found;
    record.timings["total"] = timings[design.label] = seconds_since(begin);
    results.push_back(*write_run(own, record).result);
  }
  return results.empty() ? OrderedJson() : make_listed_result(job, results);
}

namespace {

/// Scene of the designs in the order of the result: ranked, or as they are listed.
OrderedJson scene_of(const fs::path& folder, const Job& job, const OrderedJson& result) {
  std::vector<OrderedJson> scenes;
  std::vector<std::string> labels;
  for (const ListedDesign& design : job.designs) {
    scenes.push_back(read_scene(folder / design.folder));
    labels.push_back(design.label);
  }
  std::vector<std::size_t> order;
  const char* list = result.contains("ranking") ? "ranking" : "designs";
  for (const OrderedJson& entry : result.value(list, OrderedJson::array()))
    order.push_back(entry.at("design").get<std::size_t>());
  return merged_scene(scenes, labels, order);
}

}  // namespace

WrittenRun write_listed_designs(const fs::path& folder, const Job& job, OrderedJson result,
                                const std::map<std::string, double>& timings) {
  WrittenRun written;
  written.failed_expectations = check_expectations(job.expect, result);
  write_or_remove(folder / "ranking.csv", result.contains("ranking") ? ranking_csv(result) : "");
  write_timings(folder, timings);
  const OrderedJson scene = scene_of(folder, job, result);
  write_shown(folder, result, scene);
  written.result = std::make_shared<const OrderedJson>(std::move(result));
  return written;
}

OrderedJson interrupted_designs(const Job& job, const fs::path& folder) {
  std::vector<OrderedJson> results;
  for (const ListedDesign& design : job.designs) {
    const fs::path own = folder / design.folder;
    const bool begun = fs::exists(own / "result.json") || fs::exists(own / "evaluations.jsonl");
    results.push_back(begun ? read_result(own) : OrderedJson());
  }
  return make_listed_result(job, results);
}

}  // namespace flexopt
