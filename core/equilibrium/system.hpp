#pragma once
// A mechanism in a configuration: rigid bodies with absolute coordinates, leaves, elastic bodies,
// joints and springs between them.
#include <array>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/elements/leaf/leaf_element.hpp"
#include "core/equilibrium/constraints.hpp"
#include "core/equilibrium/dead_loads.hpp"
#include "core/equilibrium/elastic_bodies.hpp"
#include "core/equilibrium/springs.hpp"
#include "core/math/block_matrix.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

class SparseAnalyses;

/// How the equations of a mechanism are solved: dense where they are few.
enum class Algebra { by_size, dense, sparse };

/// Which drives keep their strokes: all; those that the load case holds, as where results say
/// "drives free"; or none.
struct DriveHold {
  enum Of { none, named, all } of;
  DriveHold(bool all_held) : of(all_held ? all : named) {}
  DriveHold(Of which) : of(which) {}
};

class System {
 public:
  /// One leaf element for each leaf of the mechanism, whose elastic bodies have passed
  /// check_solid(). The mechanism must outlive the system. None
  /// of the loads acts at first, nor does the preload of the springs.
  System(const Mechanism& mechanism, std::vector<std::unique_ptr<LeafElement>> leaves,
         LoadCase loads = {}, Algebra algebra = Algebra::by_size);

  const Mechanism& mechanism() const { return *mechanism_; }
  int size() const { return 6 * static_cast<int>(poses_.size()); }
  const JointBody& pose(int body) const { return poses_[body]; }
  const std::vector<JointBody>& poses() const { return poses_; }
  LeafElement& leaf(int i) { return *leaves_[i]; }
  const LeafElement& leaf(int i) const { return *leaves_[i]; }
  int leaves() const { return static_cast<int>(leaves_.size()); }
  /// The elastic bodies; their states are those of the last assemble().
  const ElasticBodies& elastic_bodies() const { return elastic_bodies_; }
  bool all_full() const;  ///< every leaf is at full accuracy
  /// Replaces the model of a leaf by another one of the same leaf, at the present state.
  void replace_leaf(int i, std::unique_ptr<LeafElement> leaf) {
    std::swap(leaves_[i], leaf);
    if (home_ && !home_->leaves[i]) home_->leaves[i] = std::move(leaf);
    assembled_ = false;
    ++replacements_;
  }
  /// How often the model of a leaf was replaced: a snapshot may be restored to where it is the
  /// same.
  int replacements() const { return replacements_; }
  /// Makes the present state, with the present models of the leaves, the one to which return_home()
  /// leads back.
  void stay_home() {
    home_ = Home{save(), std::vector<std::unique_ptr<LeafElement>>(leaves_.size())};
  }
  void return_home();
  /// Call when a leaf has changed internally: the next assemble() is then not skipped.
  void invalidate() { assembled_ = false; }

  const LoadCase& loads() const { return loads_; }
  LoadFactors load_factors() const { return factors_; }
  /// Lets so much of the loads act; with the constant ones come the preload of springs, the errors
  /// of assembly, the warmth of leaves and gravity. Leaves follow edges that this moves.
  void apply(LoadFactors factors);
  /// Whether anything comes before the stroke.
  bool loaded_at_rest() const { return loads_.acts_before_stroke() || springs_.preloaded(); }
  /// Acting loads, one for each dead load.
  const std::vector<BodyLoad>& acting() const { return acting_; }

  /// Evaluates every leaf at the present state, once. After it the results below hold.
  void assemble();
  double energy() const { return energy_; }
  /// Internal (force, moment) for each body, including elastic bodies, springs and joints (Ψ_qᵀ λ).
  /// The weight of elastic bodies is inside.
  const VectorXd& internal_force() const { return force_; }
  /// Force and moment of the dead loads per body, about its moved reference point.
  const VectorXd& load() const { return load_; }
  /// Whether loads that act follow their bodies; after assemble().
  bool follows() const { return follows_; }
  /// Potential energy of the dead forces [J], zero in the undeflected state. Dead moments have no
  /// potential and add nothing.
  double load_energy() const;
  /// Second derivative of energy and load energy along exp(hat δ) R; symmetric. Where loads follow
  /// their bodies, the residual_tangent(), which is not.
  const BlockMatrix& tangent() const { return tangent_; }
  /// Derivative of internal_force − load by (displacement, spin) of the bodies, joints' multipliers
  /// held: spins do not commute, README.md (Q1). Rows of held coordinates are those of the
  /// identity.
  BlockMatrix residual_tangent() const;
  /// Largest of the leaves; that of a failure where an elastic body has no frame.
  double correction() const { return correction_; }
  double strain() const { return strain_; }  ///< largest mid-surface stretch of the leaves
  int negative_pivots() const { return negative_pivots_; }  ///< of all leaf interiors
  /// Coordinates of bodies that cannot move: in tangent and force they are decoupled ones.
  const std::vector<int>& held() const { return held_; }

