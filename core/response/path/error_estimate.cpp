#include "core/response/path/error_estimate.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <utility>

#include "core/mechanism/drive.hpp"
#include "core/response/quantities.hpp"

namespace flexopt {
namespace {

/// How the differences between meshes become an error of each kind. Fitted to sampled designs of
/// ten families; tests/benchmarks/estimates.cpp checks it on others.
struct ErrorLaw {
  double safety = 0;  ///< error over what the differences say to second order
  double path = 0;    ///< share of the differences of the same number along the path
  double point = 0;   ///< share of those of the other numbers of the kind at the same point
};

ErrorLaw law_of(ErrorKind kind) {
  switch (kind) {
    case ErrorKind::load:
      return {.safety = 1.9, .path = 0.6, .point = 0.7};
    case ErrorKind::stiffness:
      return {.safety = 1.8, .path = 0, .point = 0.3};
    case ErrorKind::motion:
      return {.safety = 1.7, .path = 0, .point = 0};
    case ErrorKind::frequency:
      return {.safety = 2.1, .path = 0, .point = 0.3};
    case ErrorKind::stress:
      return {.safety = 2.2, .path = 0.6, .point = 0.2};
    case ErrorKind::none:
      break;
  }
  return {};
}

// The lowest order of convergence in docs/benchmarks.md.
constexpr double order = 2;
// Errors are relative to the number, and to at least this share of the path's largest value.
constexpr double least_share = 1e-3;
// What Newton's tolerance leaves of numbers that are zero, as a share of the least reference value.
constexpr double newton_remainder = 1e-4;

/// Error of a mesh over its difference from one of `ratio` times the elements:
/// 1/(1 − ratio^−order).                                                                      (S26)
double error_over_difference(int elements, int more) {
  const double ratio = static_cast<double>(more) / elements;
  return 1 / (1 - std::pow(ratio, -order));
}

/// Error of elastic bodies over the difference from their coarse twins, of 1.6 times the sizes.
/// Stress is singular at the rims of rigid patches and at sharp corners, by the root of the
/// distance, which is of order 1 in the energy: 1/(1.6 − 1). Counts of elements are whole, so that
/// the twin may differ by less: of thin frames and notches errors up to 4.3 times the difference
/// were seen, of stresses up to 5.
double solids_over_difference(ErrorKind kind) { return kind == ErrorKind::stress ? 5.5 : 4.5; }

/// What the theory is off by: drives bend leaves, all other loads may stretch, shear and twist
/// them. (S33), (S36)
double error_of(const EstimatedError& number, const ProfileError& theory) {
  if (number.kind == ErrorKind::load || number.kind == ErrorKind::stress) return theory.bending;
  if (number.kind == ErrorKind::frequency) return 0.5 * theory.rotation;
  if (number.kind != ErrorKind::stiffness) return 0;
  if (number.name.starts_with("drive_stiffness")) return theory.bending;
  return number.name.find(".r") != std::string::npos ? theory.rotation : theory.translation;
}

std::string load_name(const std::string& drive) {
  return drive.empty() ? "drive_load" : "drive_load." + drive;
}

constexpr const char* displacements = "displacement";
constexpr const char* rotations = "rotation";

/// Numbers of one scale: the components of a vector share that of the vector.
std::string scale_key(const EstimatedError& number) {
  if (number.kind != ErrorKind::motion) return number.name;
  return number.name.substr(0, number.name.find('.'));
}

/// What the numbers of a path are relative to (after (S28)), and how far two evaluations of a
/// number that is zero are apart by rounding.
class Scales {
 public:
  Scales(const MechanismScale& mechanism, const std::vector<PathPoint>& path)
      : mechanism_(mechanism) {
    for (const PathPoint& point : path) {
      if (point.status != PointStatus::converged || point.strokes.empty()) continue;
      if (point.drive_names.empty()) driven(load_name(""), point.stroke);
      for (std::size_t k = 0; k < std::min(point.strokes.size(), point.drive_names.size()); ++k)
        driven(load_name(point.drive_names[k]), point.strokes[k]);
    }
  }

  void add(const EstimatedError& number) {
    double& of = largest_[scale_key(number)];
    of = std::max(of, std::abs(number.value));
  }

