#include "core/mechanism/loose_direction.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <memory>

#include "core/math/decompositions.hpp"
#include "core/math/rotation.hpp"
#include "core/math/sparse_solver.hpp"
#include "core/mechanism/joint.hpp"
#include "core/mechanism/spring.hpp"

namespace flexopt {
namespace {

constexpr double nothing = 1e-12;  // of the largest, both squares of motions

/// Sum of the squares of all that resists, over the motions of the bodies: displacements over
/// `length`, and rotations.
class Resistance {
 public:
  explicit Resistance(const Mechanism& mechanism)
      : mechanism_(mechanism), length_(longest_leaf(mechanism)) {
    sum_ = BlockMatrix(static_cast<int>(mechanism.bodies.size()));
    for (int b = 0; b < sum_.bodies(); ++b) sum_.block(b, b).setZero();
    for (const LeafSpring& leaf : mechanism.leaves) add_leaf(leaf);
    for (const ElasticBody& body : mechanism.elastic_bodies) add_elastic(body);
    for (const Joint& joint : mechanism.joints) add_joint(joint);
    for (const Spring& spring : mechanism.springs) add_spring(spring);
    for (std::size_t b = 0; b < mechanism.bodies.size(); ++b)
      for (std::size_t d = 0; d < 6; ++d)
        if (mechanism.bodies[b].held[d])
          sum_.block(static_cast<int>(b), static_cast<int>(b))(static_cast<int>(d),
                                                               static_cast<int>(d)) += 1;
  }

  const BlockMatrix& sum() const { return sum_; }

 private:
  using Rows = Eigen::Matrix<double, Eigen::Dynamic, 6>;

  /// Rows over (displacement, rotation) of two bodies, in SI.
  void add(int body, const Rows& of_body, int other, const Rows& of_other) {
    const std::array<int, 2> at{body, other};
    MatrixXd rows = MatrixXd::Zero(of_body.rows(), 12);
    const auto put = [&](int e, const Rows& r) {
      if (at[e] < 0) return;
      rows.middleCols(6 * e, 3) += r.leftCols(3) * length_;
      rows.middleCols(6 * e + 3, 3) += r.rightCols(3);
    };
    put(0, of_body);
    put(at[0] == at[1] ? 0 : 1, of_other);
    for (Eigen::Index k = 0; k < rows.rows(); ++k)
      if (const double size = rows.row(k).norm(); size > 0) rows.row(k) /= size;
    for (int e = 0; e < 2; ++e)
      for (int f = 0; f < 2; ++f)
        if (at[e] >= 0 && at[f] >= 0 && (at[0] != at[1] || (e == 0 && f == 0)))
          sum_.block(at[e], at[f]) +=
              rows.middleCols(6 * e, 6).transpose() * rows.middleCols(6 * f, 6);
  }

  /// What a place that moves with a body does: its displacement, and its rotation.
  Eigen::Matrix<double, 6, 6> carried(int body, const Vector3d& place) const {
    Matrix6d map = Matrix6d::Identity();
    if (body >= 0) map.topRightCorner<3, 3>() = -hat(place - mechanism_.bodies[body].reference);
    return map;
  }

  void add_leaf(const LeafSpring& leaf) {
    const Vector3d tip = leaf.tip_middle();
    if (leaf.tip != free_edge)
      add(leaf.tip, carried(leaf.tip, tip), leaf.base, -carried(leaf.base, tip));
    if (!leaf.point) return;
    const int body = leaf.point->body;
    const Vector3d place = mechanism_.bodies[body].reference;
    add(body, carried(body, place).topRows<3>(), leaf.base,
        -carried(leaf.base, place).topRows<3>());
  }

  void add_elastic(const ElasticBody& body) {
    const int first = body.interfaces.front().body;
    for (std::size_t a = 1; a < body.interfaces.size(); ++a) {
      const int other = body.interfaces[a].body;
      const Vector3d place = body.interface_place(a);
      if (other != first) add(other, carried(other, place), first, -carried(first, place));
    }
  }

