#pragma once
// The designs of a job "compare".
#include <optional>
#include <string>
#include <vector>

#include "core/response/response.hpp"
#include "optim/job/compared_quantity.hpp"
#include "optim/job/job.hpp"

namespace flexopt {

struct Sample {
  ParameterValues parameters;  ///< all of the family's; only the sampled ones where `refused`
  ParameterValues symbols;     ///< sampled numbers that only formulas use
  std::vector<double> stroke;  ///< [m or rad]; of several load cases one after the other
  /// For several drives, the strokes of all of them, point by point; `stroke` holds those of the
  /// first.
  std::vector<VectorXd> strokes;
  std::string refused;  ///< why there is no such design; empty otherwise
};

/// The job's designs in their order. A design whose formulas have no value or leave a parameter's
/// range is refused in words, not left out.
std::vector<Sample> make_samples(const Job& job);

// What a comparison with full accuracy returns, and its errors. Plain data.

/// What is compared at a stroke point.
struct ComparedPoint {
  double stroke = 0;  ///< [m or rad]
  bool converged = false;
  bool stable = true;     ///< with the drive held
  bool fallback = false;  ///< a leaf was evaluated at full accuracy instead of its own model
  /// For each compared quantity of the job, its numbers, in order.
  std::vector<std::vector<std::optional<double>>> numbers;
  /// For each compared quantity of the job, why its numbers are missing, where that is known.
  std::vector<std::vector<std::string>> reasons;
};

/// One design with one model; a line of evaluations.jsonl.
struct ComparedPath {
  int design = 0;
  int model = 0;                ///< 0: full accuracy; then the job's models from 1
  std::string message;          ///< why not every point was reached; empty otherwise
  std::string fallback_reason;  ///< reason of the first point that has one
  std::vector<ComparedPoint> points;

  int converged() const;
  int fallbacks() const;
  bool whole() const { return message.empty(); }
};

/// What the clock says of one evaluation [s].
struct EvaluationSeconds {
  double path = 0;   ///< along the stroke, coefficients ready
  double total = 0;  ///< with building the mechanism and the leaves' coefficients

  void operator+=(const EvaluationSeconds& other) { path += other.path, total += other.total; }
};

ComparedPath compared_path(int design, int model, const std::vector<ComparedQuantity>& quantities,
                           const StrokeResponse& response);

/// One number's relative error, ≥ 0.
struct PointError {
  int quantity = 0;  ///< place among the compared ones
  int part = -1;     ///< place among the parts, of those with parts
  int design = 0, point = 0;
  double value = 0;
};

/// A number that only one of the two models has.
struct MissingNumber {
  int quantity = 0, part = -1;
  int design = 0, point = 0;
  bool in_model = false;  ///< the model lacks it; otherwise full accuracy does
  std::string reason;     ///< reason of the one that lacks it, where it gives one
};

struct PathErrors {
  std::vector<PointError> errors;
  std::vector<MissingNumber> missing;
};

/// Errors of all numbers at all points that both reached:
///     |model − full| / max(|full|, 1e-6 of the path's largest |full|),
/// of a motion: |u − u_full| / the path's largest |u_full|. Where both are below that floor, as the
/// drive load of the undeflected guide is, there is nothing to compare and no entry.
PathErrors errors_of(const std::vector<ComparedQuantity>& quantities, const ComparedPath& model,
                     const ComparedPath& full);

struct ErrorFigures {
  int count = 0;               ///< number of compared numbers
  double worst = 0;            ///< the largest
  double p99 = 0, median = 0;  ///< percentiles, linear between the sorted values
  int worst_design = 0, worst_point = 0;
};

/// Figures of the errors of one quantity, or of one part of it; nothing where there are no errors.
std::optional<ErrorFigures> error_figures(const std::vector<PointError>& errors, int quantity,
                                          std::optional<int> part = {});

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
  std::vector<MissingNumber> missing;
};

struct ComparedDesign {
  Sample sample;
  bool failed = false;  ///< full accuracy did not reach every point
  std::string message;
  int points = 0, unstable_points = 0;  ///< reached at full accuracy
  /// Slenderness of the leaf with the largest width²/(length thickness).
  double length_over_width = 0, thickness_over_length = 0, width2_over_length_thickness = 0;
};

struct Comparison {
  int failed_designs = 0;
  int evaluated = 0, evaluations = 0;  ///< design and model pairs known so far; of how many
  std::vector<ComparedQuantity> quantities;
  std::vector<ComparedDesign> designs;
  std::vector<ModelComparison> models;
};

/// Makes the comparison from the known paths (all, or those of an interrupted run) and their times
/// [s], both indexed by design × (models + 1) + model.
Comparison make_comparison(const Job& job, const std::vector<std::optional<ComparedPath>>& paths,
                           const std::vector<std::optional<EvaluationSeconds>>& seconds);

}  // namespace flexopt
