#include "optim/problem/evaluation_book.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "optim/solvers/parallel.hpp"

namespace flexopt {

using nlohmann::json;

namespace {

// CBOR: each double with all its bits
std::string bytes_of(const json& value) {
  std::string bytes;
  json::to_cbor(value, bytes);
  return bytes;
}

std::string packed(const DesignValues& values) {
  return bytes_of({values.ok, values.message, values.reason,
                   values.reached ? json(*values.reached) : json(), values.goals,
                   rows_of(values.gradient), values.no_gradient, values.of_reduced_leaves});
}

DesignValues unpacked(const std::string& bytes) {
  const json j = json::from_cbor(bytes);
  DesignValues values;
  j.at(0).get_to(values.ok);
  j.at(1).get_to(values.message);
  j.at(2).get_to(values.reason);
  if (!j.at(3).is_null()) values.reached = j.at(3).get<double>();
  j.at(4).get_to(values.goals);
  values.gradient = matrix_of(j.at(5));
  j.at(6).get_to(values.no_gradient);
  j.at(7).get_to(values.of_reduced_leaves);
  return values;
}

Answerer evaluator_of(const DesignProblem& problem) {
  return [&problem](const std::string& question) {
    const json q = json::from_cbor(question);
    const std::optional accuracy(Accuracy::full);
    return packed(problem.evaluate(q.at(0).get<Variables>(), q.at(1).get<bool>(),
                                   q.at(2).get<bool>() ? accuracy : std::nullopt));
  };
}

}  // namespace

ProgressBoard::ProgressBoard(ProgressCallback callback, int starts, bool maximise,
                             double feasible_within)
    : callback_(std::move(callback)), maximise_(maximise), feasible_within_(feasible_within) {
  progress_.starts = starts;
}

void ProgressBoard::add(const EvaluationRecord& record, bool replayed) {
  const std::lock_guard lock(mutex_);
  progress_.start = record.start;
  ++progress_.evaluations;
  if (!record.ok) ++progress_.failed;
  if (replayed) ++progress_.replayed;
  if (record.ok && !record.full && record.violation <= feasible_within_ &&
      (!progress_.best ||
       (maximise_ ? record.objective > *progress_.best : record.objective < *progress_.best)))
    progress_.best = record.objective;
  if (callback_) callback_(record, progress_);
}

VectorXd flattened(const DesignValues& values) {
  Eigen::Index size = 0;
  for (const GoalValues& g : values.goals) size += std::ssize(g);
  VectorXd flat(size);
  Eigen::Index k = 0;
  for (const GoalValues& g : values.goals)
    for (const double v : g) flat[k++] = v;
  return flat;
}

void EvaluationBook::adopt(const EvaluationBook& other) {
  known_.insert(other.known_.begin(), other.known_.end());
  known_full_.insert(other.known_full_.begin(), other.known_full_.end());
  differences_.insert(other.differences_.begin(), other.differences_.end());
}

void EvaluationBook::weigh(EvaluationRecord& record) const {
  if (!record.ok) return;
  record.violation = problem_.violation(record.constraints, scales_);
  record.worst = problem_.worst_constraint(record.constraints, scales_);
}

void EvaluationBook::set_scales(Scales scales) {
  scales_ = std::move(scales);
  for (LoggedEvaluation& e : evaluations_) weigh(e.record);
}

LoggedEvaluation EvaluationBook::record(const Variables& variables, DesignValues values, Ask how,
                                        int number) const {
  LoggedEvaluation e{.record = {.stage = stage_,
                                .start = start_,
                                .number = number,
                                .full = how.full,
                                .variables = problem_.named(variables),
                                .ok = values.ok,
                                .message = values.message,
                                .difference = how.difference}};
  if (values.ok) {
    e.record.objective = problem_.objective(values);
    e.record.constraints = problem_.constraints(values);
  }
  weigh(e.record);
  e.gradient_asked = how.gradient;
  e.values = std::move(values);
  return e;
}

// By the worker that is free, if there are some: the others have the same job and answer by
// `answer_evaluations`. Throws as Workers::ask.
DesignValues EvaluationBook::evaluate(const Variables& variables, Ask how) const {
  if (!workers_)
    return problem_.evaluate(variables, how.gradient,
                             how.full ? std::optional(Accuracy::full) : std::nullopt);
  const json question{variables, how.gradient, how.full};
  return unpacked(workers_->ask(bytes_of(question), evaluator_of(problem_)));
}

std::vector<const DesignValues*> EvaluationBook::ask(const std::vector<Variables>& many, Ask how,
                                                     int& cost) {
  std::map<Variables, Known>& known = how.full ? known_full_ : known_;
  std::vector<Variables> fresh;
  for (const Variables& v : many) {
    if (std::ranges::find(fresh, v) != fresh.end()) continue;
    if (const auto it = known.find(v); it != known.end())
      if (!how.gradient || it->second.gradient_asked || !it->second.values.ok) continue;
    if (const Check near = problem_.near_formulas(v, scales_); !near) {
      known[v] = {{.message = near.error()}, true};
      continue;
    }
    fresh.push_back(v);
  }
  const auto count = static_cast<int>(fresh.size()), first = static_cast<int>(evaluations_.size());
  std::vector<LoggedEvaluation> done(fresh.size());
  parallel_for(count, threads_, [&](int k) {
    const LoggedEvaluation* logged = log_.find(fresh[k], how.full, how.gradient);
    DesignValues values = logged ? logged->values : evaluate(fresh[k], how);
    if (!how.gradient) {
      values.gradient.resize(0, 0);
      values.no_gradient.clear();
    }
    done[k] = record(fresh[k], std::move(values), how, first + k);
    if (!logged) log_.append(done[k]);
    board_.add(done[k].record, logged != nullptr);
  });
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    if (!done[k].record.ok) ++failures_;
    known[fresh[k]] = {done[k].values, how.gradient};
    evaluations_.push_back(std::move(done[k]));
  }
  cost += count;
  std::vector<const DesignValues*> answers;
  for (const Variables& v : many) answers.push_back(&known.at(v).values);
  return answers;
}

