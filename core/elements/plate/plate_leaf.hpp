#pragma once
// The full plate leaf: geometrically exact thin plate between two rigid edges, in the scaled units
// of plate_mesh.hpp (length L, energy D). Equations (E1)–(E4) of core/elements/README.md.
#include <cmath>
#include <memory>
#include <vector>

#include "core/elements/leaf/condensed_interior.hpp"
#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/block_tridiagonal.hpp"

namespace flexopt {

/// How a plate is held beyond its base edge.
struct PlateSupport {
  bool free_tip = false;           ///< else the tip edge is rigid, at its pose
  std::vector<NodalWeight> point;  ///< of a material point with a prescribed displacement; or empty
  /// Derivatives of the weights along and across; empty where the point cannot move.
  std::array<std::vector<NodalWeight>, 2> point_slopes;
  /// Place of the material point: {along, across}, or the mean of the tip edge.
  std::array<double, 2> place{1, 0.5};
  bool spread_over_tip = false;
};

/// State of a plate leaf and the linear algebra about it. The unknowns, in the order of the blocks:
/// base line (the free slopes α, γ, α′, γ′ of each node), the interior lines (r, r,x, r,y, r,xy;
/// component by component), tip line; the two edge poses are arguments. The two lines of a fold
/// share one block: the nodal values of the first leg, then α, γ, α′, γ′ of the second at each
/// node.
class PlateLeaf {
 public:
  explicit PlateLeaf(std::shared_ptr<const PlateMesh> mesh, PlateSupport support = {});

  const PlateMesh& mesh() const { return *mesh_; }
  const std::shared_ptr<const PlateMesh>& shared_mesh() const { return mesh_; }
  const PlateSupport& support() const { return support_; }
  int unknowns() const { return K_.size(); }
  /// First unknown of a line; both lines of a fold have the same.
  int block_offset(int line) const { return K_.offset[block(line)]; }
  /// Whether the line is where the second leg of a folded leaf begins.
  bool is_second_of_fold(int line) const { return line > 0 && line - 1 == mesh_->fold_line(); }
  int fold_unknowns() const {
    return 3 * mesh_->functions_per_line() + 4 * mesh_->nodes_per_line();
  }

  /// Edge poses in leaf axes over L, undeflected: (0, 1) and (e1, 1).
  struct State {
    EdgePoses edges;
    VectorXd x;                               ///< all unknowns
    Vector3d point = Vector3d::Zero();        ///< displacement of the material point
    Vector3d point_force = Vector3d::Zero();  ///< that holds it there
  };
  const State& state() const { return state_; }
  void set_state(const State& state);
  static State undeflected(const PlateMesh& mesh, bool free_tip = false);
  /// Widths that rigid edges hold over the stress-free one; the material point's undeflected place
  /// over the stress-free one. 1 at first.
  void set_clamps(const std::array<double, 2>& edges, double place);
  double clamp(int edge) const { return clamps_[static_cast<std::size_t>(edge)]; }
  double place_ratio() const { return place_ratio_; }
  /// Dead force per mass: of every function of a line, its share is PlateMesh::mass_moment. Over D.
  void set_weight(const Vector3d& weight) { weight_ = weight; }
  const Vector3d& weight() const { return weight_; }

  /// Assembles and factorises at the present state. After it the results below hold.
  void assemble();
  /// First half of assemble(): computes energy, residual(), edge_force() and the parts of the
  /// tangent (tangent_times(), coupling(), edge_tangent()); condenses nothing.
  void linearise();
  /// Second half of assemble(): condenses the unknowns; after linearise().
  void eliminate();
  /// K_ff V; after linearise(), before eliminate().
  MatrixXd tangent_times(const MatrixXd& V) const;
  /// How the nodal values of a rigid edge depend on (its slopes, its displacement and spin); after
  /// linearise().
  const MatrixXd& edge_jacobian(int edge) const { return edge_jacobian_[edge]; }
  /// Second derivatives of the map of edge_jacobian() times the nodal forces f; only the lower
  /// triangle is filled.
  MatrixXd edge_curvature(int edge, const VectorXd& f) const;
  /// Static shapes of the interior lines: their unknowns per unit nodal value of the base line,
  /// then of the tip line (both rigid); after linearise(), before eliminate().
  MatrixXd line_shapes() const;
  /// Nodal values (functions_per_line × 3) of an edge (0 base, 1 tip) with these slopes.
  static MatrixXd edge_nodal(const PlateMesh& mesh, int edge, const EdgePose& pose,
                             const double* slopes, double clamp = 1);
  /// Vectors of an edge node in the edge's axes, from its middle, without the free slopes.
  static std::array<Vector3d, 4> edge_reference(const PlateMesh& mesh, int line, int node,
                                                double clamp);

