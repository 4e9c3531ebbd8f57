#pragma once
// A leaf made of linear superelements: its inner interface nodes are internal unknowns, eliminated
// line by line, so that the mechanism sees the edges only, as of every other leaf. The tip edge may
// be free, then its nodes are internal too; a material point is one of the nodes.
#include <memory>
#include <vector>

#include "core/elements/leaf/condensed_interior.hpp"
#include "core/elements/leaf/leaf_element.hpp"
#include "core/elements/plate/full_leaf.hpp"
#include "core/math/block_tridiagonal.hpp"
#include "core/reduction/superelement/superelement.hpp"
#include "core/reduction/superelement/superelement_grid.hpp"

namespace flexopt {

class SuperelementLeaf final : public LeafElement {
 public:
  /// `grid` must have been made for such a leaf. `index`: of the leaf in its mechanism.
  SuperelementLeaf(const LeafSpring& leaf, std::shared_ptr<const SuperelementGrid> grid, int index);

  void move(const EdgePoses& edges, const Vector12d& dq) override;
  void displace_point(const Vector3d& displacement, const Vector3d& du) override;
  const LeafEvaluation& evaluate() override;
  std::unique_ptr<LeafState> save() const override;
  void restore(const LeafState& state) override;
  LeafDynamics dynamics(DynamicsRequest request) override;
  LeafStress stress() override;
  LeafShape shape() override;
  std::vector<Vector3d> material_points(const std::vector<std::array<double, 2>>& places) override;
  LeafReport report() const override;
  std::unique_ptr<LeafElement> full_model(const std::string& reason) override;
  const SuperelementGrid& grid() const { return *grid_; }
  const std::vector<NodePose>& nodes() const { return nodes_; }  ///< line by line
  const Superelement& superelement(int i) const { return elements_[i]; }
  /// A line whose nodes a body or the ground holds.
  bool is_edge(int line) const {
    return line == 0 || (line == grid_->lines() - 1 && leaf_.tip != free_edge);
  }
  int edge_of(int line) const { return line == 0 ? 0 : 1; }
  int unknowns() const { return K_.offset.empty() ? 0 : K_.size(); }  ///< of the inner nodes
  /// First unknown of a line's nodes; the line is not an edge.
  int offset(int line) const { return K_.offset[line - 1]; }
  /// K_ff⁻¹ b of the inner nodes, edges and material point held; after evaluate().
  void solve(Eigen::Ref<MatrixXd> b) const;
  /// d(inner nodes)/d(edges, point).
  MatrixXd static_shapes() const;

 private:
  bool has_point() const { return !shares_.empty(); }
  int boundary() const { return has_point() ? 15 : 12; }  ///< coordinates seen from outside
  int node_index(SuperelementGrid::Node n) const {
    return n.line * grid_->nodes_per_line() + n.node;
  }
  void place_edges(const EdgePoses& edges);
  void evaluate_elements();
  void assemble_lines();
  void condense();
  void hold_point();
  /// Rates of a superelement's nodes for the columns of T (unknowns + 12 rows).
  MatrixXd node_rates(int element, const MatrixXd& T) const;
  SuperelementGrid::State grid_state() const;

  LeafSpring leaf_;
  std::shared_ptr<const SuperelementGrid> grid_;
  int index_;
  LeafScale scale_;
  std::vector<NodePose> nodes_;
  std::vector<Superelement> elements_;
  std::vector<VectorXd> linearised_;  ///< local coordinates of the linearised last step, or empty
  bool framed_ = true;                ///< every superelement has found its frame
  std::vector<NodePose> gather_;

  std::vector<MatrixXd> diagonal_, below_;  ///< of all lines, edges not yet rigid
  std::vector<VectorXd> line_force_;
  MatrixXd edge_jacobian_[2];  ///< node motions of an edge by its pose
  BlockTridiagonal K_;         ///< of the inner lines
  VectorXd g_;                 ///< residual
  MatrixXd coupling_;          ///< K_fb
  CondensedInterior interior_;
  // The material point Σ weight · position = place + u with its force λ, as in PlateLeaf.
  std::vector<NodeShare> shares_;
  Vector3d place_ = Vector3d::Zero(), displacement_ = Vector3d::Zero(),
           increment_ = Vector3d::Zero(), point_force_ = Vector3d::Zero();
  Vector12d edge_force_;
  Matrix12d edge_tangent_;
};

}  // namespace flexopt
