#pragma once
// What exact derivatives of a tube leaf need of its potential: third derivatives along the state,
// and the gradient and the Hessian of what the potential changes by with the leaf's shape.
#include <array>
#include <vector>

#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt {

/// Reads the Taylor coefficients of both neighbouring nodes themselves. The interpolant is that of
/// TubePotential, its numbers equal to those of evaluate() but for rounding.
class TubeRates {
 public:
  /// `rates`: at the nodes of the potential.
  TubeRates(const TubePotential& potential, const TubeNodeRates& rates);

  struct Answer {
    PotentialValue potential;
    std::array<Matrix6d, 6> third;           ///< ∂hessian/∂z_k of it
    std::array<PotentialValue, 3> by_shape;  ///< derivatives of it by w/L, t/L and ν
  };
  /// z = (s, f): as of TubePotential::evaluate.
  Answer evaluate(const Vector3d& s, const Vector3d& f) const;

  /// A value of the potential and its three derivatives by the shape.
  using Four = double __attribute__((vector_size(32)));

 private:
  const TubePotential* potential_;
  /// For each interval and each monomial off the ray, the coefficients of the left node by the
  /// power of σ, then those of the right node.
  std::vector<std::vector<Four>> intervals_;
};

}  // namespace flexopt
