#include "results/run/shard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "core/spec/spec_error.hpp"
#include "optim/job/job_sections.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "results/files/folder.hpp"
#include "results/files/program_part.hpp"
#include "results/files/version.hpp"
#include "results/run/run.hpp"

namespace flexopt {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* logs[] = {"evaluations.jsonl", "evaluations.seconds.jsonl",
                                "evaluations.screening.jsonl", "units.jsonl"};
constexpr int most_shards = 100000;

/// Content of shard.json; null where there is none.
json shard_json(const fs::path& folder) {
  const fs::path file = folder / "shard.json";
  if (!fs::exists(file)) return {};
  json said = json::parse(read_file(file), nullptr, false);
  if (!said.is_object() || !said.contains("shard") || !said.contains("of"))
    throw SpecError("", file.string(), "expected the shard.json of a run with --shard");
  return said;
}

/// What a line is about, and its result; nothing of its times.
std::pair<std::string, json> about(const std::string& line) {
  const json j = json::parse(line);
  if (j.is_array() && j.at(0).is_number()) return {j.at(0).dump(), j};  // a screened design
  if (j.is_array()) return {j.at(0).dump() + j.at(1).dump(), j.at(2)};
  if (j.contains("variables"))
    return {json{j.at("variables"), j.at("full"), j.at("gradient").is_null()}.dump(),
            {j.at("ok"), j.at("values"), j.at("gradient")}};
  const std::string pair = j.at("design").dump() + " " + j.at("model").dump();
  return {pair, j.contains("points") ? j : json()};
}

/// The lines of one log of all folders, each evaluation once.
class Union {
 public:
  void add(const fs::path& file) {
    const json theirs = log_identity_of(file);
    if (theirs.is_null()) throw SpecError("", file.string(), "expected a log of evaluations");
    if (identity_.is_null()) identity_ = theirs, first_ = file;
    if (theirs != identity_)
      throw SpecError("", file.string(),
                      fmt::format("expected the log of the same job and build as {}: {}",
                                  first_.string(), first_difference(identity_, theirs)));
    int number = 1;
    for (const std::string& line : read_log_lines(file)) {
      ++number;
      try {
        add(about(line), line, file);
      } catch (const json::exception& error) {
        throw SpecError("", fmt::format("{}, line {}", file.string(), number),
                        std::string("expected an evaluation: ") + error.what());
      }
    }
  }
  bool empty() const { return identity_.is_null(); }
  std::string text() const { return log_text(identity_, lines_); }

 private:
  void add(std::pair<std::string, json> said, const std::string& line, const fs::path& file) {
    const auto [known, fresh] = known_.try_emplace(said.first, std::move(said.second), file);
    if (fresh) {
      lines_.push_back(line);
    } else if (known->second.first != said.second) {
      throw SpecError(
          "", file.string(),
          fmt::format("expected the same values as in {}, of {}: shards of one run must "
                      "come from processors of one kind",
                      known->second.second.string(), said.first));
    }
  }

  json identity_;
  fs::path first_;
  std::map<std::string, std::pair<json, fs::path>> known_;
  std::vector<std::string> lines_;
};

/// Folders below a run's own that have logs.
std::vector<fs::path> folders_of(const Job& job) {
  std::vector<fs::path> folders;
  for (const ListedDesign& design : job.designs) folders.emplace_back(design.folder);
  if (folders.empty()) folders.emplace_back();
  return folders;
}

}  // namespace

Shard read_shard(const std::string& text) {
  Shard shard;
  char slash = 0;
  std::istringstream stream(text);
  const bool numbers = stream >> shard.number >> slash >> shard.of && slash == '/' && stream.eof();
  if (!numbers || shard.of < 1 || shard.of > most_shards || shard.number < 1 ||
      shard.number > shard.of)
    throw SpecError("--shard", text,
                    fmt::format("expected NUMBER/OF, 1/OF to OF/OF, of at most {}", most_shards));
  return shard;
}

void check_shardable(const Job& job) {
  const auto shardable = [](const Job& one) {
    if (one.kind == JobKind::compare) return true;
    if (one.kind == JobKind::evaluate)
      return (one.tolerances && one.tolerances->samples > 0) || !one.maps.empty();
    return one.optimise->search == SearchKind::global || one.optimise->starts > 1;
  };
  const bool some = job.designs.empty()
                        ? shardable(job)
                        : std::ranges::any_of(job.designs, [&](const ListedDesign& design) {
                            return shardable(*design.job);
                          });
  if (!some)
    throw SpecError("--shard", job.name,
                    "this job has no independent work to share: expected a comparison, an "
                    "optimisation with several starts or a global search, sampled tolerances, or "
                    "maps");
}

