#pragma once
// The share of a full leaf in exact gradients. Equations (S6)–(S9) and (S12) of
// core/response/README.md.
#include <array>
#include <memory>
#include <vector>

#include "core/elements/leaf/leaf_gradient.hpp"
#include "core/elements/plate/plate_leaf.hpp"
#include "core/elements/plate/plate_mesh_rate.hpp"

namespace flexopt {

/// State of a leaf, as PlateLeaf stores it.
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
class PlateGradient final : public LeafGradient<S> {
 public:
  using typename LeafGradient<S>::Vector;
  using typename LeafGradient<S>::Matrix;
  using LeafGradient<S>::size;

  /// The path, if any, starts at the present state of the plate.
  PlateGradient(const PlateLeaf& plate, std::shared_ptr<const PlateMeshRate> rate,
                const LeafRows& rows, PlateGradientState<S> state);

  Matrix force_rates(const std::vector<LeafVariation<S>>& variations) const override;

  LeafQuadratic<S> quadratic(const Matrix& Y, const Vector& mu) const override {
    return quadratic(Y, mu, directions());
  }
  Matrix state_rates(const Matrix& Y) const override {
    return quadratic(Y, Vector::Zero(Y.cols()), 0).state;
  }
  std::unique_ptr<LeafFields> fields(
      const Matrix& rows, const std::vector<LeafVariation<S>>& variations) const override;
  std::unique_ptr<LeafFields> motion_fields(
      const Vector& y, const Matrix& rows,
      const std::vector<LeafVariation<S>>& variations) const override;

 private:
  using LeafGradient<S>::rows_;
  using LeafGradient<S>::force_;
  using LeafGradient<S>::weight_;
  struct EdgeNodes {
    int line = 0;
    Matrix3<S> axes;
    std::vector<Vector3<S>> local, arm;  ///< w and v = R w of every function
  };
  int edge_at(int line) const;
  /// Rates of the nodal values behind a fold that opens: functions × (3 components of each).
  Matrix fold_nodal_rates(const std::vector<LeafVariation<S>>& variations) const;
  /// Derivative of the angle of the fold along a variation.
  double fold_rate(const LeafVariation<S>& v) const;
  /// The block of a fold, of some vector.
  auto fold_block(const Vector& x) const {
    return x.segment(plate_->block_offset(mesh_->fold_line()), plate_->fold_unknowns());
  }
  /// Terms of the line behind the fold. add_fold_rows(): rows += Jᵀ nodal. set_fold_rates(): the
  /// r,x and r,xy of N for states that move by Y.
  void add_fold_rows(const Matrix& nodal, Matrix& rows) const;
  void set_fold_rates(const Matrix& Y, Matrix& N) const;
  void add_fold_force_rates(const std::vector<LeafVariation<S>>& variations, Matrix& rows) const;
  void add_fold_second(const Matrix& Y, std::vector<Matrix>& N2, std::vector<Matrix>& n1) const;
  void add_fold_quadratic(const Matrix& Y, const std::vector<Matrix>& n0,
                          const std::vector<Matrix>& n1, LeafQuadratic<S>& q) const;
  int directions() const { return rate_->directions(); }
  /// With derivatives along so many of the directions of the shape, from the first.
  LeafQuadratic<S> quadratic(const Matrix& Y, const Vector& mu, int shape) const;
  template <int Side>
  void prepare();
  template <int Side>
  void quadratic_elements(const std::vector<Matrix>& N1, const std::vector<Matrix>& N2,
                          const Vector& mu, LeafQuadratic<S>& q, std::vector<Matrix>& n0,
                          std::vector<Matrix>& n1) const;
  /// Adds K N′, which only the elements at the edges and behind a fold feel.
  template <int Side>
  void add_tangent_times(const std::array<Matrix, 2>& edges, const Matrix& fold,
                         std::vector<Matrix>& force) const;
  /// N′ of a line for states moving by the columns of Y: functions × (3 components of each).
  Matrix line_rates(int line, const Matrix& Y) const;
  Matrix second_nodes(int edge, const Matrix& Y) const;  ///< N2 of the edge: n × (3 per column)
  void add_edge_quadratic(int edge, const Matrix& Y, const Matrix& n0, const Matrix& n1,
                          LeafQuadratic<S>& q) const;
  /// Adds what N1 of an edge's nodes changes by while these move by `nodes`.
  void add_edge_motion_rates(int edge, const Vector& y, const Matrix& rows, const Matrix& nodes,
                             const std::vector<LeafVariation<S>>& variations, Matrix& rates) const;
  void add_point_force();
  void add_weight();
  void add_point_rates(const std::array<Matrix, 2>& edge_rates,
                       const std::vector<LeafVariation<S>>& variations, Matrix& rows) const;
  void add_point_quadratic(const Matrix& Y, const std::vector<Matrix>& N1,
                           const std::vector<Matrix>& N2, LeafQuadratic<S>& q,
                           std::vector<Matrix>& n1) const;
  void add_edge_force_rates(int edge, const Matrix& edge_rates,
                            const std::vector<LeafVariation<S>>& variations, Matrix& rows) const;
  void add_weight_quadratic(const std::vector<Matrix>& N2, LeafQuadratic<S>& q) const;
  /// Factor of the clamp on a function of an edge node.
  double held(int edge, int function) const { return function % 2 == 0 ? plate_->clamp(edge) : 1; }
  void add_to_rows(int line, const Matrix& nodal, Matrix& rows) const;
  std::array<Matrix, 2> edge_nodal_rates(const std::vector<LeafVariation<S>>& variations) const;

  const PlateLeaf* plate_;
  const PlateMesh* mesh_;
  std::shared_ptr<const PlateMeshRate> rate_;
  PlateGradientState<S> state_;
  std::array<bool, 2> rigid_{true, true};
  std::array<EdgeNodes, 2> edges_;
  std::vector<Eigen::Matrix<S, 16, 3>> a0_;                         ///< gradients at the points
  std::vector<Eigen::Array<S, PlateMesh::points, 3>> strain_, n0_;  ///< and stresses × weight
  std::vector<Matrix> natural_;      ///< of a curved leaf: the field of plate_curvature.hpp
  std::vector<Matrix> nodal_force_;  ///< per line, n × 3
  std::vector<std::vector<NodalWeight>> point_rates_;  ///< of PlateSupport::point, by direction
  std::vector<std::vector<Matrix>> shape_force_;       ///< derivative of it along every direction
  /// For a leaf with weight: derivatives of PlateMesh::mass_moment along every direction.
  std::vector<std::vector<VectorXd>> moment_rates_;
};

extern template class PlateGradient<double>;
extern template class PlateGradient<Jet>;

}  // namespace flexopt
