#pragma once
// The walk along the ways from rest to the points of a path.
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/response/path/branch.hpp"

namespace flexopt {

/// The ways from rest, point by point. The points of the request and of the response may change
/// between two visits.
class BranchWalk {
 public:
  /// All arguments must outlive it. `points`: how many are expected.
  BranchWalk(const Mechanism& mechanism, const ModelOptions& model, const StrokeRequest& request,
             std::size_t points, DifferentiablePath* differentiable, StrokeResponse& response)
      : mechanism_(mechanism),
        model_(model),
        request_(request),
        points_(points),
        differentiable_(differentiable),
        response_(response),
        outputs_(mechanism, model, request, response.stress_places, differentiable) {}

  /// To rest under the constant loads: for the first way makes the leaves and puts the loads on.
  void begin();
  /// Bifurcations that the constant loads have passed do not count on this way.
  void count_from_rest() { bifurcation_passed_ = false; }
  /// Evaluates point k, from where the walk stands. Its gradients too, where `differentiable` has
  /// room for them.
  void visit(std::size_t k);
  /// Why the way has ended; empty where it goes on.
  const std::string& lost() const { return lost_; }
  /// Which limit of work has left out critical loads or load capacities of a point, if one has.
  const std::optional<std::string>& cut_short() const { return cut_short_; }

 private:
  // A part of a way: to a point, or nothing: the constant loads come.
  using Stage = std::optional<std::size_t>;
  void load();
  Equilibrium step(Stage stage);
  Equilibrium advance(Stage stage);
  /// `all_full_because`: makes all leaves full ones for this reason; null: keeps those that are
  /// not.
  Equilibrium go_again(Stage stage, const char* all_full_because = nullptr);
  Equilibrium on_fresh_full_leaves(Stage stage);
  Equilibrium reach(std::size_t k);
  void add_branching(System& system, Equilibrium& equilibrium, std::size_t k, PathPoint& point,
                     PointGradients* own);
  System& system() { return away_ ? *away_ : *home_; }

  const Mechanism& mechanism_;
  const ModelOptions& model_;
  const StrokeRequest& request_;
  std::size_t points_;
  DifferentiablePath* differentiable_;
  StrokeResponse& response_;
  PointOutputs outputs_;
  std::unique_ptr<System> home_;   // begins every way
  std::unique_ptr<System> away_;   // has taken over on this way
  std::vector<std::size_t> done_;  // points of this way that are passed, where it goes in order
  std::string lost_, not_loaded_;
  std::optional<std::string> cut_short_;
  std::string under_loads_;           // what was passed while the constant loads came
  bool bifurcation_passed_ = false;   // on this way
  std::optional<Push> other_branch_;  // what led there; nothing on the primary one
};

}  // namespace flexopt
