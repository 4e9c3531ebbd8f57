#include "optim/evaluation_book.hpp"

#include <algorithm>
#include <cassert>

#include "optim/parallel.hpp"

namespace flexopt {

bool better(const EvaluationRecord& a, const EvaluationRecord& b, bool maximise,
            double feasible_within) {
  const bool a_feasible = a.violation <= feasible_within,
             b_feasible = b.violation <= feasible_within;
  if (a_feasible != b_feasible) return a_feasible;
  if (!a_feasible) return a.violation < b.violation;
  return maximise ? a.objective > b.objective : a.objective < b.objective;
}

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
  if (record.ok && record.violation <= feasible_within_ &&
      (!progress_.best ||
       (maximise_ ? record.objective > *progress_.best : record.objective < *progress_.best)))
    progress_.best = record.objective;
  if (callback_) callback_(record, progress_);
}

VectorXd flattened(const DesignValues& values) {
  Eigen::Index size = 0;
  for (const GoalValues& g : values.goals) size += static_cast<Eigen::Index>(g.size());
  VectorXd flat(size);
  Eigen::Index k = 0;
  for (const GoalValues& g : values.goals)
    for (const double v : g) flat[k++] = v;
  return flat;
}

void EvaluationBook::set_scales(Scales scales) {
  scales_ = std::move(scales);
  for (LoggedEvaluation& e : evaluations_)
    if (e.record.ok) e.record.violation = problem_.violation(e.values, scales_);
}

LoggedEvaluation EvaluationBook::record(const Variables& variables, DesignValues values,
                                        bool difference, int number) const {
  LoggedEvaluation e;
  e.record.start = start_;
  e.record.number = number;
  e.record.variables = problem_.named(variables);
  e.record.ok = values.ok;
  e.record.message = values.message;
  e.record.difference = difference;
  if (values.ok) {
    e.record.objective = problem_.objective(values);
    e.record.constraints = problem_.constraints(values);
    e.record.violation = problem_.violation(values, scales_);
  }
  e.values = std::move(values);
  return e;
}

std::vector<const DesignValues*> EvaluationBook::at(const std::vector<Variables>& many,
                                                    bool difference, int& cost) {
  std::vector<Variables> fresh;
  for (const Variables& v : many) {
    if (known_.contains(v) || std::find(fresh.begin(), fresh.end(), v) != fresh.end()) continue;
    if (auto why = problem_.ruled_out(v, scales_)) {
      known_[v] = {false, *why, {}};
      continue;
    }
    fresh.push_back(v);
  }
  const auto count = static_cast<int>(fresh.size()), first = static_cast<int>(evaluations_.size());
  std::vector<LoggedEvaluation> done(fresh.size());
  parallel_for(count, threads_, [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const DesignValues* logged = log_.find(fresh[k]);
    done[k] =
        record(fresh[k], logged ? *logged : problem_.evaluate(fresh[k]), difference, first + i);
    if (!logged) log_.append(done[k]);
    board_.add(done[k].record, logged != nullptr);
  });
  for (std::size_t k = 0; k < fresh.size(); ++k) {
    if (!done[k].record.ok) ++failures_;
    known_[fresh[k]] = done[k].values;
    evaluations_.push_back(std::move(done[k]));
  }
  cost += count;
  std::vector<const DesignValues*> answers;
  for (const Variables& v : many) answers.push_back(&known_.at(v));
  return answers;
}

const DesignValues& EvaluationBook::at(const Variables& variables, bool difference, int& cost) {
  return *at(std::vector<Variables>{variables}, difference, cost).front();
}

std::optional<MatrixXd> EvaluationBook::derivatives(const VectorXd& x, int& cost) {
  const Variables center = problem_.variables(x);
  if (const auto it = derivatives_.find(center); it != derivatives_.end()) return it->second;
  const DesignValues values = at(center, false, cost);
  if (!values.ok) return std::nullopt;
  DifferenceOptions options;
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
    for (const DesignValues* v : at(many, true, cost))
      answers.push_back(v->ok ? std::optional(flattened(*v)) : std::nullopt);
    return answers;
  };
  std::optional<MatrixXd> found = central_differences(evaluate, x, flattened(values), options);
  if (found) derivatives_[center] = *found;
  return found;
}

const LoggedEvaluation* EvaluationBook::best() const {
  const OptimiseSpec& spec = problem_.spec();
  const LoggedEvaluation* best = nullptr;
  for (const LoggedEvaluation& e : evaluations_)
    if (e.record.ok && !e.record.difference &&
        (!best ||
         better(e.record, best->record, spec.objective.maximise, 0.3 * spec.constraint_tolerance)))
      best = &e;
  return best;
}

}  // namespace flexopt
