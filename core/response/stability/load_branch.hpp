#pragma once
// Equilibria of a mechanism while one dead load grows or falls and all else is kept: the other
// loads, and with the drives locked their strokes, with the drives free their loads.
#include <memory>

#include "core/equilibrium/system.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/response/request.hpp"

namespace flexopt {

/// A direction along the branch: displacements and spins of the bodies, and change of the factor.
struct BranchDirection {
  VectorXd bodies;
  double factor = 0;
};

class LoadBranch {
 public:
  /// `system`: assembled at an equilibrium, its leaves with interior unknowns; it is copied.
  /// `load`: of the constant loads, the one that changes; `growing`: the present factor of the
  /// growing ones. `drive_loads`: at that equilibrium, one for each drive.
  LoadBranch(System& system, std::size_t load, double growing, DriveState drive,
             const VectorXd& drive_loads, const NewtonOptions& options);
  /// Branch of a load that comes to all others, which stay; its factor is 0 where the branch
  /// begins.
  LoadBranch(System& system, const DeadLoad& more, double growing, DriveState drive,
             const VectorXd& drive_loads, const NewtonOptions& options);

  System& system() { return *system_; }
  const System& system() const { return *system_; }
  bool locked() const { return drive_ == DriveState::locked; }
  /// Factor of the load: where the branch begins 1, or 0 of a load that comes to the others.
  double factor() const { return system_->load_factors().growing; }
  /// Force and moment per body for a factor of 1, at the present state [N, N m].
  VectorXd load() const;
  /// The load for a factor of 1 as it stands on its body.
  BodyLoad named() const;
  /// Negative eigenvalues of the whole tangent, leaf interiors included.
  int negative_pivots() const;

  /// Goes on by `size` times the direction, then back onto the branch across the direction. Where
  /// that fails the state is the old one. Lengths in `along` count over the longest leaf, and all
  /// of its motions by `weight` beside the factor.
  Check advance(const BranchDirection& along, double size, double weight);
  /// To a factor, along which all else follows.
  Check advance_to(double factor);

  using State = System::Snapshot;
  State save() const { return system_->save(); }
  void restore(const State& state);

 private:
  LoadBranch(System& system, LoadCase loads, double factor, DriveState drive,
             const VectorXd& drive_loads, const NewtonOptions& options);
  void apply(double factor);
  Check correct(const BranchDirection& across);

  std::unique_ptr<System> system_;
  DriveState drive_;
  VectorXd strokes_;       ///< held, drives locked
  VectorXd drive_forces_;  ///< kept on coordinates of the bodies, drives free
  NewtonOptions options_;
};

}  // namespace flexopt
