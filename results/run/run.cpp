#include "results/run/run.hpp"

#include <fmt/format.h>

#include <chrono>
#include <nlohmann/json.hpp>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/response/models/leaf_models.hpp"
#include "core/response/path/model_choice.hpp"
#include "core/spec/spec_error.hpp"
#include "optim/job/job_numbers.hpp"
#include "optim/problem/evaluation_log.hpp"
#include "optim/problem/goals.hpp"
#include "optim/problem/stroke_sensitivity.hpp"
#include "optim/search/stages.hpp"
#include "optim/studies/compare.hpp"
#include "optim/studies/response_map.hpp"
#include "optim/studies/tolerance_study.hpp"
#include "results/files/result_json.hpp"
#include "results/files/version.hpp"

namespace flexopt {

namespace {

/// Evaluates a design with shapes, for drawing.
StrokeResponse drawn_response(const Job& job, const ParameterValues& parameters,
                              const Mechanism& mechanism, const StrokeRequest& request) {
  StrokeResponse response = evaluate_stroke(mechanism, job.model, drawn(request));
  add_defined_quantities(job, complete_numbers(job, parameters), response);
  return response;
}

/// The request, of whose evaluation the listener is told: of every point and load that is done, and
/// ten times a second of the Newton iterations.
StrokeRequest watched(RunListener& listener, StrokeRequest request) {
  using Clock = std::chrono::steady_clock;
  const bool loads = request.growing_load() || request.wants_capacity();
  request.progress = [&listener, loads, last = Clock::time_point(),
                      done = -1](const StrokeProgress& now) mutable {
    if (now.done == done && Clock::now() - last < std::chrono::milliseconds(100)) return;
    last = Clock::now();
    done = now.done;
    listener.step({.done = done,
                   .total = now.total,
                   .what = loads ? "stroke points and critical loads" : "stroke points",
                   .goals = fmt::format("{} Newton iterations", now.iterations)});
  };
  return request;
}

/// Evaluates every path of the job with shapes and with derivatives along these names. Where one
/// path has no derivatives, none are kept.
void differentiate(const std::vector<std::string>& along, RunListener& listener,
                   RunRecord& record) {
  for (JobCase& one : cases_of(record.job)) {
    one.request.outputs.add(Output::shapes);
    one.request.values = PathValues::differentiable;
    StrokeSensitivity found = stroke_sensitivity(record.job, record.job.design.parameters, along,
                                                 record.job.model, watched(listener, one.request));
    add_defined_quantities(record.job, complete_numbers(record.job, record.job.design.parameters),
                           found.response, found.gradients ? &*found.gradients : nullptr);
    if (!found.gradients && record.no_gradients.empty()) record.no_gradients = found.message;
    if (found.gradients) record.gradients.push_back(std::move(*found.gradients));
    (one.name.empty() ? record.response : record.cases.emplace_back()) = std::move(found.response);
  }
  if (!record.no_gradients.empty()) record.gradients.clear();
}

/// Chooses the model of a job that wants that, for the design that it begins with.
void choose_accuracy(RunListener& listener, RunRecord& record) {
  if (!record.job.accuracy.automatic) return;
  listener.say("choosing accuracy and mesh");
  std::vector<StrokeRequest> requests;
  for (const JobCase& one : cases_of(record.job)) requests.push_back(one.request);
  const auto told = [&](const TriedModel& tried) {
    listener.say(
        words_for(tried.accuracy, tried.mesh) + ": " +
        (tried.message.empty() ? "off by " + percent(tried.largest.relative) : tried.message));
  };
  record.chosen = choose_model(make_mechanism(record.job, record.job.design.parameters),
                               record.job.model, requests, record.job.accuracy.tolerance, told);
  record.job.model = record.chosen->model;
}

/// Sets the model that the search goes on with, where the chosen model is not that of the job and
/// leaves of the job's model can be looked up; and where every number that the optimisation tells
/// is one of its optimum: points of a front, designs in stock sizes and those beside a robust one
/// are not corrected on full leaves.
void choose_search_model(const ModelOptions& asked, RunRecord& record) {
  Job& job = record.job;
  const bool other = job.model.mesh != asked.mesh || job.model.accuracy != asked.accuracy;
  if (other && asked.atlas && !job.optimise->pareto && !has_stock(*job.optimise) &&
      !job.tolerances && !job.assembly_tolerances)
    job.search_model = asked;
}

/// Adds the estimated errors, by this model, of the paths that the run is about. Full paths of the
/// model's choice belong to an evaluated design; an optimum is another design.
void add_errors(const ModelOptions& model, RunListener& listener, RunRecord& record) {
  if (!record.job.accuracy.wants_estimates()) return;
  listener.say("estimating errors");
  const std::vector<JobCase> cases = cases_of(record.job);
  const auto responses = responses_of(record);
  const bool known = record.chosen && !record.optimum;
  for (std::size_t k = 0; k < responses.size(); ++k)
    record.errors.push_back(
        known ? errors_of(*responses[k], record.chosen->full[k])
              : estimate_errors(record.mechanism, model, cases[k].request, *responses[k]));
}

/// Adds another design for the report to draw; one that cannot be made or has no equilibrium is
/// left out.
void draw_beside(RunRecord& record, const std::string& label, const std::string& kind,
                 const ParameterValues& parameters) {
  DrawnDesign other{label, kind, parameters, {}, {}};
  Job job = record.job;
  if (kind == "pareto") {  // its shapes alone
    job.request.frequencies = 0;
    job.request.outputs = {Output::equilibrium, Output::stress};
  }
  try {
    other.mechanism = make_mechanism(job, parameters);
    other.response = drawn_response(job, parameters, other.mechanism, job.request);
  } catch (const SpecError&) {
    return;
  }
  if (other.response.status == Status::ok) record.others.push_back(std::move(other));
}

/// Draws the start of an optimisation and the points of its front.
void draw_others(RunRecord& record) {
  const Optimum& optimum = *record.optimum;
  if (!optimum.starts.empty()) {
    ParameterValues parameters = optimum.parameters;
    for (const auto& [name, value] : optimum.starts.front().from) parameters[name] = value;
    draw_beside(record, "start", "start", parameters);
  }
  if (!optimum.pareto) return;
  for (std::size_t k = 0; k < optimum.pareto->points.size(); ++k)
    if (const ParetoPoint& p = optimum.pareto->points[k]; p.ok)
      draw_beside(record, fmt::format("front, point {}", k + 1), "pareto", p.parameters);
}

void add_timings(RunRecord& record) {
  for (const StrokeResponse* one : responses_of(record)) {
    record.timings["coefficients"] += one->seconds_coefficients;
    record.timings["path"] += one->seconds_path;
  }
}

/// Evaluates designs beside the one with these parameters: tolerances, assembly errors, maps.
void look_around(const ParameterValues& parameters, const ModelOptions& model,
                 const RunOptions& options, RunListener& listener, RunRecord& record) {
  const Job& job = record.job;
  Sharing* const sharing = options.sharing;
  std::unique_ptr<SharedUnits> shared;
  if (sharing)
    shared = std::make_unique<SharedUnits>(*sharing, job, units_log(options.folder), build_id());
  if (job.tolerances) {
    listener.say(fmt::format("tolerances: {} sampled designs", job.tolerances->samples));
    record.tolerances = study_tolerances(job, parameters, model, options.threads,
                                         counted(listener, "sampled designs"), shared.get());
  }
  if (job.assembly_tolerances && (!sharing || sharing->complete())) {
    const int most = most_paths(job);
    listener.say(fmt::format("errors of assembly: the worst of the box, {} paths at most", most));
    record.assembly = study_assembly(job, parameters, model, [&](int paths) {
      listener.step({.done = paths, .total = most, .what = "paths", .at_most = true});
    });
  }
  const std::size_t count = job.maps.size();
  for (std::size_t k = 0; k < count; ++k) {
    const MapSpec& map = job.maps[k];
    listener.say(
        fmt::format("map {} of {}: {} designs", k + 1, count, map.points[0] * map.points[1]));
    record.maps.push_back(evaluate_map(
        job, map, parameters, options.threads, evaluate_stroke,
        counted(listener, fmt::format("designs of map {} of {}", k + 1, count)), shared.get()));
  }
}

bool follows(const RunOptions& options) { return options.sharing && options.sharing->follows(); }

/// A leader tells the processes that follow the design and the model of the studies, or, where
/// there are no parameters, that there is none.
void tell_design(const ParameterValues* parameters, const ModelOptions& model,
                 const Sharing* sharing) {
  using nlohmann::json;
  if (!sharing || !sharing->workers()) return;
  const json design = parameters ? json{*parameters, static_cast<int>(model.accuracy)} : json();
  sharing->workers()->tell(design.dump());
}

/// Runs a process that follows: it evaluates the studies of the design that the leader tells it.
void follow(const RunOptions& options, RunListener& listener, RunRecord& record) {
  const auto told = nlohmann::json::parse(options.sharing->workers()->hear());
  if (told.is_null()) return;
  ModelOptions model = record.job.model;
  model.accuracy = static_cast<Accuracy>(told.at(1).get<int>());
  look_around(told.at(0).get<ParameterValues>(), model,
              {.threads = options.threads, .sharing = options.sharing}, listener, record);
}

/// True where a finished run of another job, or of another version, left its evaluations: they are
/// of no use and nothing is lost with them. Those of an interrupted one are refused.
bool overwrites_finished(const Job& job, const std::filesystem::path& folder,
                         const std::filesystem::path& log, const std::string& version) try {
  if (job.kind == JobKind::compare) {
    check_compare_log(job, log, version);
  } else {
    const EvaluationLog own(job, log, version, false);
    if (job.optimise->search == SearchKind::global)
      check_screening_log(job, screening_log(log), version);
  }
  return false;
} catch (const SpecError&) {
  if (!holds_finished_run(folder)) throw;
  return true;
}

/// If there is a folder, it belongs to this job from here on: its log goes on, or begins.
void keep_log(const Job& job, const RunOptions& run, auto& options) {
  options.threads = run.threads;
  options.sharing = run.sharing;
  if (run.folder.empty()) return;
  options.log = run.folder / "evaluations.jsonl";
  options.version = build_id();
  options.overwrite_log = overwrites_finished(job, run.folder, options.log, options.version);
  write_job(run.folder, job);
}

RunRecord run_evaluation(const Job& job, const RunOptions& options, RunListener& listener) {
  if (!options.folder.empty()) write_job(options.folder, job);
  RunRecord record{.job = job, .mechanism = make_mechanism(job, job.design.parameters)};
  constexpr std::size_t long_wait = 20000;  // nodes, beyond which bodies take more than seconds
  for (const ElasticBody& body : record.mechanism.elastic_bodies)
    if (body.nodes.size() > long_wait)
      listener.say(fmt::format(
          "condensing {}, {} unknowns, which may take minutes: larger \"elements\" take less",
          body.name, 3 * body.nodes.size()));
  choose_accuracy(listener, record);
  if (follows(options)) {
    follow(options, listener, record);
    return record;
  }
  std::size_t points = 0;
  for (const JobCase& one : cases_of(job)) points += one.request.points.size();
  const std::string cases =
      job.cases.empty() ? "" : fmt::format(" in {} load cases", job.cases.size());
  listener.say(fmt::format("evaluating {} at {} stroke points{}", job.name, points, cases));
  if (!options.along.empty()) differentiate(options.along, listener, record);
  for (std::size_t k = record.cases.size(); k < job.cases.size(); ++k)
    record.cases.push_back(drawn_response(record.job, job.design.parameters, record.mechanism,
                                          watched(listener, record.job.cases[k].request)));
  if (!job.cases.empty())
    record.response = record.cases.front();
  else if (options.along.empty())
    record.response = drawn_response(record.job, job.design.parameters, record.mechanism,
                                     watched(listener, job.request));
  add_errors(record.job.model, listener, record);
  add_timings(record);
  conclude(record);
  const bool ok = record.status == "ok";
  tell_design(ok ? &job.design.parameters : nullptr, record.job.model, options.sharing);
  if (ok) look_around(job.design.parameters, record.job.model, options, listener, record);
  return record;
}

RunRecord run_optimisation(const Job& asked, const RunOptions& run, RunListener& listener) {
  RunRecord record;
  record.job = asked;
  choose_accuracy(listener, record);
  choose_search_model(asked.model, record);
  const Job job = record.job;
  OptimiseOptions options;
  keep_log(job, run, options);
  if (follows(run)) {
    optimise(job, options);
    follow(run, listener, record);
    return record;
  }

  const OptimiseSpec& spec = *job.optimise;
  if (!run.folder.empty() && spec.search != SearchKind::global)
    std::filesystem::remove(screening_log(options.log));
  const int total = spec.starts * spec.max_evaluations;
  const DriveList drives = drives_of(job, make_mechanism(job, job.design.parameters));
  BestSoFar best(spec, drives);
  options.progress = [&](const EvaluationRecord& evaluation, const Progress& progress) {
    best.add(evaluation);
    listener.step(step_of(progress, total, best));
  };
  listener.say(fmt::format("optimising {}: {} variables, {} constraints, {} starts", job.name,
                           spec.variables.size(), spec.constraints.size(), spec.starts));
  const auto begin = std::chrono::steady_clock::now();
  options.screening_progress = [&](const LoopState& state) {
    const double seconds = seconds_since(begin);
    if (state.done == state.total) record.timings["screening"] = seconds;
    listener.step(step_of(state, "designs screened", "without values", seconds));
  };
  record.optimum = optimise(job, options);

  Optimum& optimum = *record.optimum;
  const bool evaluated = optimum.status != OptimumStatus::failed;
  record.mechanism = make_mechanism(job, evaluated ? optimum.parameters : job.design.parameters);
  if (evaluated) {
    draw_others(record);
    ModelOptions model = job.model;
    if (optimum.at_full_accuracy) model.accuracy = Accuracy::full;
    add_errors(job.model, listener, record);
    tell_design(&optimum.parameters, model, run.sharing);
    look_around(optimum.parameters, model, run, listener, record);
  } else {
    tell_design(nullptr, {}, run.sharing);
  }
  add_timings(record);
  conclude(record);
  return record;
}

RunRecord run_comparison(const Job& job, const RunOptions& asked, RunListener& listener) {
  RunRecord record{.job = job, .mechanism = make_mechanism(job, job.design.parameters)};
  CompareOptions options;
  keep_log(job, asked, options);
  options.progress = [&](const LoopState& state) {
    listener.step(step_of(state, "evaluations", "failed"));
  };
  listener.say(fmt::format("comparing {}: {} model{} with full accuracy", job.name,
                           job.compare->models.size(), job.compare->models.size() == 1 ? "" : "s"));
  CompareRun run = compare(job, options);
  if (follows(asked)) return record;
  record.comparison = std::move(run.comparison);
  for (std::size_t m = 0; m < run.seconds.size(); ++m) {
    const std::string name = m == 0 ? "full accuracy" : "model " + job.compare->models[m - 1].name;
    record.timings[name + ", paths"] = run.seconds[m].path;
    record.timings[name + ", whole"] = run.seconds[m].total;
  }
  conclude(record);
  return record;
}

}  // namespace

RunRecord run_any(const Job& job, const RunOptions& options, RunListener& listener) {
  return job.kind == JobKind::optimise  ? run_optimisation(job, options, listener)
         : job.kind == JobKind::compare ? run_comparison(job, options, listener)
                                        : run_evaluation(job, options, listener);
}

RunRecord undeflected(const Job& job) {
  demand_one_design(job, "a job of one design can be shown");
  RunRecord record{.job = job, .mechanism = make_mechanism(job, job.design.parameters)};
  PathPoint point;
  for (const auto& leaf : make_full_leaves(record.mechanism, job.model))
    point.shapes.push_back(leaf->shape());
  point.bodies.resize(record.mechanism.bodies.size());
  record.response.path = {point};
  record.cases.assign(job.cases.size(), record.response);
  record.status = "undeflected";
  record.message = "The mechanism as designed; no equilibrium was computed.";
  return record;
}

OrderedJson undeflected_result(const RunRecord& record) {
  OrderedJson result = make_result(record);
  for (const char* key : {"case", "cases", "extremes"}) result.erase(key);
  result["status"] = record.status;
  result["message"] = record.message;
  result["path"] = OrderedJson::array();
  return result;
}

}  // namespace flexopt
