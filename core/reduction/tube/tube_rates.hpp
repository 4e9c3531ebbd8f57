#pragma once
// What exact derivatives of a tube leaf need of its potential: third derivatives along the state,
// and the gradient and the Hessian of what the potential changes by with the leaf's shape.
#include <array>
#include <vector>

#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt {

class TubeRates {
 public:
  /// `rates`: at the nodes of the potential, which must outlive this. Its degree is 5.
  TubeRates(const TubePotential& potential, const TubeNodeRates& rates);

  struct Answer {
    PotentialValue potential;
    std::array<Matrix6d, 6> third;           ///< ∂hessian/∂z_k of it
    std::array<PotentialValue, 3> by_shape;  ///< derivatives of it by w/L, t/L and ν
  };
  /// z = (s, f): as of TubePotential::evaluate.
  Answer evaluate(const Vector3d& s, const Vector3d& f) const;

 private:
  const TubePotential* potential_;
  std::vector<TubePotential> by_shape_;  ///< the interpolant is linear in the nodes
};

}  // namespace flexopt
