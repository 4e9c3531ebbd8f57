#include "core/response/path/model_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <map>
#include <memory>
#include <set>
#include <utility>

namespace flexopt {
namespace {

/// Paths of one mechanism by many models, each evaluated once.
class Paths {
 public:
  Paths(const Mechanism& mechanism, const ModelOptions& model,
        const std::vector<StrokeRequest>& requests)
      : mechanism_(&mechanism),
        model_(&model),
        across_(has_elements_across(mechanism, model)),
        scale_(scale_of(mechanism, model)) {
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
  Path get(Accuracy accuracy, const std::array<int, 2>& mesh, std::size_t k, bool coarse = false) {
    Path& path = paths_[{accuracy, mesh, k, coarse}];
    if (!path) {
      path = std::make_shared<const StrokeResponse>(
          evaluate_stroke(coarse ? *coarse_ : *mechanism_, options(accuracy, mesh), requests_[k]));
      cost_ += cost_of(mesh) / static_cast<double>(requests());
    }
    return path;
  }

  /// The paths that tell the errors of a model on this mesh.
  FullPaths full(Accuracy accuracy, const std::array<int, 2>& mesh, std::size_t k) {
    return {get(Accuracy::full, mesh, k),
            get(Accuracy::full, more_along(mesh), k),
            across_ ? get(Accuracy::full, more_across(mesh), k) : nullptr,
            coarse_ ? get(accuracy, mesh, k, true) : nullptr,
            mesh,
            scale_};
  }

  double cost() const { return cost_; }
  /// What trying a model costs beyond what is known already.
  double cost_to_try(Accuracy accuracy, const std::array<int, 2>& mesh) const {
    std::set<std::pair<Accuracy, std::array<int, 2>>> wanted{
        {accuracy, mesh}, {Accuracy::full, mesh}, {Accuracy::full, more_along(mesh)}};
    if (across_) wanted.insert({Accuracy::full, more_across(mesh)});
    double cost = 0;
    for (const auto& [of, on] : wanted)
      if (!paths_.contains({of, on, 0, false})) cost += cost_of(on);
    return cost;
  }

 private:
  struct Key {
    Accuracy accuracy;
    std::array<int, 2> mesh;
    std::size_t request;
    bool coarse;
    auto operator<=>(const Key&) const = default;
  };
  double cost_of(const std::array<int, 2>& mesh) const {
    const double along = static_cast<double>(mesh[0]) / model_->mesh[0],
                 across = (mesh[1] + 1.0) / (model_->mesh[1] + 1.0);
    return across_ ? along * across * across : along;
  }

  const Mechanism* mechanism_;
  std::optional<Mechanism> coarse_ = with_coarse_bodies(*mechanism_);
  const ModelOptions* model_;
  bool across_;
  MechanismScale scale_;
  double cost_ = 0;
  std::vector<StrokeRequest> requests_;
  std::map<Key, Path> paths_;
};

/// Errors of a model over all requests, and what `tried` tells of them.
std::vector<StrokeErrors> errors_by(Paths& paths, Accuracy accuracy, const std::array<int, 2>& mesh,
                                    TriedModel& tried) {
  tried = {accuracy, mesh, {}, {}};
  std::vector<StrokeErrors> all;
  for (std::size_t k = 0; k < paths.requests(); ++k) {
    const StrokeResponse& response = *paths.get(accuracy, mesh, k);
    StrokeErrors errors = errors_of(response, paths.full(accuracy, mesh, k));
    if (response.status != Status::ok && tried.message.empty()) tried.message = response.message;
    if (!errors.message.empty() && tried.message.empty()) tried.message = errors.message;
    all.push_back(std::move(errors));
  }
  if (auto largest = largest_error(all, false)) tried.largest = std::move(*largest);
  return all;
}

/// Numbers, by request and name.
using Numbers = std::set<std::pair<std::size_t, std::string>>;

/// The largest error that a finer mesh can reduce.
LargestError largest_but(std::vector<StrokeErrors> errors, const Numbers& aside) {
  for (std::size_t k = 0; k < errors.size(); ++k)
    for (std::vector<EstimatedError>& point : errors[k].path)
      std::erase_if(point, [&](const EstimatedError& number) {
        return aside.contains({k, number.name});
      });
  return largest_error(errors, false).value_or(LargestError{});
}

/// Adds the errors beyond the tolerance that a finer mesh of leaves does not reduce: those of the
/// theory and of elastic bodies, and those along or across that stayed as they were when there were
/// more elements.
void add_unreachable(const std::vector<StrokeErrors>& errors, double tolerance,
                     const std::vector<StrokeErrors>& before, bool along, bool across,
                     Numbers& numbers) {
  constexpr double as_before = 0.9;  // errors of second order fall to a half
  for (std::size_t k = 0; k < errors.size(); ++k)
    for (std::size_t p = 0; p < errors[k].path.size(); ++p)
      for (const EstimatedError& number : errors[k].path[p]) {
        if (number.kind == ErrorKind::stress || number.relative() <= tolerance) continue;
        const EstimatedError* old = before.empty() ? nullptr : before[k].find(p, number.name);
        const auto stays = [&](double EstimatedError::*part) {
          return old && number.*part > 0.5 * tolerance * number.scale &&
                 number.*part > as_before * old->*part;
        };
        if (number.theory + number.solids > tolerance * number.scale ||
            (along && stays(&EstimatedError::along)) || (across && stays(&EstimatedError::across)))
          numbers.insert({k, number.name});
      }
}

/// Number of elements for which an error of second order falls to `wanted`: at least a fifth more,
/// at most twice as many.
int enough(int elements, double error, double wanted) {
  return static_cast<int>(std::ceil(elements * std::clamp(std::sqrt(error / wanted), 1.2, 2.0)));
}

/// The mesh that is expected to be fine enough, or else one of √2 times the elements, or why
/// neither may be tried.
Answer<std::array<int, 2>> next_mesh(const Paths& paths, Accuracy accuracy,
                                     const std::array<int, 2>& mesh, const LargestError& error,
                                     double tolerance) {
  const double wanted = 0.5 * tolerance;  // what is left for each of two directions
  std::array<int, 2> expected = mesh, next = mesh;
  if (error.along > wanted || error.along >= error.across) {
    expected[0] = enough(mesh[0], error.along, wanted);
    next = more_along(next);
  }
  if (error.across > wanted || error.across > error.along) {
    expected[1] = enough(mesh[1], error.across, wanted);
    next = more_across(next);
  }
  const auto fits = [](const std::array<int, 2>& of) {
    return of[0] <= largest_mesh[0] && of[1] <= largest_mesh[1];
  };
  const auto affordable = [&](const std::array<int, 2>& of) {
    return paths.cost() + paths.cost_to_try(accuracy, of) <= largest_cost;
  };
  for (const std::array<int, 2>& of : {expected, next})
    if (fits(of) && affordable(of)) return of;
  return Because(fits(next) ? fmt::format("with the next one the choice would cost more than {:g} "
                                          "evaluations of full leaves on the job's mesh",
                                          largest_cost)
                            : fmt::format("the largest has {} x {} elements", largest_mesh[0],
                                          largest_mesh[1]));
}

std::string message_of(const ChosenModel& chosen, const std::vector<StrokeErrors>& errors,
                       const std::string& why, double tolerance) {
  const TriedModel& last = chosen.tried.back();
  if (!last.message.empty())
    return fmt::format("No errors are known of {}: {}", words_for(last.accuracy, last.mesh),
                       last.message);
  std::string text = fmt::format(
      "{}: the largest estimated error is {}, of {} at stroke point {}; the tolerance is {}",
      words_for(last.accuracy, last.mesh), percent(last.largest.relative), last.largest.name,
      last.largest.point, percent(tolerance));
  text[0] = static_cast<char>(std::toupper(static_cast<unsigned char>(text[0])));
  if (!chosen.met) {
    text += ", and no mesh that is tried meets it: " + why + ". Beyond it are ";
    const std::vector<LargestError> beyond = errors_beyond(errors, tolerance);
    constexpr std::size_t named = 4;
    for (std::size_t k = 0; k < std::min(named, beyond.size()); ++k)
      text +=
          fmt::format("{}{} ({})", k > 0 ? ", " : "", beyond[k].name, percent(beyond[k].relative));
    if (beyond.size() > named) text += fmt::format(" and {} more", beyond.size() - named);
    text += "; all others are within it";
  } else if (chosen.tried.size() > 1) {
    text += fmt::format(", which {} missed with {}",
                        words_for(chosen.tried[chosen.tried.size() - 2].accuracy,
                                  chosen.tried[chosen.tried.size() - 2].mesh),
                        percent(chosen.tried[chosen.tried.size() - 2].largest.relative));
  }
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
  ChosenModel chosen;
  Accuracy accuracy = model.accuracy;
  std::array<int, 2> mesh = model.mesh;
  std::vector<StrokeErrors> errors, coarser;  // those of the mesh before
  std::array<int, 2> coarser_mesh = mesh;
  Numbers aside;
  std::string why;
  for (;;) {
    errors = errors_by(paths, accuracy, mesh, chosen.tried.emplace_back());
    const TriedModel tried = chosen.tried.back();
    if (told) told(tried);
    chosen.met = tried.message.empty() && tried.largest.relative <= tolerance;
    if (chosen.met) break;
    if (accuracy == Accuracy::reduced) {  // the full paths of this mesh are known
      TriedModel full;
      errors_by(paths, Accuracy::full, mesh, full);
      if (!tried.message.empty() || tried.largest.reduction > tolerance ||
          (full.message.empty() && full.largest.relative <= tolerance)) {
        accuracy = Accuracy::full;
        continue;
      }
    } else if (!tried.message.empty()) {
      break;
    }
    add_unreachable(errors, tolerance, coarser, mesh[0] > coarser_mesh[0],
                    mesh[1] > coarser_mesh[1], aside);
    const LargestError error = largest_but(errors, aside);
    if (error.relative <= tolerance) {
      why = "more elements do not lessen these errors";
      ModelOptions beams = model;
      beams.flexure = Flexure::beam;  // folded leaves are plates all the same
      if (narrow_plate_error(mechanism, model) > tolerance &&
          narrow_plate_error(mechanism, beams) <= tolerance)
        why += ", which are those of plates in narrow leaves; take beams (\"flexure\": \"beam\")";
      break;
    }
    const auto next = next_mesh(paths, accuracy, mesh, error, tolerance);
    why = why_not(next);
    if (!next) break;
    coarser = std::move(errors);
    coarser_mesh = mesh;
    mesh = *next;
  }
  chosen.model = paths.options(accuracy, mesh);
  for (std::size_t k = 0; k < paths.requests(); ++k)
    chosen.full.push_back(paths.full(accuracy, mesh, k));
  chosen.cost = paths.cost();
  chosen.message = message_of(chosen, errors, why, tolerance);
  return chosen;
}

}  // namespace flexopt
