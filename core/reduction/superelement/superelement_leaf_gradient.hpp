#pragma once
// A leaf of linear superelements as exact derivatives need it: in leaf axes and units (LeafRows),
// like a full leaf. The internal unknowns are the inner nodes, six each, line by line: place over L
// and axes, both seen from the leaf's axes, moved by (displacement, spin); then the amplitudes of
// the superelements' vibration modes, zero at every equilibrium. With the numbers of its nodes
// constant a leaf that grows or turns takes them along; one that widens slides under them.
#include <vector>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_linear.hpp"
#include "core/reduction/superelement/superelement_gradient.hpp"
#include "core/reduction/superelement/superelement_leaf.hpp"
#include "core/reduction/superelement/superelement_model_rate.hpp"

namespace flexopt {

/// A leaf at its present places with its superelements in units of the leaf.
/// The leaf must outlive it.
class ScaledSuperelements final : public LeafLinear {
 public:
  explicit ScaledSuperelements(const SuperelementLeaf& leaf);
  ScaledSuperelements(const ScaledSuperelements&) = delete;
  /// Every superelement has found its frame; nothing else holds where one has not.
  bool framed() const { return framed_; }

  const SuperelementLeaf& leaf() const { return *leaf_; }
  const SuperelementGrid& grid() const { return leaf_->grid(); }
  const SuperelementModel& model(int i) const { return models_[i % grid().rows()]; }
  const Superelement& operator[](int i) const { return elements_[i]; }
  const std::vector<NodePose>& nodes() const { return nodes_; }

  int nodal() const { return leaf_->unknowns(); }  ///< unknowns of the inner nodes
  int amplitudes() const { return own_ * grid().elements(); }
  const LeafScale& scale() const override { return leaf_->scale(); }
  int unknowns() const override { return nodal() + amplitudes(); }
  int own_amplitudes() const { return own_; }
  int amplitude(int element) const { return nodal() + own_ * element; }

  /// K_ff⁻¹ b of the unknowns, edges and material point held. The leaf must be assembled.
  void solve(Eigen::Ref<MatrixXd> b) const override;
  MatrixXd static_shapes(const std::vector<int>& columns) const override;
  MatrixXd mass_times(const MatrixXd& V) const override;
  /// Of the inner nodes: displacement and half the distance of the lines times the spin.
  MatrixXd station_motion(const MatrixXd& V) const override;
  Answer<LeafGradient<double>> gradient(LeafRates& rates, const LeafRows& rows) const override;
  /// Rates of an element's nodes and amplitudes by those of the unknowns and the edges.
  MatrixXd element_rates(int element, const MatrixXd& V) const;

 private:
  const SuperelementLeaf* leaf_;
  std::vector<SuperelementModel> models_;  ///< by rows
  int own_;
  std::vector<NodePose> nodes_;
  std::vector<Superelement> elements_;
  std::vector<MatrixXd> mass_;
  bool framed_ = true;
};

class SuperelementLeafGradient final : public LeafGradient<double> {
 public:
  /// `rows.unknowns` must be leaf.unknowns(). The material point is a node and stays it.
  SuperelementLeafGradient(const ScaledSuperelements& leaf, const LeafRows& rows);

  MatrixXd force_rates(const std::vector<LeafVariation<double>>& variations) const override;
  LeafQuadratic<double> quadratic(const MatrixXd& Y, const VectorXd& mu) const override;

  std::unique_ptr<LeafFields> fields(
      const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const override;

  const SuperelementLeaf& leaf() const { return leaf_->leaf(); }
  /// Rates of the fields (recovery · q) of every superelement, of a state that moves by y along the
  /// variation: for SuperelementLeaf::stress_rate.
  std::vector<VectorXd> field_rates(const VectorXd& y,
                                    const LeafVariation<double>& variation) const;

  /// Of the place over L of a point of the mid-surface, likewise.
  Vector3d place_rate(double along, double across, const VectorXd& y,
                      const LeafVariation<double>& variation) const;

 private:
  /// Of recovery · q.
  VectorXd field_rate(int element, const MatrixXd& node_rates, const Vector3d& shape) const;
  struct Node {
    int edge;             ///< that holds it, or −1
    int row;              ///< of its force in LeafRows: its own, or of the body that holds it
    Vector3d local, arm;  ///< from the body to the node, in its axes and present
    double y;             ///< place across, undeflected
  };
  /// Nodes as the variations alone move them: 6 rows a node.
  MatrixXd node_rates(const std::vector<LeafVariation<double>>& variations) const;
  /// Nodes by the columns of Y: 6 rows a node.
  MatrixXd increments(const MatrixXd& Y) const;
  void add_to_rows(const MatrixXd& nodal, MatrixXd& rows) const;
  MatrixXd gather(int element, const MatrixXd& nodal) const;
  void scatter(int element, const MatrixXd& of_element, Eigen::Ref<MatrixXd> nodal) const;
  bool at_edge(int element) const;

  const ScaledSuperelements* leaf_;
  std::vector<Node> nodes_;
  std::array<Matrix3d, 2> edge_axes_;
  std::vector<SuperelementGradient> elements_;
  MatrixXd node_force_;   ///< 6 rows a node
  MatrixXd shape_force_;  ///< its derivatives in w/L, t/L, ν
};

}  // namespace flexopt
