#include "optim/problem/evaluation_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstdint>
#include <optional>
#include <set>
#include <stdexcept>

#include "core/reduction/atlas/tube_atlas.hpp"

namespace flexopt {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

namespace {

constexpr const char* stage_names[] = {"search", "stock", "pareto", "verification"};

std::string line_of(const LoggedEvaluation& e) {
  const EvaluationRecord& r = e.record;
  return log_line(
      {{"stage", name_of(r.stage)},
       {"start", r.start},
       {"number", r.number},
       {"full", r.full},
       {"variables", r.variables},
       {"ok", r.ok},
       {"message", r.message},
       {"objective", r.objective},
       {"constraints", r.constraints},
       {"violation", r.violation},
       {"difference", r.difference},
       {"values", e.values.goals},
       // null: not asked for; []: asked for, but there is none
       {"gradient", e.gradient_asked ? OrderedJson(rows_of(e.values.gradient)) : OrderedJson()},
       {"no_gradient", e.values.no_gradient},
       {"of_reduced_leaves", e.values.of_reduced_leaves}});
}

LoggedEvaluation parse_line(const std::string& line) {
  const json j = json::parse(line);
  LoggedEvaluation e{.record = record_of(j)};
  j.at("values").get_to(e.values.goals);
  e.values.ok = e.record.ok;
  e.values.message = e.record.message;
  j.at("no_gradient").get_to(e.values.no_gradient);
  j.at("of_reduced_leaves").get_to(e.values.of_reduced_leaves);
  const json& gradient = j.at("gradient");
  e.gradient_asked = !gradient.is_null();
  if (e.gradient_asked) e.values.gradient = matrix_of(gradient);
  return e;
}

}  // namespace

std::vector<std::vector<double>> rows_of(const MatrixXd& matrix) {
  std::vector<std::vector<double>> rows;
  for (const auto& row : matrix.rowwise()) rows.emplace_back(row.begin(), row.end());
  return rows;
}

MatrixXd matrix_of(const json& rows) {
  MatrixXd matrix;
  if (rows.empty()) return matrix;
  matrix.resize(rows.size(), rows.front().size());
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index k = 0; k < matrix.cols(); ++k) matrix(i, k) = rows.at(i).at(k).get<double>();
  return matrix;
}

std::string name_of(Stage stage) { return stage_names[static_cast<std::size_t>(stage)]; }

Stage stage_named(const std::string& name) {
  const auto found = std::ranges::find(stage_names, name);
  if (found == std::end(stage_names)) throw std::runtime_error("unknown stage " + name);
  return static_cast<Stage>(found - std::begin(stage_names));
}

EvaluationRecord record_of(const json& line) {
  EvaluationRecord record;
  record.stage = stage_named(line.value("stage", "search"));
  line.at("start").get_to(record.start);
  line.at("number").get_to(record.number);
  record.full = line.value("full", false);
  line.at("variables").get_to(record.variables);
  line.at("ok").get_to(record.ok);
  record.message = line.value("message", "");
  record.difference = line.value("difference", false);
  if (!record.ok) return record;
  line.at("objective").get_to(record.objective);
  line.at("constraints").get_to(record.constraints);
  line.at("violation").get_to(record.violation);
  return record;
}

json log_identity(const Job& job, const std::string& version) {
  json identity = document_of(job);
  assert(identity.is_object());
  for (const char* key : {"name", "expect"}) identity.erase(key);
  if (identity.contains("optimise"))
    for (const char* key : {"starts", "max_evaluations", "screened_designs"})
      identity["optimise"].erase(key);
  json whole{{"version", version}, {"job", std::move(identity)}};
  // leaves that another atlas, or none, would give are others
  const auto add_atlas = [&](const ModelOptions& model) {
    if (model.atlas) whole["looked_up_in"].push_back(model.atlas->fingerprint());
  };
  add_atlas(job.model);
  if (job.search_model) add_atlas(*job.search_model);
  if (job.compare)
    for (const ModelChoice& choice : job.compare->models) add_atlas(choice.model);
  return whole;
}

EvaluationLog::EvaluationLog(const Job& job, const std::filesystem::path& path,
                             const std::string& version, bool overwrite)
    : job_(job) {
  if (!path.empty())
    lines_.open(path, log_identity(job, version), overwrite,
                [this](const std::string& line) { read(line); });
}

EvaluationLog::Key EvaluationLog::key_of(const LoggedEvaluation& evaluation) const {
  Key key{evaluation.record.full, evaluation.gradient_asked, {}};
  for (const Variable& v : job_.optimise->variables)
    key.variables.push_back(evaluation.record.variables.at(v.parameter));
  return key;
}

void EvaluationLog::read(const std::string& line) {
  LoggedEvaluation e = parse_line(line);
  index_.emplace(key_of(e), loaded_.size());
  loaded_.push_back(std::move(e));
}

const LoggedEvaluation* EvaluationLog::find(const Variables& variables, bool full,
                                            bool gradient) const {
  const auto it = index_.find({full, gradient, variables});
  return it == index_.end() ? nullptr : &loaded_[it->second];
}

void EvaluationLog::append(const LoggedEvaluation& evaluation) {
  lines_.append(line_of(evaluation));
}

void EvaluationLog::finish(const std::vector<LoggedEvaluation>& evaluations) {
  std::vector<std::string> lines;
  std::set<Key> written;
  for (const LoggedEvaluation& e : evaluations) {
    lines.push_back(line_of(e));
    written.insert(key_of(e));
  }
  for (const LoggedEvaluation& e : loaded_)
    if (!written.contains(key_of(e))) lines.push_back(line_of(e));
  lines_.finish(lines);
}

SharedUnits::SharedUnits(Sharing& sharing, const Job& job, const std::filesystem::path& log,
                         const std::string& version)
    : sharing_(sharing) {
  if (!log.empty())
    log_.open(log, log_identity(job, version), false,
              [this](const std::string& line) { read(line); });
}

void SharedUnits::read(const std::string& line) {
  json j = json::parse(line);
  known_[{j.at(0).get<std::string>(), j.at(1).get<int>()}] = std::move(j.at(2));
}

bool SharedUnits::run(const std::string& loop, int count, int threads, const LoopProgress& progress,
                      const std::function<OrderedJson(int)>& work,
                      const std::function<void(int, const json&)>& keep) {
  const auto known = [&](int unit) {
    const auto yield = known_.find({loop, unit});
    if (yield == known_.end()) return std::optional<bool>();
    keep(unit, yield->second);
    return std::optional(false);
  };
  const auto line = [&](int unit) {
    return log_line(OrderedJson::array({loop, unit, work(unit)}));
  };
  const auto add = [&](const std::string& added) {
    log_.append(added);
    read(added);
  };
  const auto tell = [&](const LoopState& state) {
    if (progress && state.done > 0) progress(state.done, state.total);
  };
  return sharing_.run({loop.substr(0, loop.rfind(' ')), count, threads, known, line, add, tell});
}

std::string loop_name(const std::string& name, const std::string& depends_on) {
  std::uint64_t hash = 14695981039346656037U;  // FNV-1a
  for (const unsigned char c : depends_on) hash = (hash ^ c) * 1099511628211U;
  return fmt::format("{} {:016x}", name, hash);
}

}  // namespace flexopt
