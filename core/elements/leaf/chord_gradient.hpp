#pragma once
// The share of its edges in exact gradients of a leaf whose energy is a function of the
// deformations e of the chord frame and of unknowns a of its own. Equations (G2), (G3) of
// core/reduction/README.md. Leaf axes, lengths over L; vectors are those of LeafRows.
#include <array>
#include <optional>
#include <vector>

#include "core/elements/leaf/chord_frame.hpp"
#include "core/elements/leaf/chord_path.hpp"
#include "core/elements/leaf/leaf_gradient.hpp"

namespace flexopt {

class ChordGradient {
 public:
  /// Derivatives of the energy.
  struct Energy {
    VectorXd force;        ///< by (e, a)
    MatrixXd tangent;      ///< of that, by (e, a)
    MatrixXd shape_force;  ///< of that, by w/L, t/L and ν
  };

  ChordGradient() = default;
  /// Gradient between these edges, with their frame.
  ChordGradient(const ChordFrame& frame, const EdgePoses& edges, const LeafRows& rows,
                Energy energy);

  const Energy& energy() const { return energy_; }
  /// LeafGradient::force and force_rates.
  VectorXd force() const;
  MatrixXd force_rates(const std::vector<LeafVariation<double>>& variations) const;
  /// (displacement, spin) of the edges as a variation alone moves them; the arms' rates.
  Vector12d edge_moves(const LeafVariation<double>& v, std::array<Vector3d, 2>& lever) const;

  /// A column of increments, with the resulting motion of the frame and of e.
  struct Column {
    std::array<Vector3d, 2> spin;  ///< of the edges, like the next two in the axes of the frame
    Vector3d apart, base;          ///< displacement of the tip less that of the base, of the base
    chord::FramePath<double> path;
    Vector6d e1, e2;  ///< e′ and e″
  };
  /// (displacement, spin) of both edges.
  Column column(const Vector12d& edges) const;

  /// Covectors of e, e′, e″ and the frame's spin along a column, to those of e and of what the
  /// frame sees of the edges: (e, spin of the base, of the tip, apart).
  using Seen = Eigen::Matrix<double, 15, 1>;
  Seen seen(const Column& column, const std::array<Vector6d, 3>& of_e,
            const Vector3d& of_spin) const;

  /// Adds to the column k of q what `seen` and the covector of Column::base make of the edges and
  /// their increments, and the share of the lever arms that turn. Y: rows of the bodies.
  void add(const MatrixXd& Y, int k, const Column& column, const Seen& seen,
           const Vector3d& by_base, LeafQuadratic<double>& q) const;

 private:
  const ChordFrame* frame_ = nullptr;
  EdgePoses edges_;
  LeafRows rows_;
  Energy energy_;
  /// Rotations of both edges in the frame; none for a default one.
  std::optional<std::array<chord::Turn<double>, 2>> turns_;
  /// Second derivatives of Turn::a and Turn::b in |θ|², of both edges.
  std::array<std::array<double, 2>, 2> curvature_{};
  Vector12d edge_force_;
  Matrix12d edge_stiffness_;  ///< what that changes by at constant forces of e
};

}  // namespace flexopt