  double energy() const { return energy_; }
  /// What rounding may be of it: the bending is a sum of far larger terms.
  double rounding() const { return std::sqrt(rounding_); }
  double correction() const { return std::sqrt(interior_.correction()); }
  int negative_pivots() const { return interior_.negative_pivots(); }
  /// Largest membrane strain |e11|, |e22| in the latest assembly.
  double strain() const { return strain_; }

  /// Condensed force and tangent at the edges (12), to first order in the internal residual.
  const Vector12d& force() const { return interior_.force(); }
  const Matrix12d& tangent() const { return interior_.tangent(); }
  /// Force at the edges at the present internal unknowns.
  const Vector12d& edge_force() const { return edge_force_; }

  /// Internal step for an edge increment: −K_ff⁻¹ (g_f + K_fb dq).
  VectorXd internal_step(const Vector12d& dq) const {
    Vector3d df;
    return interior_.step(K_, dq, Vector3d::Zero(), df);
  }
  /// Step of the interior for an increment dq of the edges and an increment du of the material
  /// point; the change of the point's force goes to `df`.
  VectorXd internal_step(const Vector12d& dq, const Vector3d& du, Vector3d& df) const {
    return interior_.step(K_, dq, du, df);
  }
  /// Moves edges and unknowns: edges to `edges`, x += dx. dq: the linearised increment of the edges
  /// that dx was made for. The material point moves to `point`; its force changes by df.
  void step(const EdgePoses& edges, const VectorXd& dx, const Vector12d& dq,
            const Vector3d& point = Vector3d::Zero(), const Vector3d& df = Vector3d::Zero());
  /// Moves to `state`, wherever it is; the increments are linearised ones that led there.
  void step_to(const State& state, const VectorXd& dx, const Vector12d& dq);
  bool has_point() const { return !support_.point.empty(); }
  /// Place of the material point in the undeflected leaf.
  const Vector3d& point_place() const { return point_place_; }
  /// Force at the material point and its derivatives, condensed.
  const LeafEvaluation::Point& point() const { return *interior_.point(); }

  /// Makes the solves below faster, from some twenty columns on. Until the next assemble().
  void invert_pivots() { K_.invert_pivots(); }
  /// K_ff⁻¹ b, the material point held.
  void solve(Eigen::Ref<MatrixXd> b) const { interior_.solve(K_, b); }
  /// L⁻¹ b of K_ff = L Lᵀ (no negative pivots): scalar products of the columns are energies.
  void solve_lower(Eigen::Ref<MatrixXd> b) const { K_.solve_lower(b); }
  /// L⁻ᵀ b.
  void solve_upper(Eigen::Ref<MatrixXd> b) const { K_.solve_upper(b); }
  /// Static shapes dx/d(edges, point), all other coordinates held: columns of unknowns × 12 or 15.
  MatrixXd static_shapes(const std::vector<int>& columns) const {
    return interior_.static_shapes(K_, columns);
  }
  /// K_fb: unknowns × 12.
  const MatrixXd& coupling() const { return coupling_; }
  const Matrix12d& edge_tangent() const { return edge_tangent_; }
  const VectorXd& residual() const { return g_; }

  /// Nodal dofs (functions_per_line × 3) of each line, total values r/L.
  const std::vector<MatrixXd>& nodal() const { return nodal_; }