  /// The conditions of joints and drives at the present state, and the forces that hold them: of a
  /// drive the negative of its load.
  const Constraints& constraints() const { return constraints_; }
  const VectorXd& multipliers() const { return multipliers_; }  ///< λ [N, N m]
  /// How a stroke is prescribed: one of both.
  struct DriveRow {
    std::optional<int> coordinate;  ///< of the bodies
    std::optional<int> condition;   ///< row of constraints()
  };
  /// How each drive of the mechanism enters the equations.
  const std::vector<DriveRow>& drives() const { return drives_; }
  bool holds(std::size_t drive, DriveHold by) const {
    return by.of == DriveHold::all || (by.of == DriveHold::named && loads_.held[drive]);
  }
  /// Coordinates of bodies that these drives hold.
  std::vector<int> driven_coordinates(DriveHold by) const;
  /// Rows of constraints() that hold: the joints', and those of these drives.
  std::vector<int> holding_conditions(DriveHold by) const;
  /// Forces of unit drive loads, one column for each drive that is not held; after assemble().
  MatrixXd drive_forces(DriveHold held = DriveHold::none) const;
  /// Load that a drive exerts on its body [N or N m]; after assemble().
  double drive_load(std::size_t drive) const {
    const DriveRow& row = drives_[drive];
    return row.condition ? -multipliers_[*row.condition]
                         : force_[*row.coordinate] - load_[*row.coordinate];
  }
  void add_to_multipliers(const VectorXd& change) {
    multipliers_ += change;
    assembled_ = false;
  }

  /// Moves the bodies by (displacement, spin) each; the leaves follow the linearised increment.
  void move(const VectorXd& dq);

  struct Snapshot {
    std::vector<JointBody> poses;
    std::vector<std::unique_ptr<LeafState>> leaves;
    VectorXd multipliers, conditions;
    LoadFactors factors;
  };
  Snapshot save() const;
  void restore(const Snapshot& snapshot);
  /// The system at its present state on full leaves under other loads. `reason`: for the reports of
  /// leaves that were reduced.
  std::unique_ptr<System> on_full_leaves(LoadCase loads, const std::string& reason = {});

  /// Displacement and rotation of a leaf's end in its body, against the design.
  struct EdgeFit {
    Vector3d move = Vector3d::Zero();      ///< undeflected, global axes [m]
    Vector3d spin = Vector3d::Zero();      ///< rotation vector of `turn` [rad]
    Matrix3d turn = Matrix3d::Identity();  ///< about the edge's middle, global axes
  };
  const EdgeFit& edge_fit(int leaf, int end) const { return fits_[leaf][end]; }
  /// Pose of an end of a leaf (0 base, 1 tip) and the map from its body's increment to the edge's.
  EdgePose edge_pose(int leaf, int end) const;
  Matrix6d edge_map(int leaf, int end) const;
  /// Increments of a leaf's edges for those of all bodies.
  Vector12d edge_increment(int leaf, const VectorXd& dq) const;

  /// Mass matrix of the rigid and elastic bodies about the moved reference points; after
  /// assemble().
  BlockMatrix body_mass() const;

  /// longest_leaf(): the length that displacements are compared with [m].
  double length() const { return length_; }
  /// Units of the coordinates are the length for displacements, 1 for rotations.
  const VectorXd& units() const { return units_; }
  /// What is kept of the patterns where the equations are solved sparse; else null.
  const std::shared_ptr<SparseAnalyses>& analyses() const { return analyses_; }

 private:
  int body(int leaf, int end) const {
    return end == 0 ? mechanism_->leaves[leaf].base : mechanism_->leaves[leaf].tip;
  }
  Vector3d lever(int leaf, int end) const;
  Vector3d place(int leaf, int end) const;  ///< of the edge's middle, undeflected
  bool is_forced(int leaf) const;           ///< at this factor of the constant loads or another
  void set_factors(LoadFactors factors);
  void add_turning(BlockMatrix& K) const;
  LeafLoad acting_inside(const LoadCase& loads) const;  ///< at the present factors

  const Mechanism* mechanism_;
  std::vector<std::unique_ptr<LeafElement>> leaves_;
  std::vector<JointBody> poses_;
  LoadCase loads_;
  LoadFactors factors_;
  std::vector<std::array<EdgeFit, 2>> fits_;
  std::vector<BodyLoad> acting_;
  ElasticBodies elastic_bodies_;
  Springs springs_;
  Constraints constraints_;
  std::vector<DriveRow> drives_;
  VectorXd multipliers_;
  double length_ = 0;
  std::vector<int> held_;
  VectorXd units_, force_, load_;
  BlockMatrix tangent_;
  std::shared_ptr<SparseAnalyses> analyses_;
  double energy_ = 0, correction_ = 0, strain_ = 0;
  int negative_pivots_ = 0, replacements_ = 0;
  bool follows_ = false;
  bool assembled_ = false;  ///< the results are those of the present state
  struct Home {
    Snapshot state;
    std::vector<std::unique_ptr<LeafElement>> leaves;  ///< those that were replaced since
  };
  std::optional<Home> home_;
};

}  // namespace flexopt
