#include "optim/evaluation_log.hpp"

#include <cassert>
#include <set>

namespace flexopt {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

namespace {

std::string line_of(const LoggedEvaluation& e) {
  const EvaluationRecord& r = e.record;
  return log_line({{"start", r.start},
                   {"number", r.number},
                   {"variables", r.variables},
                   {"ok", r.ok},
                   {"message", r.message},
                   {"objective", r.objective},
                   {"constraints", r.constraints},
                   {"violation", r.violation},
                   {"difference", r.difference},
                   {"values", e.values.goals}});
}

LoggedEvaluation parse_line(const std::string& line) {
  const json j = json::parse(line);
  LoggedEvaluation e;
  j.at("start").get_to(e.record.start);
  j.at("number").get_to(e.record.number);
  j.at("variables").get_to(e.record.variables);
  j.at("ok").get_to(e.record.ok);
  j.at("message").get_to(e.record.message);
  j.at("objective").get_to(e.record.objective);
  j.at("constraints").get_to(e.record.constraints);
  j.at("violation").get_to(e.record.violation);
  j.at("difference").get_to(e.record.difference);
  j.at("values").get_to(e.values.goals);
  e.values.ok = e.record.ok;
  e.values.message = e.record.message;
  return e;
}

Variables key_of(const Job& job, const EvaluationRecord& record) {
  Variables key;
  for (const Variable& v : job.optimise->variables) key.push_back(record.variables.at(v.parameter));
  return key;
}

}  // namespace

json log_identity(const Job& job, const std::string& version) {
  json identity = job.as_read;
  assert(identity.is_object());
  for (const char* key : {"name", "expect"}) identity.erase(key);
  if (identity.contains("optimise"))
    for (const char* key : {"starts", "max_evaluations"}) identity["optimise"].erase(key);
  return {{"version", version}, {"job", std::move(identity)}};
}

EvaluationLog::EvaluationLog(const Job& job, const std::filesystem::path& path,
                             const std::string& version, bool overwrite)
    : job_(job),
      lines_(path, log_identity(job, version), overwrite,
             [this](const std::string& line) { read(line); }) {}

void EvaluationLog::read(const std::string& line) {
  LoggedEvaluation e = parse_line(line);
  index_.emplace(key_of(job_, e.record), loaded_.size());
  loaded_.push_back(std::move(e));
}

const DesignValues* EvaluationLog::find(const Variables& variables) const {
  const auto it = index_.find(variables);
  return it == index_.end() ? nullptr : &loaded_[it->second].values;
}

void EvaluationLog::append(const LoggedEvaluation& evaluation) {
  lines_.append(line_of(evaluation));
}

void EvaluationLog::finish(const std::vector<LoggedEvaluation>& evaluations) {
  std::vector<std::string> lines;
  std::set<Variables> written;
  for (const LoggedEvaluation& e : evaluations) {
    lines.push_back(line_of(e));
    written.insert(key_of(job_, e.record));
  }
  for (const LoggedEvaluation& e : loaded_)
    if (!written.contains(key_of(job_, e.record))) lines.push_back(line_of(e));
  lines_.finish(lines);
}

}  // namespace flexopt
