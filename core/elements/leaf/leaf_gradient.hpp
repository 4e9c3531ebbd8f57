#pragma once
// What a leaf's force and quadratic forms yᵀK y, yᵀM y change by when its state, its shape or the
// place of its edges changes: the leaf's share of every exact gradient, whichever model it is.
// Equations (S6)–(S12) of core/response/README.md. Leaf axes, lengths over L, energies over D,
// masses over ρ t L⁴; vectors are those of LeafRows. S: double at one state, Jet along a path of
// states.
#include <array>
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_fields.hpp"
#include "core/elements/leaf/leaf_rates.hpp"
#include "core/elements/leaf/leaf_rows.hpp"
#include "core/math/jet.hpp"

namespace flexopt {

/// How a leaf moves with a design parameter while the displacements and rotations of its bodies,
/// its internal unknowns and all increments keep their numbers. In leaf axes over L.
template <class S>
struct LeafVariation {
  double energy = 0, mass = 0;                             ///< of LeafScale, relative
  VectorXd shape = VectorXd::Zero(ShapeParameter::sizes);  ///< of every ShapeParameter
  Matrix3d turn = Matrix3d::Zero();  ///< Ȧᵀ A of the leaf axes A: increments turn by it
  double length = 0;                 ///< L̇/L
  Eigen::Vector2d point{0, 0};       ///< of the place (along, across) of the material point
  struct Edge {
    Vector3<S> position = Vector3<S>::Zero();  ///< of the body's reference point
    Matrix3<S> rotation = Matrix3<S>::Zero();  ///< of the body's rotation seen in leaf axes
    Vector3d arm = Vector3d::Zero();           ///< from reference point to edge, undeflected
  };
  /// Motion of each edge with its body: zero where the edge is grounded, except for the edges of an
  /// arc. Rotation and arm refer to the axes of the edge.
  std::array<Edge, 2> edge;
};

/// q = yᵀ(K − μ M) y for each column y of Y, and its derivatives at constant y and μ. Rotations are
/// varied as exp(hat δ) R of the varied R.
template <class S>
struct LeafQuadratic {
  Eigen::VectorX<S> stiffness, mass;           ///< yᵀK y, yᵀM y
  Eigen::MatrixX<S> state;                     ///< size × columns
  Eigen::MatrixX<S> shape;                     ///< of every ShapeParameter: operators only
  Eigen::Matrix2X<S> point;                    ///< along the place of the material point
  Eigen::Matrix3X<S> weight;                   ///< along that of the gradient
  struct Edge {                                ///< zero where the edge is free
    Matrix3<S> rotation = Matrix3<S>::Zero();  ///< ∂q/∂(rotation of the edge's axes)
    /// ∂q/∂(place of the body), (arm, in edge axes)
    Vector3<S> position = Vector3<S>::Zero(), arm = Vector3<S>::Zero();
    /// ∂q/∂(increments of the body)
    Vector3<S> displacement = Vector3<S>::Zero(), spin = Vector3<S>::Zero();
    S across = 0;  ///< along the places of the nodes across, relative
  };
  std::vector<std::array<Edge, 2>> edge;  ///< per column

  LeafQuadratic(int size, int columns, int parameters = ShapeParameter::sizes)
      : stiffness(Eigen::VectorX<S>::Zero(columns)),
        mass(Eigen::VectorX<S>::Zero(columns)),
        state(Eigen::MatrixX<S>::Zero(size, columns)),
        shape(Eigen::MatrixX<S>::Zero(parameters, columns)),
        point(Eigen::Matrix2X<S>::Zero(2, columns)),
        weight(Eigen::Matrix3X<S>::Zero(3, columns)),
        edge(static_cast<std::size_t>(columns)) {}
};

template <class S>
class LeafGradient {
 public:
  using Vector = Eigen::VectorX<S>;
  using Matrix = Eigen::MatrixX<S>;

  virtual ~LeafGradient() = default;

  int size() const { return rows_.size(); }
  double width() const { return width_; }  ///< w/L
  /// Residual, one entry for each row.
  const Vector& force() const { return force_; }
  /// Derivatives of the residual along the variations, at constant scales: size × variations.
  virtual Matrix force_rates(const std::vector<LeafVariation<S>>& variations) const = 0;
  virtual LeafQuadratic<S> quadratic(const Matrix& Y, const Vector& mu) const = 0;
  /// Derivatives along the state alone, of μ = 0: LeafQuadratic::state.
  virtual Matrix state_rates(const Matrix& Y) const {
    return quadratic(Y, Vector::Zero(Y.cols())).state;
  }
  /// Derivatives of the fields along every variation; for each variation the state moves by one
  /// column of `rows`. None for series.
  virtual std::unique_ptr<LeafFields> fields(
      const Matrix& rows, const std::vector<LeafVariation<S>>& variations) const = 0;
  /// Derivatives of the field of the motion y, rows of the leaf whose increments are held in global
  /// axes and metres, likewise: place_rates() are those of the motion over L, seen from the leaf's
  /// axes. None unless the leaf is a full plate or beam without fold.
  virtual std::unique_ptr<LeafFields> motion_fields(
      const Vector& /*y*/, const Matrix& /*rows*/,
      const std::vector<LeafVariation<S>>& /*variations*/) const {
    return nullptr;
  }
  /// Derivatives of q of every column along every variation, scales apart: columns × variations.
  Matrix rates(const LeafQuadratic<S>& q, const Matrix& Y,
               const std::vector<LeafVariation<S>>& variations) const;

 protected:
  /// `width`: w/L.
  LeafGradient(const LeafRows& rows, double width) : rows_(rows), width_(width) {}

  /// Derivative of the scaled weight along a variation. The weight of the mass stays constant in
  /// global axes.
  Vector3d weight_rate(const LeafVariation<S>& v) const {
    return v.turn * weight_ + (v.mass - v.length - v.energy) * weight_;
  }

  LeafRows rows_;
  double width_;
  Vector3d weight_ = Vector3d::Zero();  ///< dead force per mass, as PlateLeaf has it
  Vector force_;
};

extern template class LeafGradient<double>;
extern template class LeafGradient<Jet>;

}  // namespace flexopt
