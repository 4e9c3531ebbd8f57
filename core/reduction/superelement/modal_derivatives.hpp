#pragma once
// Modal derivatives: how the boundary modes of a leaf change when it is deformed. Exact, from the
// polynomial energy of the leaf. Scaled units of plate_mesh.hpp; equations (M1)–(M5) of
// core/reduction/superelement/README.md.
#include <memory>
#include <utility>

#include "core/elements/leaf/chord_edges.hpp"
#include "core/elements/leaf/chord_frame.hpp"
#include "core/elements/plate/plate_leaf.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// Place of the pair (i, j) = (j, i) in lists of pairs: (0,0), (0,1), (1,1), (0,2), …
inline int pair_index(int i, int j) {
  if (i > j) std::swap(i, j);
  return j * (j + 1) / 2 + i;
}

/// K2[φi, φj] = (∂K/∂φj) φi of every pair of shapes, about the present state of the leaf, by
/// polarisation of the residual along paths x0 + s φ. Shapes and result have rows (unknowns of
/// PlateLeaf, displacement and rotation vector of base and tip edge); rotation vectors are added to
/// those of the state by exp(hat θ) R, so that K2[φi, φj]·φk is symmetric in all three.
MatrixXd second_order_forces(const PlateLeaf& leaf, const MatrixXd& shapes);

/// Craig–Bampton boundary modes Φ_CB: rows as above, a column for each of the 12 edge coordinates.
/// The leaf must be assembled.
MatrixXd boundary_modes(const PlateLeaf& leaf);

/// θij = −K⁻¹ K2[φi, φj] with both edges held: rows of the unknowns, a column a pair. `forces`:
/// K2. The leaf must be assembled.
MatrixXd derivatives_edges_held(const PlateLeaf& leaf, const MatrixXd& forces);

/// The fields of all leaves of one shape. The unknowns x of the plate are the slopes σ of the edges
/// and the interior lines y; b are the nodal values of the edges' lines, exactly where e and σ put
/// them, and X_b the static shapes of the lines between:
///
///     σ = σ0 + X e + Ψ a,   y = y0 + X_b (b(e, σ) − b0) + Ψ′ a        (modal_derivatives)
///     σ = σ0 + X e + ½ θij ei ej,   y = … + ½ θ′ij ei ej                (quadratic_manifold)
class ModalModel {
 public:
  ModalModel(std::shared_ptr<const PlateMesh> mesh, Reduction method, ModalDerivativeSet set);

  const std::shared_ptr<const PlateMesh>& mesh() const { return mesh_; }
  bool slaved() const { return slaved_; }
  int amplitudes() const { return static_cast<int>(fields_.cols()); }  ///< none where slaved

  /// Unknowns and linear rates about a state given by e and the amplitudes.
  VectorXd unknowns(const Vector6d& e, const EdgePoses& edges, const VectorXd& amplitudes) const;
  /// d(unknowns)/d(e, amplitudes), what the lines between follow of the edges still left out.
  MatrixXd chart_rates(const Vector6d& e) const;
  /// θ of the chart: Σ_ij ei ej θij / 2 is what `unknowns` adds; unknowns × 21 (pair_index).
  const MatrixXd& derivatives() const { return theta_; }
  const MatrixXd& line_shapes() const { return follow_; }  ///< X_b
  int slopes() const { return slopes_; }                   ///< of one edge

 private:
  VectorXd edge_nodal(const EdgePoses& edges, const VectorXd& x) const;
  MatrixXd derivatives_times(const Vector6d& e) const;  ///< Σ_j ej θij, a column i

  std::shared_ptr<const PlateMesh> mesh_;
  bool slaved_;
  int slopes_;
  VectorXd rest_, edges_at_rest_;
  MatrixXd follow_;  ///< X_b
  MatrixXd modes_;   ///< X; zero in the interior
  MatrixXd theta_;
  MatrixXd fields_;  ///< Ψ, Ψ′; whole fields orthonormal in energy at rest
};

}  // namespace flexopt
