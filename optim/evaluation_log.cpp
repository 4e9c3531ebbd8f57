#include "optim/evaluation_log.hpp"

#include <fmt/format.h>

#include <cassert>
#include <iterator>
#include <set>

#include "core/spec/spec_error.hpp"

namespace flexopt {

using nlohmann::json;
using OrderedJson = nlohmann::ordered_json;

namespace {

/// Doubles as the shortest text that reads back to the same bits.
std::string text(const OrderedJson& line) {
  return line.dump(-1, ' ', false, OrderedJson::error_handler_t::replace) + "\n";
}

std::string line_of(const LoggedEvaluation& e) {
  const EvaluationRecord& r = e.record;
  return text({{"start", r.start},
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

std::string first_difference(const json& theirs, const json& ours) {
  const json patch = json::diff(theirs, ours);
  if (patch.empty()) return "nothing";
  const std::string pointer = patch.front().at("path");
  const json::json_pointer at(pointer);
  const auto value = [&](const json& side) {
    return side.contains(at) ? side.at(at).dump() : std::string("nothing");
  };
  return fmt::format("{} was {} and is {}", pointer, value(theirs), value(ours));
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
    : job_(job), path_(path) {
  header_ = text({{"flexopt_evaluations", OrderedJson(log_identity(job, version))}});
  read(overwrite);
}

void EvaluationLog::read(bool overwrite) {
  const auto refuse = [&](const std::string& found) {
    return SpecError(
        path_.string(), found,
        "expected the evaluations of this very job; write to another folder, or remove "
        "the file to start anew");
  };
  std::string content;
  if (std::ifstream in(path_, std::ios::binary); in && !overwrite)
    content.assign(std::istreambuf_iterator<char>(in), {});
  std::size_t kept = 0;  // bytes of whole lines
  for (std::size_t number = 1, end; (end = content.find('\n', kept)) != std::string::npos;
       kept = end + 1, ++number) {
    const std::string line = content.substr(kept, end - kept);
    try {
      if (number == 1) {
        const json theirs = json::parse(line).at("flexopt_evaluations");
        const json ours = json::parse(header_).at("flexopt_evaluations");
        if (theirs != ours) throw refuse("a log of another job: " + first_difference(theirs, ours));
        continue;
      }
      LoggedEvaluation e = parse_line(line);
      index_.emplace(key_of(job_, e.record), loaded_.size());
      loaded_.push_back(std::move(e));
    } catch (const std::exception& error) {
      if (dynamic_cast<const SpecError*>(&error)) throw;
      throw refuse(fmt::format("line {}, which is no evaluation: {}", number, line.substr(0, 60)));
    }
  }
  if (kept == 0 && !header_.starts_with(content)) throw refuse("a file that is no log");
  if (kept < content.size()) std::filesystem::resize_file(path_, kept);
  out_.open(path_,
            overwrite ? std::ios::binary | std::ios::trunc : std::ios::binary | std::ios::app);
  if (out_ && kept == 0) out_ << header_ << std::flush;
  if (!out_) throw SpecError(path_.string(), "not writable", "expected a file that can be written");
}

const DesignValues* EvaluationLog::find(const Variables& variables) const {
  const auto it = index_.find(variables);
  return it == index_.end() ? nullptr : &loaded_[it->second].values;
}

void EvaluationLog::append(const LoggedEvaluation& evaluation) {
  if (path_.empty()) return;
  const std::lock_guard lock(mutex_);
  out_ << line_of(evaluation) << std::flush;
  if (!out_)
    throw SpecError(path_.string(), "not writable", "expected room for one more evaluation");
}

void EvaluationLog::finish(const std::vector<LoggedEvaluation>& evaluations) {
  if (path_.empty()) return;
  std::string content = header_;
  std::set<Variables> written;
  for (const LoggedEvaluation& e : evaluations) {
    content += line_of(e);
    written.insert(key_of(job_, e.record));
  }
  for (const LoggedEvaluation& e : loaded_)
    if (!written.contains(key_of(job_, e.record))) content += line_of(e);
  const std::lock_guard lock(mutex_);
  out_.close();
  const std::filesystem::path draft = path_.string() + ".new";
  std::ofstream draft_out(draft, std::ios::binary | std::ios::trunc);
  draft_out << content << std::flush;
  if (!draft_out)
    throw SpecError(draft.string(), "not writable", "expected a file that can be written");
  draft_out.close();
  std::filesystem::rename(draft, path_);  // the old log or the new one, never half of it
}

}  // namespace flexopt
