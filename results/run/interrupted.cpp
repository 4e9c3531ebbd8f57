#include <fmt/format.h>
#include <sys/stat.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>

#include "core/spec/spec_error.hpp"
#include "optim/problem/evaluation_book.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/search/optimise.hpp"
#include "optim/studies/compare.hpp"
#include "results/files/folder.hpp"
#include "results/files/result_json.hpp"
#include "results/files/scene.hpp"
#include "results/run/run.hpp"
#include "results/run/run_files.hpp"

namespace flexopt {

namespace fs = std::filesystem;

namespace {

ShownRun unfinished(OrderedJson result, OrderedJson scene = {}) {
  return {std::make_shared<OrderedJson>(std::move(result)),
          std::make_shared<OrderedJson>(std::move(scene)), false};
}

ShownRun interrupted_comparison(const Job& job, const fs::path& log) {
  RunRecord record{.job = job, .mechanism = make_mechanism(job, job.design.parameters)};
  record.comparison = compare_logged(job, log);
  record.status = "interrupted";
  record.message = fmt::format(
      "The comparison was interrupted after {} of {} evaluations; run the same command to go on.",
      record.comparison->evaluated, record.comparison->evaluations);
  return unfinished(make_result(record));
}

/// The constraints of the best design so far. A second objective is none of them.
std::vector<ConstraintState> states_of(const OptimiseSpec& spec, const EvaluationRecord& best) {
  std::vector<ConstraintState> states;
  for (std::size_t i = 0; i < std::min(spec.constraints.size(), best.constraints.size()); ++i) {
    const Constraint& c = spec.constraints[i];
    const double scale = std::max(std::abs(c.min.value_or(0)), std::abs(c.max.value_or(0)));
    states.push_back(
        state_of(c, best.constraints[i], scale > 0 ? scale : 1, spec.constraint_tolerance));
  }
  return states;
}

}  // namespace

const std::vector<EvaluationRecord>& GrowingLog::read(const fs::path& file) try {
  struct stat now {};
  if (::stat(file.c_str(), &now) != 0 || file != file_ || now.st_ino != inode_ ||
      static_cast<std::size_t>(now.st_size) < read_) {
    *this = {};
    lines_ = CheckedLines(file);
  }
  file_ = file;
  inode_ = now.st_ino;
  std::ifstream stream(file, std::ios::binary);
  stream.seekg(static_cast<std::streamoff>(read_));
  const std::string more{std::istreambuf_iterator<char>(stream), {}};
  for (std::size_t begin = 0, end; (end = more.find('\n', begin)) != std::string::npos;
       begin = end + 1) {
    read_ += end + 1 - begin;
    const auto line = nlohmann::json::parse(
        lines_.next(std::string_view(more).substr(begin, end - begin)), nullptr, false);
    if (line.is_object() && line.contains("variables"))  // the heading has none
      records_.push_back(record_of(line));
  }
  return records_;
} catch (const OrderedJson::exception& error) {
  throw SpecError("", file.string(), std::string("expected evaluations: ") + error.what());
}

ShownRun interrupted_run(const fs::path& folder, GrowingLog& evaluations) {
  const Job job = read_job((folder / "job.json").string());
  if (!job.designs.empty()) return unfinished(interrupted_designs(job, folder));
  const fs::path log = folder / "evaluations.jsonl";
  if (job.kind == JobKind::evaluate || !fs::exists(log))
    throw SpecError("", folder.string(),
                    "expected a finished run, or an optimisation or comparison with some "
                    "evaluations");
  if (job.kind == JobKind::compare) return interrupted_comparison(job, log);
  RunRecord record;
  record.job = job;
  const OptimiseSpec& spec = *job.optimise;
  Optimum optimum;
  optimum.history = evaluations.read(log);
  optimum.parameters = job.design.parameters;
  optimum.stop_reason = "interrupted";
  const EvaluationRecord* best = nullptr;
  for (const EvaluationRecord& trial : optimum.history) {
    ++optimum.evaluations;
    if (!trial.ok)
      ++optimum.failed_evaluations;
    else if (!trial.difference && !trial.full &&
             (!best || better(trial, *best, spec.objective.maximise, spec.constraint_tolerance)))
      best = &trial;
  }
  if (best) {
    for (const auto& [name, value] : best->variables) optimum.parameters[name] = value;
    optimum.parameters = complete_parameters(job.design, optimum.parameters);
    optimum.objective = best->objective;
    optimum.best_start = best->start;
    optimum.constraints = states_of(spec, *best);
    optimum.status = best->violation <= spec.constraint_tolerance ? OptimumStatus::feasible
                                                                  : OptimumStatus::infeasible;
  }
  record.mechanism = make_mechanism(job, optimum.parameters);
  record.status = "interrupted";
  record.message = fmt::format(
      "The optimisation was interrupted after {} evaluations ({} failed); run the same command to "
      "go on. Shown is the best design so far.",
      optimum.evaluations, optimum.failed_evaluations);
  const fs::path screened = screening_log(log);
  if (spec.search == SearchKind::global && optimum.history.empty() && fs::exists(screened))
    record.message = fmt::format(
        "The optimisation was interrupted after {} of {} screened designs; run the same command to "
        "go on. Shown is the job's own design.",
        std::min(screened_so_far(screened), spec.screened_designs), spec.screened_designs);
  record.optimum = std::move(optimum);
  return unfinished(make_result(record), make_scene(record));
}

}  // namespace flexopt
