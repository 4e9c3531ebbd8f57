#pragma once
// The conditions Ψ(q) = 0 of all joints of a mechanism: equation (Q2) of README.md; after them the
// strokes g(q) of the drives that are no coordinates: (Q4). None for a mechanism without either.
#include <array>
#include <vector>

#include "core/math/block_matrix.hpp"
#include "core/mechanism/drive.hpp"

namespace flexopt {

/// K += H, second derivatives by (displacement, spin) of two bodies; either may be the ground.
void add_between(const Matrix12d& H, int body, int other, BlockMatrix& K);

class Constraints {
 public:
  /// The mechanism must outlive it.
  explicit Constraints(const Mechanism& mechanism);

  int count() const { return static_cast<int>(units_.size()); }
  int joints() const { return joints_; }  ///< how many of them are the joints'
  /// Drives to which the rows from joints() on belong.
  const std::vector<int>& drives() const { return drives_; }
  /// What a condition is compared with: the longest leaf [m], or 1 for cosines.
  const VectorXd& units() const { return units_; }

  /// Evaluates Ψ and Ψ_q at these poses. The results below hold afterwards. Strokes of rotations
  /// are those nearest to the value() before.
  void evaluate(const std::vector<JointBody>& poses);
  const VectorXd& value() const { return value_; }
  void set_value(const VectorXd& value) { value_ = value; }
  /// One row of Ψ_q: its nonzero entries, for two bodies.
  struct Row {
    std::array<int, 2> body;  ///< index of a body, or ground
    Vector12d gradient;       ///< by (displacement, spin) of the one, then of the other

    /// visit(coordinate, entry) for those of bodies.
    template <class Visit>
    void each(const Visit& visit) const {
      for (int e = 0; e < 2; ++e)
        for (int d = 0; d < 6 && body[e] >= 0; ++d) visit(6 * body[e] + d, gradient[6 * e + d]);
    }
  };
  const std::vector<Row>& rows() const { return rows_; }
  MatrixXd gradient() const;                           ///< written out: count × 6 bodies
  VectorXd forces(const VectorXd& multipliers) const;  ///< Ψ_qᵀ λ
  /// K += λ·Ψ_qq at these poses, rotations varied as exp(hat δ) R.
  void add_curvature(const std::vector<JointBody>& poses, const VectorXd& multipliers,
                     BlockMatrix& K) const;

 private:
  const Mechanism* mechanism_;
  int joints_ = 0;
  std::vector<int> drives_;
  VectorXd units_, value_;
  std::vector<Row> rows_;
};

}  // namespace flexopt
