#pragma once
// The share of a ModalLeaf in exact gradients: its internal unknowns are the amplitudes, and the
// plate follows them and the chord frame through (M6) or (M8). Equations (M12), (M13) of
// core/reduction/modal/README.md.
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/plate/plate_gradient.hpp"
#include "core/reduction/frame/chord_gradient.hpp"
#include "core/reduction/modal/modal_leaf.hpp"
#include "core/reduction/modal/modal_model_rate.hpp"

namespace flexopt {

/// Of an evaluated leaf, which must outlive it.
class ModalLeafGradient final : public LeafGradient<double> {
 public:
  ModalLeafGradient(const ModalLeaf& leaf, std::shared_ptr<const ModalModelRate> rate,
                    const LeafRows& rows);

  MatrixXd force_rates(const std::vector<LeafVariation<double>>& variations) const override {
    return chord_.force_rates(variations);
  }
  LeafQuadratic<double> quadratic(const MatrixXd& Y, const VectorXd& mu) const override;

  std::unique_ptr<LeafFields> fields(
      const MatrixXd& rows, const std::vector<LeafVariation<double>>& variations) const override;

 private:
  using Lines = std::vector<MatrixXd>;  ///< nodal values: per line functions × 3
  /// Rates of the nodes in leaf axes, of a state that moves by y along the variation.
  Lines nodal_rates(const VectorXd& y, const LeafVariation<double>& variation) const;

  VectorXd pairs(const MatrixXd& theta, const Vector6d& a, const Vector6d& b) const;
  MatrixXd slopes(int edge, const VectorXd& x) const;
  void add_to_slopes(int edge, const MatrixXd& w, VectorXd& x) const;
  MatrixXd across() const;
  std::array<VectorXd, 2> chart(const MatrixXd& X, const MatrixXd& theta, const MatrixXd& fields,
                                const Vector6d& e1, const Vector6d& e2, const VectorXd& a1) const;
  Lines lines(const std::array<MatrixXd, 2>& edges, const VectorXd& x,
              const MatrixXd& follow) const;
  /// Covectors of the lines between, and what the edges' nodes get of them: n3 × 2.
  VectorXd inner(const Lines& c) const;
  MatrixXd followed(const Lines& c) const;
  /// Derivatives in the shape: of the nodes at constant e and a, and of the generalised force.
  void set_shape_rates();
  MatrixXd shape_force() const;
  struct Path;
  struct Covectors;
  struct Pulled;
  /// Derivatives along e and what the chord frame sees of the edges, in its axes: their spins and
  /// the difference of their displacements.
  using Seen = ChordGradient::Seen;
  Path path_along(const VectorXd& y) const;  ///< of (amplitudes, edges)
  Covectors pulled_back(const std::array<Lines, 3>& c, const Path& p, Eigen::Ref<Vector3d> shape,
                        VectorXd& amplitudes) const;
  Seen seen_by_frame(const Covectors& c, const Path& p) const;
  Pulled pulled_back(const Path& p, const Lines& N1, const Lines& n0, const Lines& n1, double mu,
                     double& mass, Eigen::Ref<Vector3d> shape) const;
  void add_mass(const Lines& N, double mu, double& mass, Eigen::Ref<Vector3d> shape,
                Lines& n) const;

  const ModalLeaf* leaf_;
  const ModalModel* model_;
  const PlateMesh* mesh_;
  std::shared_ptr<const ModalModelRate> rate_;
  PlateGradient<double> plate_;
  int m_, u_, n_, functions_;
  std::array<Matrix3d, 2> axes_;   ///< of the edges in the chord frame
  std::array<MatrixXd, 2> local_;  ///< nodes of the edges in their axes, functions × 3
  std::array<VectorXd, 3> chart_rates_, follow_rates_;  ///< of x, and what the lines follow more
  std::array<Lines, 3> node_rates_;
  ChordGradient chord_;
};

}  // namespace flexopt