void begin_shard(const fs::path& folder, const fs::path& job_folder, const Shard& shard) {
  const json said = shard_json(folder);
  if (said.is_null() && (fs::exists(folder / "evaluations.jsonl") ||
                         fs::exists(folder / "result.json") || fs::exists(folder / "units.jsonl")))
    throw SpecError("--out", folder.string(),
                    "a run that is no shard is in this folder: expected another folder");
  if (!said.is_null() && (said.at("shard") != shard.number || said.at("of") != shard.of))
    throw SpecError(
        "--out", folder.string(),
        fmt::format("shard {}/{} is in this folder: expected one of its own for {}/{}",
                    said.at("shard").dump(), said.at("of").dump(), shard.number, shard.of));
  const OrderedJson begun{{"flexopt", build_id()},
                          {"shard", shard.number},
                          {"of", shard.of},
                          {"job_folder", job_folder.string()},
                          {"done", false}};
  write_file(folder / "shard.json", json_text(begun));
}

void end_shard(const fs::path& folder, const Sharing& sharing) {
  OrderedJson said(shard_json(folder));
  said["done"] = true;
  for (const SharedLoop& loop : sharing.loops())
    said["loops"].push_back({{"what", loop.what}, {"here", loop.here}, {"all", loop.all}});
  write_file(folder / "shard.json", json_text(said));
}

FoundShards find_shards(const std::vector<fs::path>& folders) {
  FoundShards found;
  json document;
  std::set<int> done;
  std::map<int, fs::path> seen;
  for (const fs::path& folder : folders) {
    const json said = fs::is_directory(folder) ? shard_json(folder) : json();
    if (said.is_null())
      throw SpecError("", folder.string(),
                      "expected the output folder of a run with --shard: no shard.json in it");
    const int number = said.at("shard"), of = said.at("of");
    const json theirs = json::parse(read_file(folder / "job.json"), nullptr, false);
    if (document.is_null()) {
      document = theirs;
      found.of = of;
      found.job = parse_job_in(said.at("job_folder").get<std::string>(), theirs);
    }
    if (said.at("flexopt") != build_id())
      throw SpecError("", folder.string(),
                      fmt::format("evaluated by flexopt {}: expected that of this program, {}",
                                  said.at("flexopt").get<std::string>(), build_id()));
    if (theirs != document)
      throw SpecError("", folder.string(),
                      fmt::format("a shard of another job than {}: {}", folders.front().string(),
                                  first_difference(document, theirs)));
    if (of != found.of)
      throw SpecError("", folder.string(),
                      fmt::format("shard {} of {}: expected one of {}, as {}", number, of, found.of,
                                  folders.front().string()));
    if (const auto [other, fresh] = seen.try_emplace(number, folder); !fresh)
      found.notes.push_back(fmt::format("shard {} is there twice, in {} and {}", number,
                                        other->second.string(), folder.string()));
    if (said.at("done").get<bool>())
      done.insert(number);
    else
      found.notes.push_back(fmt::format("shard {} in {} is not done", number, folder.string()));
  }
  for (int number = 1; number <= found.of; ++number)
    if (!done.contains(number)) found.missing.push_back(number);
  return found;
}

void merge_logs(const FoundShards& found, const std::vector<fs::path>& folders,
                const fs::path& out) {
  for (const fs::path& own : folders_of(found.job))
    for (const char* log : logs) {
      Union all;
      for (const fs::path& folder : folders)
        if (fs::exists(folder / own / log)) all.add(folder / own / log);
      if (all.empty()) continue;
      if (fs::exists(out / own / log)) all.add(out / own / log);
      fs::create_directories(out / own);
      write_file(out / own / log, all.text());
    }
}

std::string array_text(const std::vector<int>& numbers) {
  std::string text;
  for (std::size_t i = 0, end; i < numbers.size(); i = end) {
    for (end = i + 1; end < numbers.size() && numbers[end] == numbers[end - 1] + 1;) ++end;
    text += text.empty() ? "" : ",";
    text += std::to_string(numbers[i]);
    if (end > i + 1) text += "-" + std::to_string(numbers[end - 1]);
  }
  return text;
}

int started_together() {
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE"})
    if (const char* size = std::getenv(name)) return std::atoi(size);
  return 0;
}

std::unique_ptr<Workers> join_workers() {
  if (started_together() < 2) return nullptr;
  // global: Open MPI loads parts of its own that look for it
  const PartFunction join =
      part_function("flexopt_mpi.so", "flexopt_join_workers", PartNames::global);
  if (!join.address)
    throw SpecError("mpirun", std::to_string(started_together()) + " processes",
                    "this flexopt cannot share a run by MPI (" + join.missing +
                        "): build it where Open MPI is (libopenmpi-dev), or use --shard");
  return std::unique_ptr<Workers>(reinterpret_cast<Workers* (*)()>(join.address)());
}

void tell_job(Workers& workers, const Job& job, const fs::path& job_folder) {
  workers.tell(nlohmann::json{build_id(), document_of(job), job_folder.string()}.dump());
}

Job hear_job(Workers& workers) {
  const auto told = nlohmann::json::parse(workers.hear());
  if (told.at(0) != build_id())
    throw SpecError("mpirun", build_id(),
                    fmt::format("expected the flexopt of the first process, {}",
                                told.at(0).get<std::string>()));
  return parse_job_in(told.at(2).get<std::string>(), told.at(1));
}

}  // namespace flexopt