  /// `stiffness`: that of the drive of a load; of no meaning for other numbers.
  double scale(const EstimatedError& number, double stiffness) const {
    const std::string key = scale_key(number);
    if (number.kind == ErrorKind::motion)
      return key == displacements
                 ? std::max(largest(key), least_share * mechanism_.length * largest(rotations))
                 : std::max(largest(key), least_share * over_length(largest(displacements)));
    double of_motion = 0;
    if (number.kind == ErrorKind::load)
      of_motion = std::abs(stiffness) * (is_moment(number.name) ? over_length(moved()) : moved());
    return std::max(std::abs(number.value), least_share * std::max(largest(key), of_motion));
  }

  double rounding(const EstimatedError& number) const {
    constexpr double of_force = 1e-12, of_place = 1e-7;
    if (number.kind == ErrorKind::load)
      return of_force * mechanism_.force * (is_moment(number.name) ? mechanism_.length : 1);
    if (number.kind == ErrorKind::motion)
      return of_place * (scale_key(number) == displacements ? mechanism_.length : 1);
    const bool is_stress = number.kind == ErrorKind::stress && number.name.ends_with("_stress");
    return is_stress ? of_force * mechanism_.modulus : 0;
  }

 private:
  double largest(const std::string& key) const {
    const auto found = largest_.find(key);
    return found == largest_.end() ? 0 : found->second;
  }
  bool is_moment(const std::string& load) const { return mechanism_.moments.contains(load); }
  void driven(const std::string& load, double stroke) {
    driven_ = std::max(driven_, (is_moment(load) ? mechanism_.length : 1) * std::abs(stroke));
  }
  double over_length(double motion) const {
    return mechanism_.length > 0 ? motion / mechanism_.length : 0;
  }
  /// The largest motion of the path, angles times the longest leaf [m].
  double moved() const {
    return std::max({driven_, largest(displacements), mechanism_.length * largest(rotations)});
  }

  const MechanismScale& mechanism_;
  double driven_ = 0;
  std::map<std::string, double> largest_;
};

struct MeanSquare {
  double sum = 0;
  int count = 0;
  void add(double value) {
    sum += value * value;
    ++count;
  }
  double root() const { return count > 0 ? std::sqrt(sum / count) : 0; }
};

/// What the meshes say of all numbers of a path, relative.
class Differences {
 public:
  void add(const EstimatedError& number, std::size_t point) {
    const double size = (number.along + number.across) / number.scale;
    of_path_[number.name].add(size);
    of_point_[{point, number.kind}].add(size);
  }
  /// Error that is no smaller than a share of those around it, (S27). Where errors change their
  /// sign along the path, the difference of two meshes vanishes at another place than the error
  /// does.
  double smoothed(const EstimatedError& number, std::size_t point) const {
    constexpr double own = 3;  // what never differs along the path is exact
    const ErrorLaw law = law_of(number.kind);
    const double path = of_path_.at(number.name).root(),
                 beside = of_point_.at({point, number.kind}).root();
    return std::hypot((number.along + number.across) / number.scale, law.path * path,
                      std::min(law.point * beside, own * path));
  }