  bool is_rigid_edge(int line) const {
    return line == 0 || (line == mesh_->lines() - 1 && !support_.free_tip);
  }
  /// Rates of the nodal dofs of a line for the columns of T (unknowns alone, or + 12 rows).
  MatrixXd nodal_rates(int line, const MatrixXd& T) const;

  /// Mass matrix Tᵀ M T of rates T (unknowns + 12 rows), in units ρ t L⁴.
  MatrixXd mass(const MatrixXd& T) const;
  /// M V for rates V of the unknowns alone or with 12 rows of the edges; rows as those of V.
  MatrixXd mass_times(const MatrixXd& V) const;

  /// Station motions for the columns of T (unknowns, then edge increments): displacement of the
  /// middle of every interior line and half the width times that of r,y; 6 rows a line. They tell
  /// motions apart.
  MatrixXd station_rates(const MatrixXd& T) const;

  struct Mode {
    double omega2;   ///< in D / (ρ t L⁴)
    VectorXd shape;  ///< M_ff-orthonormal
  };
  /// Lowest fixed-interface modes about the present state; needs assemble(). `count` stable ones
  /// and all unstable ones; of a beam one more where the last is one of an equal pair. Residuals to
  /// `tolerance`, values to its square.
  std::vector<Mode> modes(int count, double tolerance = 1e-7) const;

 private:
  int block(int line) const {
    return mesh_->fold_line() >= 0 && line > mesh_->fold_line() ? line - 1 : line;
  }
  void add_edge(int line);
  void add_fold();
  int edge_of(int line) const { return line == 0 ? 0 : 1; }
  void update_nodal();
  /// Side: functions of an element on a line, 8 (plate) or 4 (beam).
  template <int Side>
  void assemble_elements();
  template <int Side>
  MatrixXd add_element_force(int i, int j);
  template <int Side>
  void add_element_tangent(int i, int j, const MatrixXd& field);
  /// Block of the stiffness to which the elements beside line i add, and that to which those
  /// between it and the next line add.
  MatrixXd& line_diagonal(int i);
  MatrixXd& line_below(int i);
  void hold_point();
  void add_weight();
  template <int Side>
  void linearised_stress(const VectorXd& dx, const Vector12d& dq);

  std::shared_ptr<const PlateMesh> mesh_;
  PlateSupport support_;
  State state_;
  std::array<double, 2> clamps_{1, 1};
  double place_ratio_ = 1;
  Vector3d weight_ = Vector3d::Zero();
  std::vector<MatrixXd> nodal_;
  std::vector<VectorXd> nodal_force_;  ///< per line, 3 functions_per_line
  /// State of the membrane points of an element: r,x and r,y of the last assembly, and the stresses
  /// (n11, n22, n12, times the weights) that the geometric stiffness uses.
  struct PointState {
    Eigen::Matrix<double, 16, 3> gradient;
    Eigen::Array<double, PlateMesh::points, 3> stress;
  };
  std::vector<PointState> points_;
  bool stress_is_linearised_ = false;
  std::vector<MatrixXd> nodal_change_;  ///< scratch: by a step, or from the undeflected leaf

  BlockTridiagonal K_;
  MatrixXd edge_diagonal_[2], edge_below_[2];
  MatrixXd edge_jacobian_[2];
  /// Blocks of the lines at a fold: K of the elements before and behind it, and how the nodal
  /// values of the second leg depend on the unknowns.
  MatrixXd fold_diagonal_[2], fold_below_[2], fold_gap_, fold_jacobian_;
  VectorXd g_;         ///< residual
  MatrixXd coupling_;  ///< K_fb
  Matrix12d edge_tangent_;
  Vector12d edge_force_;
  double energy_ = 0, strain_ = 0;
  double rounding_ = 0;  ///< squares of all elements: they err independently
  CondensedInterior interior_;
  Vector3d point_place_;  ///< Σ weight · nodal of the undeflected leaf
};

}  // namespace flexopt