const DesignValues& EvaluationBook::at(const Variables& variables, int& cost) {
  return *ask({variables}, {.gradient = eager_}, cost).front();
}

const DesignValues& EvaluationBook::full(const Variables& variables, int& cost) {
  return *ask({variables}, {.gradient = problem_.differentiable(), .full = true}, cost).front();
}

bool EvaluationBook::add_differences(const VectorXd& x, const DesignValues& values,
                                     const std::vector<Eigen::Index>& columns, Differences& known,
                                     int& cost) {
  DifferenceOptions options;
  options.columns = columns;
  int entry = 0;
  for (std::size_t g = 0; g < values.goals.size(); ++g) {
    const int branches = problem_.goals()[g].branches,
              size = static_cast<int>(values.goals[g].size());
    if (branches > 1)
      for (int i = 0; i < size; i += branches) options.branches.emplace_back(entry + i, branches);
    entry += size;
  }
  const auto evaluate = [&](const std::vector<VectorXd>& xs) {
    std::vector<Variables> many;
    for (const VectorXd& y : xs) many.push_back(problem_.variables(y));
    std::vector<std::optional<VectorXd>> answers;
    for (const DesignValues* v : ask(many, {.difference = true}, cost))
      answers.push_back(v->ok ? std::optional(flattened(*v)) : std::nullopt);
    return answers;
  };
  const auto found = central_differences(evaluate, x, flattened(values), options);
  if (!found) return false;
  used_differences_ = true;
  for (const Eigen::Index j : columns) {
    known.values.col(j) = found->col(j);
    known.columns[j] = true;
  }
  // what is a formula has exact ones
  for (std::size_t g = 0; g < values.goals.size(); ++g)
    if (problem_.goals()[g].of_parameters())
      if (const auto exact = problem_.formula_gradient(g, problem_.variables(x)))
        for (const Eigen::Index j : columns)
          known.values(values.first(g), j) = (*exact)[j] * problem_.range(j);
  return true;
}

std::optional<MatrixXd> EvaluationBook::derivatives(const VectorXd& x, int& cost,
                                                    const std::vector<Eigen::Index>& wanted) {
  const Variables center = problem_.variables(x);
  const bool exact = problem_.differentiable();
  const DesignValues values = *ask({center}, {.gradient = eager_ || exact}, cost).front();
  if (!values.ok) return std::nullopt;
  if (values.gradient.rows() > 0) {
    MatrixXd scaled = values.gradient;
    for (Eigen::Index j = 0; j < scaled.cols(); ++j) scaled.col(j) *= problem_.range(j);
    return scaled;
  }
  if (why_differences_.empty() && !values.no_gradient.empty()) {
    std::vector<std::string> design;
    for (const auto& [name, value] : problem_.named(center))
      design.push_back(fmt::format("{} = {:.6g}", name, value));
    why_differences_ = fmt::format("{}, first at {}", values.no_gradient, fmt::join(design, ", "));
  }
  Differences known{MatrixXd::Zero(flattened(values).size(), x.size()),
                    std::vector<bool>(x.size())};
  if (const auto it = differences_.find(center); it != differences_.end()) known = it->second;
  std::vector<Eigen::Index> missing;
  for (Eigen::Index j = 0; j < x.size(); ++j)
    if (!known.columns[j] && (wanted.empty() || std::ranges::find(wanted, j) != wanted.end()))
      missing.push_back(j);
  if (!missing.empty() && !add_differences(x, values, missing, known, cost)) return std::nullopt;
  differences_[center] = known;
  return known.values;
}

void answer_evaluations(Workers& workers, const DesignProblem& problem) {
  workers.answer(evaluator_of(problem));
}

}  // namespace flexopt
