#include "core/response/accuracy/model_choice.hpp"

#include <fmt/format.h>

#include <cctype>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

namespace flexopt {
namespace {

/// Paths of one mechanism by many models, each evaluated once.
class Paths {
 public:
  Paths(const Mechanism& mechanism, const ModelOptions& model,
        const std::vector<StrokeRequest>& requests)
      : mechanism_(&mechanism), model_(&model) {
    for (const StrokeRequest& request : requests) requests_.push_back(estimate_request(request));
  }

  std::size_t requests() const { return requests_.size(); }

  ModelOptions options(Accuracy accuracy, const std::array<int, 2>& mesh) const {
    ModelOptions options = *model_;
    options.accuracy = accuracy;
    if (mesh != model_->mesh) options.atlas = nullptr;  // it has leaves of one mesh
    options.mesh = mesh;
    return options;
  }

  using Path = std::shared_ptr<const StrokeResponse>;
  Path get(Accuracy accuracy, const std::array<int, 2>& mesh, std::size_t k) {
    Path& path = paths_[{accuracy, mesh, k}];
    if (!path)
      path = std::make_shared<const StrokeResponse>(
          evaluate_stroke(*mechanism_, options(accuracy, mesh), requests_[k]));
    return path;
  }

  KeptFullPaths full(const std::array<int, 2>& mesh, std::size_t k, bool across) {
    return {get(Accuracy::full, mesh, k), get(Accuracy::full, more_along(mesh), k),
            across ? get(Accuracy::full, more_across(mesh), k) : nullptr, mesh,
            longest_leaf(*mechanism_)};
  }

 private:
  struct Key {
    Accuracy accuracy;
    std::array<int, 2> mesh;
    std::size_t request;
    auto operator<=>(const Key&) const = default;
  };
  const Mechanism* mechanism_;
  const ModelOptions* model_;
  std::vector<StrokeRequest> requests_;
  std::map<Key, Path> paths_;
};

/// Errors of a model over all requests.
TriedModel tried_model(Paths& paths, Accuracy accuracy, const std::array<int, 2>& mesh,
                       bool across) {
  TriedModel tried{accuracy, mesh, {}, {}};
  std::vector<StrokeErrors> all;
  for (std::size_t k = 0; k < paths.requests(); ++k) {
    const StrokeResponse& response = *paths.get(accuracy, mesh, k);
    StrokeErrors errors = errors_of(response, paths.full(mesh, k, across).view());
    if (response.status != Status::ok && tried.message.empty()) tried.message = response.message;
    if (!errors.message.empty() && tried.message.empty()) tried.message = errors.message;
    all.push_back(std::move(errors));
  }
  if (auto largest = largest_error(all, false)) tried.largest = std::move(*largest);
  return tried;
}

std::string message_of(const ChosenModel& chosen, double tolerance) {
  const TriedModel& last = chosen.tried.back();
  if (!last.message.empty())
    return fmt::format("No errors are known of {}: {}", words_for(last.accuracy, last.mesh),
                       last.message);
  std::string text = fmt::format(
      "{}: the largest estimated error is {}, of {} at stroke point {}; the tolerance is {}",
      words_for(last.accuracy, last.mesh), percent(last.largest.relative), last.largest.name,
      last.largest.point, percent(tolerance));
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  if (!chosen.met)
    text += ", and no mesh that is tried meets it";
  else if (chosen.tried.size() > 1)
    text += fmt::format(", which {} missed with {}",
                        words_for(chosen.tried[chosen.tried.size() - 2].accuracy,
                                  chosen.tried[chosen.tried.size() - 2].mesh),
                        percent(chosen.tried[chosen.tried.size() - 2].largest.relative));
  return text + ".";
}

}  // namespace

std::string percent(double share) {
  if (share < 0.995 || !std::isfinite(share)) return fmt::format("{:.2g} %", 100 * share);
  const double unit = std::pow(10, std::floor(std::log10(100 * share)) - 1);
  return fmt::format("{:.0f} %", unit * std::round(100 * share / unit));
}

std::string words_for(Accuracy accuracy, const std::array<int, 2>& mesh) {
  return fmt::format("{} leaves on {} x {} elements",
                     accuracy == Accuracy::full ? "full" : "reduced", mesh[0], mesh[1]);
}

ChosenModel choose_model(const Mechanism& mechanism, const ModelOptions& model,
                         const std::vector<StrokeRequest>& requests, double tolerance,
                         const std::function<void(const TriedModel&)>& told) {
  Paths paths(mechanism, model, requests);
  const bool across = has_elements_across(mechanism, model);
  ChosenModel chosen;
  Accuracy accuracy = model.accuracy;
  std::array<int, 2> mesh = model.mesh;
  for (;;) {
    const TriedModel& tried = chosen.tried.emplace_back(tried_model(paths, accuracy, mesh, across));
    if (told) told(tried);
    chosen.met = tried.message.empty() && tried.largest.relative <= tolerance;
    const LargestError& error = tried.largest;
    if (chosen.met || (accuracy == Accuracy::full && !tried.message.empty())) break;
    if (accuracy == Accuracy::reduced) {
      // the full paths of this mesh are known; more elements mend no errors of the reduction
      const TriedModel full = tried_model(paths, Accuracy::full, mesh, across);
      if (!tried.message.empty() || error.reduction > tolerance ||
          (full.message.empty() && full.largest.relative <= tolerance)) {
        accuracy = Accuracy::full;
        continue;
      }
    }
    // what is left for each of two directions
    const bool along = error.along > 0.5 * tolerance, wider = error.across > 0.5 * tolerance;
    std::array<int, 2> next = mesh;
    if (along || error.along >= error.across) next = more_along(next);
    if (wider || error.across > error.along) next = more_across(next);
    if (next[0] > largest_mesh[0] || next[1] > largest_mesh[1]) break;
    mesh = next;
  }
  chosen.model = paths.options(accuracy, mesh);
  for (std::size_t k = 0; k < paths.requests(); ++k)
    chosen.full.push_back(paths.full(mesh, k, across));
  chosen.message = message_of(chosen, tolerance);
  return chosen;
}

}  // namespace flexopt
