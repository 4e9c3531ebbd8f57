#pragma once
// What a comparison with full accuracy returns, and its errors. Plain data.
#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "optim/compare/samples.hpp"

namespace flexopt {

/// What is compared at a stroke point.
struct ComparedPoint {
  double stroke = 0;  ///< [m or rad]
  bool converged = false;
  bool stable = true;     ///< with the drive held
  bool fallback = false;  ///< a leaf was evaluated at full accuracy instead of its own model
  double drive_load = 0;
  std::vector<double> other_drive_loads;  ///< of several drives, those after the first
  Vector3d displacement = Vector3d::Zero();
  std::array<std::optional<double>, 6> support_stiffness;
  std::vector<double> frequencies_free, frequencies_locked;
  std::optional<double> parasitic_frequency, max_stress;
};

/// One design with one model; a line of evaluations.jsonl.
struct ComparedPath {
  int design = 0;
  int model = 0;                ///< 0: full accuracy; then the job's models from 1
  std::string message;          ///< why not every point was reached; empty otherwise
  std::string fallback_reason;  ///< of the first point that has one
  std::vector<ComparedPoint> points;

  int converged() const;
  int fallbacks() const;
  bool whole() const { return message.empty(); }
};

/// What the clock says of one evaluation [s].
struct EvaluationSeconds {
  double path = 0;   ///< along the stroke, coefficients ready
  double total = 0;  ///< with building the mechanism and the leaves' coefficients
};

ComparedPath compared_path(int design, int model, const StrokeResponse& response);
/// Where not even a mechanism could be made.
ComparedPath failed_path(int design, int model, std::string message);

enum class Compared {
  drive_load,
  support_stiffness,
  displacement,
  frequencies,
  parasitic_frequency,
  max_stress
};
inline constexpr std::array<const char*, 6> compared_names{
    "drive_load",  "support_stiffness",   "displacement",
    "frequencies", "parasitic_frequency", "max_stress"};
inline constexpr int index(Compared quantity) { return static_cast<int>(quantity); }

/// One number's relative error, ≥ 0.
struct PointError {
  Compared quantity = Compared::drive_load;
  int direction = -1;  ///< of a support stiffness
  int design = 0, point = 0;
  double value = 0;
};

/// Errors of all numbers at all points that both reached:
///     |model − full| / max(|full|, 1e-6 of the path's largest |full|),
/// displacement: |u − u_full| / the path's largest |u_full|. Where both are below that floor, as
/// the drive load of the undeflected guide is, there is nothing to compare and no entry.
std::vector<PointError> errors_of(const ComparedPath& model, const ComparedPath& full);

struct ErrorFigures {
  int count = 0;               ///< of compared numbers
  double worst = 0;            ///< the largest
  double p99 = 0, median = 0;  ///< percentiles, linear between the sorted values
  int worst_design = 0, worst_point = 0;
};

/// Of the errors of one quantity, of one direction where it is given; nothing where there are none.
std::optional<ErrorFigures> error_figures(const std::vector<PointError>& errors, Compared quantity,
                                          std::optional<int> direction = {});

/// One design with one of the job's models.
struct ModelDesign {
  bool failed = false;  ///< fewer points than full accuracy
  std::string message, fallback_reason;
  int points = 0, fallback_points = 0;  ///< reached; of these with a leaf at full accuracy
};

struct ModelComparison {
  std::string name;
  int failures = 0;
  int fallback_designs = 0, fallback_points = 0;
  /// Seconds at full accuracy / seconds of this model, over the designs that both finished: along
  /// the stroke with coefficients ready, and of the whole evaluation.
  std::optional<double> speed_up, speed_up_with_reduction;
  std::vector<ModelDesign> designs;
  std::vector<PointError> errors;
};

struct ComparedDesign {
  Sample sample;
  bool failed = false;  ///< full accuracy did not reach every point
  std::string message;
  int points = 0, unstable_points = 0;  ///< reached at full accuracy
  /// Of the leaf with the largest width²/(length thickness).
  double length_over_width = 0, thickness_over_length = 0, width2_over_length_thickness = 0;
};

struct Comparison {
  int failed_designs = 0;
  int evaluated = 0, evaluations = 0;  ///< design and model pairs known so far; of how many
  std::vector<ComparedDesign> designs;
  std::vector<ModelComparison> models;
};

/// From the paths known (all, or those of an interrupted run) and their seconds, both by
/// design × (models + 1) + model.
Comparison make_comparison(const Job& job, const std::vector<std::optional<ComparedPath>>& paths,
                           const std::vector<std::optional<EvaluationSeconds>>& seconds);

}  // namespace flexopt
