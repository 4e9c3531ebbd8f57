#pragma once
// Exact derivatives of what a stroke answers with respect to design parameters. Plain data, laid
// out as the numbers of response.hpp: one row for each number, one column for each parameter.
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/response/response.hpp"

namespace flexopt {

/// Frequencies that are equal but for rounding, or so near that single derivatives mean nothing.
/// The squares of the ranked frequencies first … first + size − 1 move, for a change dp of the
/// parameters, like the eigenvalues of
///     diag(ω²) + Σ_j block[j] dp_j,    block[j] = Φᵀ (∂K/∂p_j − ω² ∂M/∂p_j) Φ     [rad²/s² per SI]
/// with Φ any M-orthonormal basis of their motions (state terms included in ∂K, ∂M).
struct FrequencyCluster {
  int first = 0, size = 0;
  std::vector<MatrixXd> block;  ///< for each parameter, size × size, symmetric
};

/// Derivatives at one point of the path. Without rows (or nothing) where the point has no such
/// number or it was not asked for.
struct PointGradients {
  VectorXd drive_load, drive_stiffness;     ///< along the parameters, of the first drive
  MatrixXd drive_loads, drive_stiffnesses;  ///< drives × parameters
  MatrixXd gain, cross_coupling;            ///< 6 · drives × parameters
  std::vector<std::optional<VectorXd>> voice_coil, piezo;  ///< as the point's
  MatrixXd displacement, rotation;                         ///< 3 × parameters
  std::array<std::optional<VectorXd>, 6> support_stiffness;
  /// Derivatives of the translational block of `PathPoint::compliance_locked`, one for each
  /// parameter; zero rows and columns where the block has them.
  std::vector<Matrix3d> translation_compliance;
  /// Row k: of `PathPoint::frequencies_free[k]`, and locked [Hz per SI]. A member of a cluster has
  /// the row of its branch: diagonal of the block in a basis that makes the blocks as diagonal as
  /// they get, so that branches which cross keep their derivatives.
  MatrixXd frequencies_free, frequencies_locked;
  std::vector<FrequencyCluster> clusters_free, clusters_locked;
  std::optional<VectorXd> parasitic_frequency, parasitic_frequency_screening;
  std::optional<VectorXd> max_stress;  ///< the place of the peak held in the leaf's own coordinates
  std::optional<VectorXd> notch_stress, yield_safety, fatigue_safety, fatigue_life;  ///< place held
  std::vector<MatrixXd> section_rates;  ///< derivatives of `PathPoint::sections`, see LeafFields
  MatrixXd stress_peaks;                ///< row k: of `PathPoint::stress_peaks[k]`
  MatrixXd envelope, moving_envelope;   ///< x, y, z, cylinder × parameters
  MatrixXd extents;                     ///< in the order of `Extents::at` × parameters
  std::optional<VectorXd> clearance, leaf_mass;
  std::vector<std::optional<VectorXd>> bandwidths;  ///< of each drive
  std::optional<VectorXd> transmissibility;
  std::vector<std::optional<VectorXd>> motions_along, transfers, transfer_bandwidths;
  MatrixXd gauges, bridges;  ///< of the strains and of the outputs × parameters
  std::optional<VectorXd> buckling_locked, buckling_free;  ///< of the factors
  /// Capacities that a limit ends have one; it is zero where that is the largest that is looked at.
  std::array<std::optional<VectorXd>, 12> load_capacity;
  std::vector<std::optional<VectorXd>> stroke_capacity;   ///< of those that have a value
  std::vector<std::optional<VectorXd>> named_quantities;  ///< as the point's
};

/// Derivatives of FrequencyDerivatives, along the parameters. Members of a cluster of equal
/// frequencies: as if nothing coupled them, which symmetry grants.
struct FrequencyDerivativeGradients {
  VectorXd omega2, d_omega2, d2_omega2;
};

struct StrokeGradients {
  std::vector<std::string> parameters;  ///< names of the columns
  std::vector<PointGradients> path;     ///< one for each point of the response
  std::vector<FrequencyDerivativeGradients> frequency_derivatives;        ///< as the response's
  std::vector<std::vector<FrequencyDerivativeGradients>> frequency_ways;  ///< as the response's
};

/// A response and its derivatives. There are none where the response has no equilibrium, or where
/// the model offers none; `message` says why.
struct StrokeSensitivity {
  StrokeResponse response;
  std::optional<StrokeGradients> gradients;
  std::string message;
};

/// A design parameter: derivative of every number of the mechanism along it, in that number's
/// place.
struct MechanismDirection {
  std::string parameter;
  Mechanism rate;
};

/// Direction of an assembly error: `rate` is the change [m, rad] of the error at its edge, whether
/// StrokeRequest::loads has one there or not.
MechanismDirection assembly_direction(std::string parameter, const Mechanism& mechanism,
                                      const AssemblyError& rate);

/// The response with its exact derivatives along the parameters. The frequencies are then those of
/// the whole mechanism, leaf interiors included, to rounding (evaluate_stroke's are Ritz values, a
/// few 1e-5 above them).
StrokeSensitivity evaluate_stroke_gradients(const Mechanism& mechanism,
                                            const std::vector<MechanismDirection>& directions,
                                            const ModelOptions& model,
                                            const StrokeRequest& request);

}  // namespace flexopt