 private:
  std::map<std::string, MeanSquare> of_path_;
  std::map<std::pair<std::size_t, ErrorKind>, MeanSquare> of_point_;
};

using Values = std::map<std::string, double>;

bool is_converged(const StrokeResponse& response, std::size_t k) {
  return k < response.path.size() && response.path[k].status == PointStatus::converged;
}

Values values_of(const std::shared_ptr<const StrokeResponse>& response, std::size_t k) {
  Values values;
  if (!response || !is_converged(*response, k)) return values;
  for (const EstimatedError& number : estimated_numbers(response->path[k]))
    values[number.name] = number.value;
  return values;
}

/// The number's distances from the full leaves' values, each times what makes an error of it; false
/// where one of these is missing. Values up to `rounding` are zeros.
bool set_differences(const Values& own, const Values& along, const Values& across,
                     const Values& coarse, const FullPaths& full, double rounding,
                     EstimatedError& number) {
  const auto at = own.find(number.name), longer = along.find(number.name),
             wider = across.find(number.name), coarser = coarse.find(number.name);
  if (at == own.end() || longer == along.end() || (full.across && wider == across.end()) ||
      (full.coarse && coarser == coarse.end()))
    return false;
  const std::array<int, 2> next{more_along(full.mesh)[0], more_across(full.mesh)[1]};
  const auto difference = [&](double a, double b) {
    return std::max(std::abs(a), std::abs(b)) <= rounding ? 0 : std::abs(a - b);
  };
  number.reduction = difference(number.value, at->second);
  number.along =
      error_over_difference(full.mesh[0], next[0]) * difference(at->second, longer->second);
  if (full.across)
    number.across =
        error_over_difference(full.mesh[1], next[1]) * difference(at->second, wider->second);
  if (full.coarse)
    number.solids = solids_over_difference(number.kind) * difference(number.value, coarser->second);
  return true;
}

/// Stiffness of the drive whose load the number is; zero where the numbers do not have it.
double stiffness_of_drive(const Values& numbers, const EstimatedError& load) {
  if (load.kind != ErrorKind::load) return 0;
  const auto found = numbers.find("drive_stiffness" + load.name.substr(load_name("").size()));
  return found == numbers.end() ? 0 : found->second;
}

// Calls `visit` for every number of several paths, with what is said of it.
template <class Visit>
void each_error(const std::vector<StrokeErrors>& errors, const Visit& visit) {
  for (std::size_t path = 0; path < errors.size(); ++path)
    for (std::size_t k = 0; k < errors[path].path.size(); ++k)
      for (const EstimatedError& n : errors[path].path[k]) {
        if (n.scale == 0) continue;
        visit(n.kind,
              LargestError{n.name, path, k, n.relative(), n.along / n.scale, n.across / n.scale,
                           n.reduction / n.scale, n.theory / n.scale, n.solids / n.scale});
      }
}

}  // namespace

std::array<int, 2> more_along(const std::array<int, 2>& mesh) {
  return {static_cast<int>(std::lround(mesh[0] * std::numbers::sqrt2)), mesh[1]};
}

std::array<int, 2> more_across(const std::array<int, 2>& mesh) {
  return {mesh[0], static_cast<int>(std::lround(mesh[1] * std::numbers::sqrt2))};
}

Check has_estimates(const ModelOptions& model) {
  if (model.accuracy == Accuracy::full || model.method == Reduction::mixed_potential) return {};
  return Because("errors are estimated of full leaves and of \"method\": \"mixed_potential\"");
}

const EstimatedError* StrokeErrors::find(std::size_t point, const std::string& name) const {
  if (point >= path.size()) return nullptr;
  const auto found = std::ranges::find(path[point], name, &EstimatedError::name);
  return found == path[point].end() ? nullptr : &*found;
}

StrokeRequest estimate_request(StrokeRequest request) {
  request.outputs.remove({Output::frequency_derivatives, Output::envelope, Output::moving_envelope,
                          Output::clearance, Output::buckling, Output::stroke_capacity,
                          Output::state_space, Output::transfers, Output::gauges,
                          Output::stable_states, Output::shapes});
  request.values = PathValues::as_modelled;
  request.buckling_load.clear();
  return request;
}

StrokeErrors errors_of(const StrokeResponse& response, const FullPaths& full) {
  StrokeErrors errors;
  errors.path.resize(response.path.size());
  Scales scales(full.scale, response.path);
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    if (!is_converged(response, k)) continue;
    errors.path[k] = estimated_numbers(response.path[k]);
    for (const EstimatedError& number : errors.path[k]) scales.add(number);
  }
  Differences differences;
  for (std::size_t k = 0; k < response.path.size(); ++k) {
    if (errors.path[k].empty()) continue;
    const Values own = values_of(full.own, k), along = values_of(full.along, k),
                 across = values_of(full.across, k), coarse = values_of(full.coarse, k);
    if (own.empty() || along.empty() || (full.across && across.empty()) ||
        (full.coarse && coarse.empty())) {
      errors.path[k].clear();
      errors.message = fmt::format(
          "no equilibrium was found with full leaves on {} x {} elements or finer ones{}, from "
          "which errors are told",
          full.mesh[0], full.mesh[1], full.coarse ? ", or with coarser elastic bodies" : "");
      continue;
    }
    std::erase_if(errors.path[k], [&](EstimatedError& number) {
      return !set_differences(own, along, across, coarse, full, scales.rounding(number), number);
    });
    for (EstimatedError& number : errors.path[k]) {
      number.scale = scales.scale(number, stiffness_of_drive(own, number));
      if (number.scale > 0) differences.add(number, k);
    }
  }
  for (std::size_t k = 0; k < errors.path.size(); ++k)
    for (EstimatedError& number : errors.path[k]) {
      if (number.scale == 0) {
        number.along = number.across = number.reduction = number.solids = 0;
        continue;
      }
      const ErrorLaw law = law_of(number.kind);
      const double raw = (number.along + number.across) / number.scale;
      const bool vanishes =
          number.kind != ErrorKind::motion && std::abs(number.value) < number.scale;
      const double mesh = std::max(law.safety * differences.smoothed(number, k),  // (S28)
                                   vanishes ? newton_remainder : 0);
      const double share = raw > 0 ? number.across / (number.along + number.across) : 0;
      number.along = (1 - share) * mesh * number.scale;
      number.across = share * mesh * number.scale;
      number.theory = error_of(number, full.scale.theory) * number.scale;
    }
  return errors;
}

