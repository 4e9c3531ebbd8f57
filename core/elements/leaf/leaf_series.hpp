#pragma once
// A leaf along a path of states r(s) = r0 + r1 s + r2 s²: force, tangent stiffness and mass as
// power series in s, exact to s². Leaf axes, lengths over L, energies over D, masses over ρ t L⁴.
#include <array>
#include <memory>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/leaf/leaf_rates.hpp"
#include "core/elements/leaf/leaf_rows.hpp"
#include "core/math/series.hpp"

namespace flexopt {

/// The body that holds an edge, in leaf axes over L: place of its reference point, rotation since
/// the undeflected state, and the arm to the middle of the undeflected edge. Increments of an edge
/// are those of its body: (displacement of the reference point, spin).
struct EdgeBodySeries {
  Series<Vector3d> position;
  Series<Matrix3d> rotation;
  Vector3d arm;
};

/// Vectors of a leaf are those of LeafRows.
class LeafSeries {
 public:
  virtual ~LeafSeries() = default;

  virtual const LeafRows& rows() const = 0;
  int size() const { return rows().size(); }
  /// State at the start of the path: internal unknowns, and the force at the material point.
  virtual VectorXd unknowns() const = 0;
  virtual Vector3d point_force() const = 0;

  /// `point`: displacement of the material point and the force there.
  struct PointSeries {
    Series<Vector3d> displacement, force;
  };
  virtual void expand(const std::array<EdgeBodySeries, 2>& edges, const Series<VectorXd>& x,
                      const PointSeries& point) = 0;

  /// Residual of every row at the expanded path.
  virtual Series<VectorXd> force() const = 0;
  /// K(s) Y and M(s) Y of constant columns Y, the lowest `orders` of them (others are empty);
  /// rotations varied as exp(hat δ) R(s).
  virtual Series<MatrixXd> tangent_times(const MatrixXd& Y, int orders = 3) const = 0;
  virtual Series<MatrixXd> mass_times(const MatrixXd& Y, int orders = 3) const = 0;
  /// The share in exact gradients along the expanded path, with vectors as `rows` says.
  virtual std::unique_ptr<LeafGradient<Jet>> gradient(LeafRates& rates,
                                                      const LeafRows& rows) const = 0;
};

}  // namespace flexopt
