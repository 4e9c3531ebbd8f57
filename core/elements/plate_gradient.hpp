#pragma once
// What the force and the quadratic forms yᵀK y, yᵀM y of a full leaf change by when its state, its
// shape or the place of its edges changes: the leaf's share of every exact gradient. Scaled units
// of plate_mesh.hpp; equations (26)–(29) of core/response/README.md. S: double at one state, Jet
// along a path of states.
#include <array>
#include <memory>
#include <vector>

#include "core/elements/leaf_rows.hpp"
#include "core/elements/plate_leaf.hpp"
#include "core/elements/plate_mesh_rate.hpp"
#include "core/math/jet.hpp"

namespace flexopt {

/// How a leaf moves with a design parameter while the displacements and rotations of its bodies,
/// its internal unknowns and all increments keep their numbers. In leaf axes over L.
template <class S>
struct LeafVariation {
  double energy = 0, mass = 0;        ///< of LeafScale, relative
  Vector3d shape = Vector3d::Zero();  ///< of w/L, t/L, ν
  Matrix3d turn = Matrix3d::Zero();   ///< Ȧᵀ A of the leaf axes A: increments turn by it
  double length = 0;                  ///< L̇/L
  Eigen::Vector2d point{0, 0};        ///< of the place (along, across) of the material point
  struct Edge {
    Vector3<S> position = Vector3<S>::Zero();  ///< of the body's reference point
    Matrix3<S> rotation = Matrix3<S>::Zero();  ///< of the body's rotation seen in leaf axes
    Vector3d arm = Vector3d::Zero();           ///< from reference point to edge, undeflected
  };
  std::array<Edge, 2> edge;  ///< zero where the edge is grounded
};

/// Where a leaf is, as PlateLeaf has it.
template <class S>
struct PlateGradientState {
  std::array<Matrix3<S>, 2> axes;  ///< of the edges
  Eigen::VectorX<S> x;
  Vector3<S> point, point_force;
  std::vector<Eigen::MatrixX<S>> nodal;  ///< of every line
};
PlateGradientState<double> present_state(const PlateLeaf& plate);

/// A full leaf between two rigid edges (or with a free tip) at an assembled state. Vectors are
/// those of LeafRows.
template <class S>
class PlateGradient {
 public:
  using Vector = Eigen::VectorX<S>;
  using Matrix = Eigen::MatrixX<S>;
  /// The path, if any, starts at the present state of the plate.
  PlateGradient(const PlateLeaf& plate, std::shared_ptr<const PlateMeshRate> rate,
                const LeafRows& rows, PlateGradientState<S> state);

  int size() const { return rows_.size(); }

  /// Residual of every row.
  const Vector& force() const { return force_; }
  /// Its derivatives along the variations, scales apart: size × variations.
  Matrix force_rates(const std::vector<LeafVariation<S>>& variations) const;

  /// Rates of the nodal dofs, per line functions × (3 components of each column), of states moving
  /// by the columns of Y along the variations.
  std::vector<Matrix> nodal_rates(const Matrix& Y,
                                  const std::vector<LeafVariation<S>>& variations) const;

  /// q = yᵀ(K − μ M) y for each column y of Y, and its derivatives at constant y and μ. Rotations
  /// are varied as exp(hat δ) R of the varied R.
  struct Quadratic {
    Vector stiffness, mass;    ///< yᵀK y, yᵀM y
    Matrix state;              ///< size × columns
    Eigen::Matrix3X<S> shape;  ///< of w/L, t/L, ν: operators only
    Eigen::Matrix2X<S> point;  ///< along the place of the material point
    struct Edge {
      Matrix3<S> rotation;            ///< ∂q/∂(rotation of the edge's axes)
      Vector3<S> position, arm;       ///< ∂q/∂(place of the body), (arm, in edge axes)
      Vector3<S> displacement, spin;  ///< ∂q/∂(increments of the body)
      S across = 0;                   ///< along the places of the nodes across, relative
    };
    std::vector<std::array<Edge, 2>> edge;  ///< per column
  };
  Quadratic quadratic(const Matrix& Y, const Vector& mu) const;
  /// Derivative of q of a column along a variation, scales apart.
  S rate(const Quadratic& q, const Matrix& Y, int column, const LeafVariation<S>& v) const;

 private:
  struct EdgeNodes {
    int line = 0;
    Matrix3<S> axes;
    std::vector<Vector3<S>> local, arm;  ///< w and v = R w of every function
  };
  bool is_rigid(int line) const { return edge_at(line) >= 0; }
  int edge_at(int line) const;
  template <int Side>
  void prepare();
  template <int Side>
  void quadratic_elements(const std::vector<Matrix>& N1, const std::array<Matrix, 2>& N2,
                          const Vector& mu, Quadratic& q, std::vector<Matrix>& n0,
                          std::array<Matrix, 2>& n1) const;
  /// N′ of a line for states moving by the columns of Y: functions × (3 components of each).
  Matrix line_rates(int line, const Matrix& Y) const;
  void add_point_force();
  void add_point_rates(const std::array<Matrix, 2>& edge_rates,
                       const std::vector<LeafVariation<S>>& variations, Matrix& rows) const;
  void add_point_quadratic(const Matrix& Y, const std::vector<Matrix>& N1,
                           const std::array<Matrix, 2>& N2, Quadratic& q,
                           std::array<Matrix, 2>& n1) const;
  void add_to_rows(int line, const Matrix& nodal, Matrix& rows) const;
  std::array<Matrix, 2> edge_nodal_rates(const std::vector<LeafVariation<S>>& variations) const;

  const PlateLeaf* plate_;
  const PlateMesh* mesh_;
  std::shared_ptr<const PlateMeshRate> rate_;
  LeafRows rows_;
  PlateGradientState<S> state_;
  std::array<bool, 2> rigid_{true, true};
  std::array<EdgeNodes, 2> edges_;
  std::vector<Eigen::Matrix<S, 16, 3>> a0_;                         ///< gradients at the points
  std::vector<Eigen::Array<S, PlateMesh::points, 3>> strain_, n0_;  ///< and stresses × weight
  std::vector<Matrix> nodal_force_;                                 ///< per line, n × 3
  std::array<std::vector<Matrix>, 3> shape_force_;  ///< derivative of it in w/L, t/L, ν
  Vector force_;
};

extern template class PlateGradient<double>;
extern template class PlateGradient<Jet>;

}  // namespace flexopt