  void add_joint(const Joint& joint) {
    const MatrixXd g = undeflected_conditions(mechanism_, joint).gradient;
    add(joint.body, g.leftCols(6), joint.other, g.rightCols(6));
  }

  /// Adds the stiffness of a spring against the motions that change its forces, whatever the sign
  /// of its force.
  void add_spring(const Spring& spring) {
    Matrix12d tangent = spring_forces(spring, undeflected_body(mechanism_, spring.body),
                                      undeflected_body(mechanism_, spring.other))
                            .tangent;
    Eigen::Matrix<double, 12, 1> scale;
    for (int i = 0; i < 12; ++i) scale[i] = i % 6 < 3 ? length_ : 1;
    tangent = scale.asDiagonal() * tangent * scale.asDiagonal();
    const SymmetricEigen eigen{MatrixXd(tangent)};
    const double largest = eigen.eigenvalues().cwiseAbs().maxCoeff();
    for (int k = 0; k < 12; ++k) {
      if (!(std::abs(eigen.eigenvalues()[k]) > 1e-9 * largest)) continue;
      const Eigen::Matrix<double, 1, 12> row =
          eigen.eigenvectors().col(k).cwiseQuotient(scale).transpose();
      add(spring.body, row.leftCols<6>(), spring.other, row.rightCols<6>());
    }
  }

  const Mechanism& mechanism_;
  double length_;
  BlockMatrix sum_;
};

// The coordinate that the loosest motion moves most; none where all are held.
std::optional<int> loosest(const MatrixXd& sum, double least) {
  const MatrixXd less = sum - least * MatrixXd::Identity(sum.rows(), sum.cols());
  if (Cholesky(less).positive_definite())
    return std::nullopt;  // the usual case, a tenth of the work
  const SymmetricEigen eigen(sum);
  const VectorXd& values = eigen.eigenvalues();
  if (values.size() == 0 || values[0] > least) return std::nullopt;
  Eigen::Index most = 0;
  eigen.eigenvectors().col(0).cwiseAbs().maxCoeff(&most);
  return static_cast<int>(most);
}

// Coordinate of many bodies that moves most in their loosest motion; nothing where none is loose. A
// loose motion dominates the answer to any force.
std::optional<int> loosest(const BlockMatrix& sum, double least) {
  const VectorXd one = VectorXd::Ones(sum.size());
  const auto shifted = [&](double shift) {
    SparseMatrix A(sum.size());
    A.add(sum, one, one);
    for (int k = 0; k < sum.size(); ++k) A.add(k, k, shift);
    return A;
  };
  const auto analyses = std::make_shared<SparseAnalyses>();
  if (negative_eigenvalues(shifted(-least), {}, *analyses) == 0) return std::nullopt;
  const LinearSolver solver(shifted(least), analyses);
  VectorXd motion(sum.size());
  for (int k = 0; k < sum.size(); ++k) motion[k] = std::sin(1 + 1.7 * k);
  for (int step = 0; step < 3; ++step) {
    motion = solver.solve(motion);
    motion /= motion.norm();
  }
  if (motion.dot((sum * motion).col(0)) > least) return std::nullopt;
  Eigen::Index most = 0;
  motion.cwiseAbs().maxCoeff(&most);
  return static_cast<int>(most);
}

}  // namespace

Check check_directions(const Mechanism& mechanism) {
  const Resistance resistance(mechanism);
  const double least = nothing * resistance.sum().diagonal().maxCoeff();
  const std::optional<int> most = resistance.sum().size() < sparse_from
                                      ? loosest(resistance.sum().dense(), least)
                                      : loosest(resistance.sum(), least);
  if (!most) return {};
  return Because(fmt::format("{}: nothing gives it stiffness in {}",
                             mechanism.bodies[*most / 6].name, direction_names[*most % 6]));
}

}  // namespace flexopt
