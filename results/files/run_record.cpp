#include "results/files/result_parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <tuple>

#include "optim/job/job_numbers.hpp"

namespace flexopt {

namespace {

std::string plural(std::size_t count, const std::string& noun) {
  return fmt::format("{} {}{}", count, noun, count == 1 ? "" : "s");
}

/// Tells how many points are on the branch that bifurcates; empty if none is.
std::string other_branch_text(const std::vector<PathPoint>& path) {
  const auto other = [](const PathPoint& p) {
    return p.status == PointStatus::converged && p.other_branch;
  };
  const auto count = static_cast<std::size_t>(std::ranges::count_if(path, other));
  if (count == 0) return "";
  return fmt::format(" {} of {} {} on the stable branch that turns away, first point {}.", count,
                     plural(path.size(), "point"), count == 1 ? "is" : "are",
                     std::ranges::find_if(path, other) - path.begin());
}

/// Tells of stability: points that are unstable, changes on the way, points that left their branch.
std::string stability_text(const std::vector<PathPoint>& path, const Mechanism& mechanism,
                           const LoadCase& loads) {
  const auto unstable = static_cast<std::size_t>(std::ranges::count_if(
      path, [](const PathPoint& p) { return p.status == PointStatus::converged && !p.stable; }));
  std::string text;
  if (unstable > 0)
    text += fmt::format(" {} at {} of {}.", unstable_text(mechanism, loads), unstable,
                        plural(path.size(), "point"));
  const auto passed = std::ranges::find(path, true, &PathPoint::bifurcation_passed);
  if (passed != path.end() && !passed->message.empty())
    text += fmt::format(" On the way {}.", passed->message);
  return text + other_branch_text(path);
}

/// Note for a run of reduced accuracy with derivatives: exact derivatives are those of full leaves
/// or of looked-up leaves.
std::string full_leaves_text(const std::vector<PathPoint>& path) {
  if (path.empty()) return "";
  const std::vector<LeafReport>& leaves = path.back().leaves;
  const auto count =
      static_cast<std::size_t>(std::ranges::count(leaves, "full", &LeafReport::model));
  if (count == 0) return "";
  return fmt::format(
      " With derivatives {} of {} full.", count,
      leaves.size() == 1 ? "1 leaf is" : fmt::format("{} leaves are", leaves.size()));
}

/// Elastic bodies whose models leave out what begins to count, each where it is bent most.
std::string elastic_text(const std::vector<PathPoint>& path, const Mechanism& mechanism) {
  std::string text;
  for (std::size_t k = 0; k < mechanism.elastic_bodies.size(); ++k) {
    const ElasticBody& body = mechanism.elastic_bodies[k];
    double turn = 0, share = 0, error = 0;
    for (const PathPoint& point : path)
      if (k < point.elastic_bodies.size()) {
        turn = std::max(turn, point.elastic_bodies[k].turn);
        share = std::max(share, point.elastic_bodies[k].geometric_share.value_or(0));
        error = std::max(error, point.elastic_bodies[k].degree_error);
      }
    if (constexpr double largest_turn = 0.02;  // [rad], where no share is known
        body.imported && turn > largest_turn)
      text += fmt::format(
          " An interface of {} turns by {:.3g} rad in the body: imported matrices are believed up "
          "to {:g} rad.",
          body.name, turn, largest_turn);
    if (constexpr double negligible = 0.01; error > negligible)
      text += fmt::format(
          " By what degree {} leaves out of the energy of {} a stiffness is off by up to {:.2g} %.",
          static_cast<int>(body.degree), body.name, 100 * error);
    if (constexpr double negligible = 0.1;
        body.degree == ElasticDegree::linear && share > negligible)
      text += fmt::format(
          " Motions of second order in {}, as parasitic ones may be, are left out by degree 2.",
          body.name);
  }
  return text;
}

/// Status and message of one path.
std::pair<std::string, std::string> conclusion(const StrokeResponse& response, Accuracy accuracy,
                                               const Mechanism& mechanism, const LoadCase& loads) {
  const auto& path = response.path;
  const auto converged = static_cast<std::size_t>(std::ranges::count(
      path, PointStatus::converged, [](const PathPoint& point) { return point.status; }));
  if (response.status == Status::ok && converged == path.size()) {
    const std::string& why = response.no_frequency_derivatives;
    return {"ok",
            fmt::format("Equilibrium found at {}, {} accuracy{}.{}",
                        plural(path.size(), "stroke point"), name_of(accuracy),
                        why.empty() ? "" : "; no frequency derivatives: " + why,
                        stability_text(path, mechanism, loads) + elastic_text(path, mechanism))};
  }
  const char* status = response.status == Status::limit_reached ? "limit_reached"
                       : response.status == Status::left_branch ? "left_branch"
                                                                : "no_equilibrium";
  if (!response.message.empty()) return {status, response.message + "."};
  return {status,
          fmt::format("{} of {} converged.", converged, plural(path.size(), "stroke point"))};
}

void conclude_evaluation(RunRecord& record) {
  const Accuracy accuracy = record.job.model.accuracy;
  const bool differentiated = accuracy == Accuracy::reduced && !record.gradients.empty();
  if (record.cases.empty()) {
    std::tie(record.status, record.message) =
        conclusion(record.response, accuracy, record.mechanism, record.job.request.loads);
    if (differentiated && record.status == "ok")
      record.message += full_leaves_text(record.response.path);
    return;
  }
  std::size_t points = 0;
  record.status = "ok";
  for (std::size_t k = 0; k < record.cases.size(); ++k) {
    const auto [status, message] =
        conclusion(record.cases[k], accuracy, record.mechanism, record.job.cases[k].request.loads);
    points += record.cases[k].path.size();
    if (status == "ok") continue;
    record.status = status;
    record.message += fmt::format("{}Load case {}: {}", record.message.empty() ? "" : " ",
                                  record.job.cases[k].name, message);
  }
  if (record.status != "ok") return;
  record.message =
      fmt::format("Equilibrium found at {} in {} load cases, {} accuracy.",
                  plural(points, "stroke point"), record.cases.size(), name_of(accuracy));
  for (std::size_t k = 0; k < record.cases.size(); ++k)
    if (const std::string text = stability_text(record.cases[k].path, record.mechanism,
                                                record.job.cases[k].request.loads) +
                                 elastic_text(record.cases[k].path, record.mechanism);
        !text.empty())
      record.message += fmt::format(" Load case {}:{}", record.job.cases[k].name, text);
  if (differentiated) record.message += full_leaves_text(record.cases.front().path);
}

void conclude_optimisation(RunRecord& record) {
  const Optimum& optimum = *record.optimum;
  constexpr std::array<std::pair<const char*, const char*>, 5> verdicts{
      {{"ok", "A feasible optimum was found"},
       {"ok", "A feasible optimum was found, perhaps not the best one,"},
       {"not_converged", "The best design is feasible but the search had not converged"},
       {"infeasible", "No design met every constraint; the least violating one is given"},
       {"failed", "No design could be evaluated"}}};
  const auto& [status, verdict] = verdicts[static_cast<std::size_t>(optimum.status)];
  record.status = status;
  record.message = fmt::format("{} in {}", verdict,
                               plural(static_cast<std::size_t>(optimum.evaluations), "evaluation"));
  if (optimum.failed_evaluations > 0)
    record.message += fmt::format(" ({} failed)", optimum.failed_evaluations);
  if (optimum.screening)
    record.message += fmt::format(", after {} screened designs ({} feasible, {} clusters)",
                                  optimum.screening->designs, optimum.screening->feasible,
                                  optimum.screening->clusters);
  if (optimum.screening && optimum.agreeing_starts > 0)
    record.message += fmt::format(", from {} of {} clusters searched", optimum.agreeing_starts,
                                  optimum.starts.size());
  record.message += optimum.stop_reason.empty() ? "." : "; " + optimum.stop_reason;
  if (optimum.verified && optimum.verified->outcome().status != Status::ok) {
    if (record.status == "ok") record.status = "not_verified";
    record.message +=
        " At full accuracy it has no equilibrium: " + optimum.verified->outcome().message;
  }
  const auto responses = responses_of(record);
  for (std::size_t k = 0; k < responses.size(); ++k)
    if (const std::string text = elastic_text(responses[k]->path, record.mechanism); !text.empty())
      record.message += (record.message.ends_with('.') ? "" : ".") +
                        (record.job.cases.empty()
                             ? text
                             : fmt::format(" Load case {}:{}", record.job.cases[k].name, text));
}

void conclude_comparison(RunRecord& record) {
  const Comparison& comparison = *record.comparison;
  int failures = 0, fallbacks = 0;
  bool compared = false;
  const bool whole =
      comparison.failed_designs < static_cast<int>(comparison.designs.size());  // one at least
  for (const ModelComparison& model : comparison.models) {
    failures += model.failures;
    fallbacks += model.fallback_designs;
    compared = compared || (whole && !model.errors.empty());
  }
  record.status = compared ? "ok" : "failed";
  record.message = compared ? fmt::format("{} compared with full accuracy over {}",
                                          plural(comparison.models.size(), "model"),
                                          plural(comparison.designs.size(), "design"))
                            : fmt::format("None of {} could be compared to its end",
                                          plural(comparison.designs.size(), "design"));
  if (comparison.failed_designs > 0)
    record.message +=
        fmt::format("; {} not to the end at full accuracy",
                    plural(static_cast<std::size_t>(comparison.failed_designs), "design"));
  if (failures > 0)
    record.message += fmt::format("; the models failed {} on their own",
                                  failures == 1 ? "once" : fmt::format("{} times", failures));
  if (fallbacks > 0)
    record.message += fmt::format("; {} with leaves evaluated at full accuracy instead",
                                  plural(static_cast<std::size_t>(fallbacks), "path"));
  for (const ComparedDesign& design : comparison.designs)
    if (!compared && !design.message.empty()) {
      record.message += ": " + design.message;
      break;
    }
  record.message += ".";
}

/// What the estimated errors add.
void conclude_errors(RunRecord& record) {
  const auto numbers = largest_error(record.errors, false);
  const auto stresses = largest_error(record.errors, true);
  if (!record.message.ends_with('.')) record.message += '.';
  if (record.status != "ok" && !record.optimum) return;  // what failed is the news
  if (record.chosen) record.message += " Chosen: " + record.chosen->message;
  if (numbers && (!record.chosen || record.optimum))  // the optimum is another design
    record.message += fmt::format(" The largest estimated error {}is {}, of {}.",
                                  record.optimum ? "of the optimum " : "",
                                  percent(numbers->relative), numbers->name);
  if (record.chosen && !meets_tolerance(record) && record.status == "ok")
    record.status = "tolerance_not_met";
  const auto judge = [&record](const std::optional<LargestError>& error, double limit) {
    if (!error || error->relative <= limit || record.status != "ok") return;
    record.status = "estimate_beyond_limit";
    record.message += fmt::format(
        " Not believed: by its estimated error {} at stroke point {} may be off by {}; the limit "
        "is {}.",
        error->name, error->point, percent(error->relative), percent(limit));
  };
  constexpr double of_stresses = 10;  // their estimates are rough
  judge(numbers, record.job.accuracy.largest);
  judge(stresses, of_stresses * record.job.accuracy.largest);
  if (const auto decisive = decisive_stress_error(record.errors))
    record.message += fmt::format(
        " {} is within {} where it decides, at {}.", decisive->name, percent(decisive->relative()),
        quantity_text(decisive->value, quantity_unit(decisive->name, drives_of(record)), 3));
  for (const StrokeErrors& errors : record.errors)
    if (!errors.message.empty()) {
      record.message += fmt::format(" No errors are known of some points: {}.", errors.message);
      break;
    }
}

}  // namespace

bool meets_tolerance(const RunRecord& record) {
  const auto largest = largest_error(record.errors, false);
  return record.chosen && record.chosen->met && largest &&
         largest->relative <= record.job.accuracy.tolerance;
}

void conclude(RunRecord& record) {
  if (record.comparison)
    conclude_comparison(record);
  else if (record.optimum)
    conclude_optimisation(record);
  else
    conclude_evaluation(record);
  if (!record.errors.empty()) conclude_errors(record);
}

std::vector<const StrokeResponse*> responses_of(const RunRecord& record) {
  const std::vector<StrokeResponse>& cases = record.optimum ? record.optimum->cases : record.cases;
  if (record.job.cases.empty()) return {&response_of(record)};
  std::vector<const StrokeResponse*> all;
  for (const StrokeResponse& one : cases) all.push_back(&one);
  return all;
}

DriveList drives_of(const RunRecord& record) { return drives_of(record.job, record.mechanism); }

const StrokeResponse& response_of(const RunRecord& record) {
  return record.optimum ? record.optimum->response : record.response;
}

std::pair<std::string, std::string> conclusion_of_case(const RunRecord& record, std::size_t k) {
  return conclusion(*responses_of(record)[k], record.job.model.accuracy, record.mechanism,
                    cases_of(record.job)[k].request.loads);
}

std::string name_of(Accuracy accuracy) {
  return accuracy == Accuracy::reduced ? "reduced" : "full";
}

std::string name_of(PointStatus status) {
  constexpr std::array names{"converged", "no_equilibrium", "left_branch", "not_reached",
                             "limit_reached"};
  return names[static_cast<std::size_t>(status)];
}

std::string name_of(ModeKind kind) {
  constexpr std::array names{"drive", "end_effector", "intermediate_body", "leaf"};
  return names[static_cast<std::size_t>(kind)];
}

std::string name_of(OptimumStatus status) {
  constexpr std::array names{"optimal", "local", "feasible", "infeasible", "failed"};
  return names[static_cast<std::size_t>(status)];
}

}  // namespace flexopt