MechanismScale scale_of(const Mechanism& mechanism, const ModelOptions& model) {
  MechanismScale scale{.length = longest_leaf(mechanism), .theory = profile_error(mechanism)};
  const double narrow = narrow_plate_error(mechanism, model);
  for (double* error : {&scale.theory.bending, &scale.theory.translation, &scale.theory.rotation})
    *error += narrow;
  for (const LeafSpring& leaf : mechanism.leaves) {
    const double modulus = leaf.material.youngs_modulus;
    scale.modulus = std::max(scale.modulus, modulus);
    scale.force = std::max(scale.force, modulus * leaf.width * leaf.thickness);
  }
  const DriveList drives(mechanism);
  for (const DriveList::Item& drive : drives.items)
    if (is_rotation(drive.direction)) scale.moments.insert(load_name(drive.name));
  return scale;
}

bool has_elements_across(const Mechanism& mechanism, const ModelOptions& model) {
  return std::ranges::any_of(mechanism.leaves, [&](const LeafSpring& leaf) {
    return flexure_of(leaf, model) == Flexure::plate;
  });
}

StrokeErrors estimate_errors(const Mechanism& mechanism, const ModelOptions& model,
                             const StrokeRequest& request, const StrokeResponse& response) {
  const StrokeRequest asked = estimate_request(request);
  const auto with_mesh = [&](const std::array<int, 2>& mesh) {
    ModelOptions full = model;
    full.accuracy = Accuracy::full;
    full.mesh = mesh;
    return std::make_shared<const StrokeResponse>(evaluate_stroke(mechanism, full, asked));
  };
  FullPaths full{.mesh = model.mesh, .scale = scale_of(mechanism, model)};
  full.own = model.accuracy == Accuracy::reduced ? with_mesh(model.mesh)
                                                 : std::make_shared<const StrokeResponse>(response);
  full.along = with_mesh(more_along(model.mesh));
  if (has_elements_across(mechanism, model)) full.across = with_mesh(more_across(model.mesh));
  if (const auto coarse = with_coarse_bodies(mechanism))
    full.coarse = std::make_shared<const StrokeResponse>(evaluate_stroke(*coarse, model, asked));
  return errors_of(response, full);
}

std::optional<LargestError> largest_error(const std::vector<StrokeErrors>& errors,
                                          bool of_stresses) {
  std::optional<LargestError> largest;
  each_error(errors, [&](ErrorKind kind, LargestError error) {
    if ((kind == ErrorKind::stress) == of_stresses &&
        !(largest && error.relative <= largest->relative))
      largest = std::move(error);
  });
  return largest;
}

std::optional<EstimatedError> decisive_stress_error(const std::vector<StrokeErrors>& errors) {
  std::map<std::string, EstimatedError> decisive;  // the largest stress, the least safety
  for (const StrokeErrors& of : errors)
    for (const std::vector<EstimatedError>& point : of.path)
      for (const EstimatedError& n : point) {
        if (n.kind != ErrorKind::stress || n.scale == 0) continue;
        const auto [at, fresh] = decisive.try_emplace(n.name, n);
        const double more = std::abs(n.value) - std::abs(at->second.value);
        if (!fresh && (n.name.ends_with("_stress") ? more > 0 : more < 0)) at->second = n;
      }
  std::optional<EstimatedError> largest;
  for (const auto& [name, error] : decisive)
    if (!largest || error.relative() > largest->relative()) largest = error;
  return largest;
}

std::vector<LargestError> errors_beyond(const std::vector<StrokeErrors>& errors, double tolerance) {
  std::map<std::pair<std::size_t, std::string>, LargestError> beyond;
  each_error(errors, [&](ErrorKind kind, LargestError error) {
    if (kind == ErrorKind::stress || error.relative <= tolerance) return;
    LargestError& largest = beyond[{error.path, error.name}];
    if (error.relative > largest.relative) largest = std::move(error);
  });
  std::vector<LargestError> sorted;
  for (auto& [name, error] : beyond) sorted.push_back(std::move(error));
  std::ranges::stable_sort(sorted, std::greater{}, &LargestError::relative);
  return sorted;
}

}  // namespace flexopt
