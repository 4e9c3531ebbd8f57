#pragma once
// The mixed potential at one state straight from the Taylor coefficients of both neighbouring
// nodes: third derivatives, and the same numbers of coefficients that are derivatives themselves.
#include <array>
#include <vector>

#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt {

/// Where a state stands between two nodes. The interpolant is that of TubePotential, equal to its
/// evaluate() but for rounding; that one is faster where many states are asked for.
class TubeStencil {
 public:
  /// s, f: as of TubePotential::evaluate, from which the nodes' places and the mirror are taken.
  TubeStencil(const TubePotential& potential, const Vector3d& s, const Vector3d& f);

  /// Of the potential with these coefficients: nodes at the places of those of the potential.
  PotentialValue value(const std::vector<TubeNode>& nodes) const;
  /// ∂hessian/∂z_k, k = 0 … 5, of the same.
  std::array<Matrix6d, 6> third(const std::vector<TubeNode>& nodes) const;

 private:
  static constexpr int orders = 4;  ///< value and three derivatives
  struct Coefficients;
  /// Σ over the monomials off the ray of all derivatives to `order`, in (σ, τ, φ, N, M1, M2).
  void sum(const std::vector<TubeNode>& nodes, int order, std::vector<double>& sums) const;

  int degree_;
  bool mirrored_;
  std::size_t interval_;
  /// Of a monomial that takes q coefficients from each node: weights of these, first of the left
  /// node, for every order.
  std::vector<std::array<std::vector<double>, orders>> weights_;
  std::vector<double> powers_;              ///< of (τ, φ, N, M1, M2), graded
  Matrix6d to_ray_ = Matrix6d::Identity();  ///< of (θ1y, θ2y, φx, N, M1, M2)
};

}  // namespace flexopt
