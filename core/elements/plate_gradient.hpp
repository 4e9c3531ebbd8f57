#pragma once
// What the force and the quadratic forms yᵀK y, yᵀM y of a full leaf change by when its state, its
// shape or the place of its edges changes: the leaf's share of every exact gradient. Scaled units
// of plate_mesh.hpp; equations (26)–(29) of core/response/README.md.
#include <array>
#include <memory>

#include "core/elements/leaf_rows.hpp"
#include "core/elements/plate_leaf.hpp"
#include "core/elements/plate_mesh_rate.hpp"

namespace flexopt {

/// How a leaf moves with a design parameter while the displacements and rotations of its bodies,
/// its internal unknowns and all increments keep their numbers. In leaf axes over L.
struct LeafVariation {
  double energy = 0, mass = 0;        ///< of LeafScale, relative
  Vector3d shape = Vector3d::Zero();  ///< of w/L, t/L, ν
  Matrix3d turn = Matrix3d::Zero();   ///< Ȧᵀ A of the leaf axes A: increments turn by it
  double length = 0;                  ///< L̇/L
  Eigen::Vector2d point{0, 0};        ///< of the place (along, across) of the material point
  struct Edge {
    Vector3d position = Vector3d::Zero();  ///< of the body's reference point
    Matrix3d rotation = Matrix3d::Zero();  ///< of the body's rotation seen in leaf axes
    Vector3d arm = Vector3d::Zero();       ///< from reference point to edge, undeflected
  };
  std::array<Edge, 2> edge;  ///< zero where the edge is grounded
};

/// A full leaf between two rigid edges (or with a free tip) at an assembled state. Vectors are
/// those of LeafRows.
class PlateGradient {
 public:
  PlateGradient(const PlateLeaf& plate, std::shared_ptr<const PlateMeshRate> rate,
                const LeafRows& rows);

  int size() const { return rows_.size(); }

  /// Residual of every row.
  const VectorXd& force() const { return force_; }
  /// Its derivatives along the variations, scales apart: size × variations.
  MatrixXd force_rates(const std::vector<LeafVariation>& variations) const;

  /// Rates of the nodal dofs, per line functions × (3 components of each column), of states moving
  /// by the columns of Y along the variations.
  std::vector<MatrixXd> nodal_rates(const MatrixXd& Y,
                                    const std::vector<LeafVariation>& variations) const;

  /// q = yᵀ(K − μ M) y for each column y of Y, and its derivatives at constant y and μ. Rotations
  /// are varied as exp(hat δ) R of the varied R.
  struct Quadratic {
    VectorXd stiffness, mass;  ///< yᵀK y, yᵀM y
    MatrixXd state;            ///< size × columns
    Eigen::Matrix3Xd shape;    ///< of w/L, t/L, ν: operators only
    Eigen::Matrix2Xd point;    ///< along the place of the material point
    struct Edge {
      Matrix3d rotation;            ///< ∂q/∂(rotation of the edge's axes)
      Vector3d position, arm;       ///< ∂q/∂(place of the body), (arm, in edge axes)
      Vector3d displacement, spin;  ///< ∂q/∂(increments of the body)
      double across = 0;            ///< along the places of the nodes across, relative
    };
    std::vector<std::array<Edge, 2>> edge;  ///< per column
  };
  Quadratic quadratic(const MatrixXd& Y, const VectorXd& mu) const;
  /// Derivative of q of a column along a variation, scales apart.
  double rate(const Quadratic& q, const MatrixXd& Y, int column, const LeafVariation& v) const;

 private:
  struct EdgeNodes {
    int line = 0;
    Matrix3d axes;
    std::vector<Vector3d> local, arm;  ///< w and v = R w of every function
  };
  bool is_rigid(int line) const { return edge_at(line) >= 0; }
  int edge_at(int line) const;
  template <int Side>
  void prepare();
  template <int Side>
  MatrixXd tangent_on_edges(const std::array<MatrixXd, 2>& nodal, int columns) const;
  template <int Side>
  void quadratic_elements(const std::vector<MatrixXd>& N1, const std::array<MatrixXd, 2>& N2,
                          const VectorXd& mu, Quadratic& q, std::vector<MatrixXd>& n0,
                          std::array<MatrixXd, 2>& n1) const;
  void add_point_force();
  void add_point_rates(const std::array<MatrixXd, 2>& edge_rates,
                       const std::vector<LeafVariation>& variations, MatrixXd& rows) const;
  void add_point_quadratic(const MatrixXd& Y, const std::vector<MatrixXd>& N1,
                           const std::array<MatrixXd, 2>& N2, Quadratic& q,
                           std::array<MatrixXd, 2>& n1) const;
  void add_to_rows(int line, const MatrixXd& nodal, MatrixXd& rows) const;
  std::array<MatrixXd, 2> edge_nodal_rates(const std::vector<LeafVariation>& variations) const;

  const PlateLeaf* plate_;
  const PlateMesh* mesh_;
  std::shared_ptr<const PlateMeshRate> rate_;
  LeafRows rows_;
  std::array<bool, 2> rigid_{true, true};
  std::array<EdgeNodes, 2> edges_;
  std::vector<Eigen::Matrix<double, 16, 3>> a0_;  ///< gradients at the points
  std::vector<Eigen::Array<double, PlateMesh::points, 3>> strain_, n0_;  ///< and stresses × weight
  std::vector<MatrixXd> nodal_force_;                                    ///< per line, n × 3
  std::array<std::vector<MatrixXd>, 3> shape_force_;  ///< derivative of it in w/L, t/L, ν
  VectorXd force_;
};

}  // namespace flexopt
