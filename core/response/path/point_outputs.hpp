#pragma once
// What is read off an equilibrium of the path: motion, stiffness, frequencies, stress, shapes, and
// the derivatives of all of them.
#include <array>
#include <optional>
#include <vector>

#include "core/equilibrium/stroke_path.hpp"
#include "core/response/gradients/design_rates.hpp"
#include "core/response/modes/dynamics_measures.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/path/frequency_derivatives.hpp"
#include "core/response/response.hpp"
#include "core/response/solids.hpp"
#include "core/response/stability/load_capacity.hpp"
#include "core/response/stroke_gradients.hpp"

namespace flexopt {

/// What the points of a differentiable path share.
struct DifferentiablePath {
  DesignDirections design;  ///< of the gradients; may be empty
  StrokeGradients gradients;
  /// Where the path has a point at rest: the modes along the stroke from it, and what they took.
  std::optional<Answer<FrequencyDerivativesResult>> along_stroke;
  double seconds_along_stroke = 0;
};
/// Gradients of a path to be filled in; null where none are wanted.
inline StrokeGradients* gradients_of(DifferentiablePath* path) {
  return path && !path->design.list.empty() ? &path->gradients : nullptr;
}

/// Evaluates the points of one branch of the path, one after the other.
class PointOutputs {
 public:
  /// All arguments must outlive it. `stress_places`: StrokeResponse::stress_places, which branches
  /// share. `differentiable`: null for points as they are modelled.
  PointOutputs(const Mechanism& mechanism, const ModelOptions& model, const StrokeRequest& request,
               std::vector<std::vector<StressPlace>>& stress_places,
               DifferentiablePath* differentiable);

  /// The system must stand assembled at the equilibrium of the point `index`. `gradients`: null
  /// where none are wanted. Where it fails the point is to be evaluated on full leaves instead.
  Check evaluate(System& system, const Equilibrium& equilibrium, std::size_t index,
                 PathPoint& point, PointGradients* gradients);
  /// Bandwidth, transmissibility and the linear model of a point as it is modelled, from leaves
  /// that know their interiors. Where it fails the tables of reduced leaves end before, and the
  /// point is to have them of full leaves instead.
  Check add_dynamics(System& system, std::size_t index, PathPoint& point);
  /// Critical factors of the load that the request names, from an equilibrium on full leaves, and
  /// their derivatives.
  void add_buckling(System& system, const Equilibrium& equilibrium, std::size_t index,
                    PathPoint& point, PointGradients* gradients);
  /// Likewise the largest loads that the request asks for.
  void add_load_capacity(System& system, const Equilibrium& equilibrium, std::size_t index,
                         PathPoint& point, PointGradients* gradients);
  /// Why those of both that the point does not have yet are missing.
  void miss_branching(const std::string& why, PathPoint& point) const;

 private:
  static void add_reports(System& system, PathPoint& point);
  void add_stress_and_shapes(System& system, PathPoint& point) const;
  static void add_stress_peaks(System& system, int wanted, PathPoint& point);
  void add_ritz_frequencies(System& system, PathPoint& point);
  bool add_full_frequencies(const MechanismFactor& factor, std::size_t index, FullModeLists& lists,
                            PathPoint& point);
  void add_mode_shapes(System& system, PathPoint& point);
  Check check_modes(const MechanismFactor& factor, const FullModeLists& lists, bool found,
                    const DynamicsMeasures& dynamics) const;
  bool add_measures(const MechanismFactor& factor, bool terms, DynamicsMeasures& measures,
                    PathPoint& point);
  bool add_state_space(const MechanismFactor& factor, const FullModes& free, std::size_t index,
                       PathPoint& point);
  /// For how many frequencies a point's factor has modes of elastic bodies.
  int vibrations(const System& system, std::size_t index) const;
  Check evaluate_differentiable(System& system, const Solids* solids, std::size_t index,
                                PathPoint& point, PointGradients* gradients);

  const ModelOptions* model_;
  const StrokeRequest* request_;
  DifferentiablePath* differentiable_;
  std::vector<std::vector<StressPlace>>* stress_places_;
  std::optional<ConstantMass> constant_mass_;
  std::optional<CapacityDirections> capacity_;
  std::vector<std::array<int, 2>> clearance_pairs_;
};

/// Whether the elastic bodies of a point deform no further than the degrees of their energies hold.
Check check_degree(const Mechanism& mechanism, const PathPoint& point);

}  // namespace flexopt
