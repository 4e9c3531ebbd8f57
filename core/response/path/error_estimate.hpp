#pragma once
// Estimated errors of all numbers of a stroke, from full leaves on the same mesh and on finer ones.
#include <array>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/math/answer.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/response/estimated_error.hpp"
#include "core/response/response.hpp"

namespace flexopt {

// What the theory of beams and plates is off by where the thickness of a leaf varies steeply, and
// that of plates where a leaf is narrow.

/// Relative errors against solids, those of the steepest leaf; zero without such leaves.
struct ProfileError {
  double bending = 0;      ///< stiffness against bending about the width
  double translation = 0;  ///< stiffness against forces
  double rotation = 0;     ///< stiffness against moments, twist above all
};

/// The surfaces of a leaf whose thickness varies slope by ±φ against its middle, tan φ = t′/2. Its
/// stress follows them, and what beams leave out of the strain energy is of the order sin² φ of
/// that. Their means over the flexibility, in bending and in stretching,
///
///     ε_k = ∫ sin² φ t^−k ds / ∫ t^−k ds,   bending = 1.45 ε_3,
///     translation = 2.6 ε_1,   rotation = max(2.6 ε_1, 10 ε_3) (S33)
///
/// of core/response/README.md, with factors from notches of solid elements.
ProfileError profile_error(const Mechanism& mechanism);

/// What the narrowest plate is off by against a moment in its plane, relative to beams, t/w
/// being that of its mean sizes; zero without plates:
///
///     0.7 (3 − 2ν + 3ν²)/(1 − ν²) max((t/w)² − ¼, 0) + (0.012 + 1.15 ν²) (t/w)⁴ (S36)
///
/// The first term is what (E9) of core/elements/README.md no longer takes back.
double narrow_plate_error(const Mechanism& mechanism, const ModelOptions& model);

/// The mesh with √2 times the elements along, and across: 14 × 4 and 10 × 6 of 10 × 4.
std::array<int, 2> more_along(const std::array<int, 2>& mesh);
std::array<int, 2> more_across(const std::array<int, 2>& mesh);

/// Why a model has no estimates; nothing where it has.
Check has_estimates(const ModelOptions& model);

/// The numbers of a converged point that have estimates, with values alone.
std::vector<EstimatedError> estimated_numbers(const PathPoint& point);

/// Errors of every point of a path; none at points that did not converge.
struct StrokeErrors {
  std::vector<std::vector<EstimatedError>> path;
  std::string message;  ///< why points that converged have none; empty otherwise

  /// Estimated error of a number at a point; null where there is none.
  const EstimatedError* find(std::size_t point, const std::string& name) const;
};

/// What the numbers of a mechanism's paths are large or small against.
struct MechanismScale {
  double length = 0;              ///< longest_leaf [m]
  double force = 0;               ///< largest E w t of a leaf [N]
  double modulus = 0;             ///< largest E of a leaf [Pa]
  std::set<std::string> moments;  ///< names of the drive loads that are moments
  ProfileError theory;            ///< with narrow_plate_error
};
MechanismScale scale_of(const Mechanism& mechanism, const ModelOptions& model);

/// Request of a path from which errors can be estimated.
StrokeRequest estimate_request(StrokeRequest request);

/// The mechanism with the coarse twins of its elastic bodies; nothing where there are none.
std::optional<Mechanism> with_coarse_bodies(const Mechanism& mechanism);

/// The evaluated path with full leaves, on the mesh of the model and on the finer meshes.
struct FullPaths {
  std::shared_ptr<const StrokeResponse> own, along,
      across;  ///< across: null without elements there
  std::shared_ptr<const StrokeResponse>
      coarse;                 ///< by the model itself, with_coarse_bodies(); null without those
  std::array<int, 2> mesh{};  ///< own
  MechanismScale scale;
};

/// Errors of a response by some model on that mesh.
StrokeErrors errors_of(const StrokeResponse& response, const FullPaths& full);

/// Errors of a response, from paths of full leaves that are evaluated here. `response`: the result
/// of evaluate_stroke for the other arguments. Costs about as much as five paths of full leaves,
/// and one by the model where there are elastic bodies.
StrokeErrors estimate_errors(const Mechanism& mechanism, const ModelOptions& model,
                             const StrokeRequest& request, const StrokeResponse& response);

/// Whether some leaf of the mechanism has elements across.
bool has_elements_across(const Mechanism& mechanism, const ModelOptions& model);

/// The largest relative error of some paths and where it is.
struct LargestError {
  std::string name;
  std::size_t path = 0, point = 0;
  double relative = 0, along = 0, across = 0, reduction = 0, theory = 0, solids = 0;  ///< relative
};
/// Returns the largest relative error of all numbers but stresses, or of these.
std::optional<LargestError> largest_error(const std::vector<StrokeErrors>& errors,
                                          bool of_stresses);

/// Returns the largest relative error of stresses, safeties and lives, each taken where it decides:
/// a stress where it is largest, a safety or a life where it is least.
std::optional<EstimatedError> decisive_stress_error(const std::vector<StrokeErrors>& errors);

/// For every number but stresses, the largest error that exceeds the tolerance, in descending
/// order.
std::vector<LargestError> errors_beyond(const std::vector<StrokeErrors>& errors, double tolerance);

}  // namespace flexopt
