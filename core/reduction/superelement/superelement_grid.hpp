#pragma once
// A leaf cut into linear superelements: which they are, where their nodes lie, and the fields they
// stand for.
#include <algorithm>
#include <array>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "core/elements/leaf/leaf_results.hpp"
#include "core/elements/plate/plate_stress.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"
#include "core/reduction/superelement/plate_body.hpp"
#include "core/reduction/superelement/superelement.hpp"

namespace flexopt {

/// Elements of a superelement's own mesh: its share of the leaf's, four at least. The field between
/// so few nodes is smooth; the corners of a patch want the four.
int own_elements(int of_leaf, int superelements);

/// `across` = 0: segments of two nodes between rigid lines; else patches of four nodes. A beam is
/// cut into segments, free to warp where there are several.
class SuperelementGrid {
 public:
  SuperelementGrid(const LeafSpring& leaf, const ModelOptions& model);

  int along() const { return along_; }
  int rows() const { return std::max(across_, 1); }  ///< superelements across
  int lines() const { return along_ + 1; }
  int nodes_per_line() const { return across_ + 1; }
  int elements() const { return along_ * rows(); }
  /// Line and node of the superelement's k-th node.
  struct Node {
    int line, node;
  };
  Node node(int element, int k) const;
  int nodes_per_element() const { return across_ == 0 ? 2 : 4; }
  /// Place of a node across [m].
  double y(int node) const { return across_ == 0 ? 0 : width_ * (node / double(across_) - 0.5); }
  /// Place of a line along [m].
  double x(int line) const { return length_ * line / along_; }

  const PlateShape& shape() const { return shape_; }  ///< of the whole leaf
  /// Mesh of the whole leaf at full accuracy, made when first asked for.
  std::shared_ptr<const PlateMesh> full_mesh() const;
  const CondensedPlate& plate(int element) const { return *kinds_[kind(element % rows())]; }
  const SuperelementModel& model(int element) const { return plate(element).superelement; }
  /// Whether the grid was made for such a leaf.
  bool fits(const LeafSpring& leaf, const ModelOptions& model) const;

  /// Local coordinates and frames of all superelements, in their order.
  struct State {
    std::vector<const VectorXd*> q;
    std::vector<const NodePose*> frames;
  };
  /// Nodal displacements of a superelement over its length, in its frame.
  std::vector<MatrixXd> displacements(const State& state, int element) const;
  /// Linear strains of the local displacements of a plate; lengths over L, as in plate_stress.
  StrainField strains(const State& state) const;
  /// Where a point of the leaf lies: all coordinates in [0, 1].
  struct Point {
    int element;
    double along, across;  ///< in it
  };
  Point locate(double along, double across) const;
  /// Deflected place of a point of the mid-surface, each coordinate in [0, 1].
  Vector3d place(const State& state, double along, double across) const;
  /// Stations of the meshes of all superelements, in [0, 1].
  std::vector<double> stations_along() const;
  std::vector<double> stations_across() const;

 private:
  int kind(int row) const;
  int along_, across_;
  double length_, width_;
  PlateShape shape_;  ///< of the whole leaf
  double youngs_modulus_, density_;
  int modes_;  ///< vibration modes of a superelement: together as many as a leaf is to have
  std::vector<std::shared_ptr<const CondensedPlate>> kinds_;  ///< by free edges
  mutable std::once_flag full_mesh_made_;
  mutable std::shared_ptr<const PlateMesh> full_mesh_;
};

/// A node's share in the displacement of a leaf's material point.
struct NodeShare {
  SuperelementGrid::Node node;
  double weight;
};
/// Shares of the nodes in the material point of a leaf, empty where it has none. A force spread
/// over a free tip goes to its nodes by their share of the width.
std::vector<NodeShare> point_shares(const LeafSpring& leaf, const SuperelementGrid& grid);

}  // namespace flexopt
