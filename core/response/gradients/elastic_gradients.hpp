#pragma once
// The share of elastic bodies in exact gradients: their forces, tangents and masses at the state of
// the rigid bodies that hold them. Equations (S42), (S43) of core/response/README.md. S: double or
// Jet.
#include "core/response/gradients/design_rates.hpp"
#include "core/response/gradients/mechanism_state.hpp"

namespace flexopt {

/// R += what the residual of every row changes by at a constant state, one column for each
/// direction.
template <class S>
void add_elastic_residual_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                                const std::vector<Mechanism>& directions, Eigen::MatrixX<S>& R);

/// rates += derivatives of yᵀ(K − λM)y of every column y of Y along the directions and the state
/// rates that belong to them. `ground`: as in DesignRates::quadratic().
template <class S>
void add_elastic_quadratic_rates(const MechanismFactor& factor, const MechanismState<S>& state,
                                 const std::vector<Mechanism>& directions,
                                 const Eigen::MatrixX<S>& state_rates, const Eigen::MatrixX<S>& Y,
                                 const Eigen::VectorX<S>& lambda, const GroundShare* ground,
                                 Eigen::MatrixX<S>& rates);

/// Stresses at nodes of an elastic body with a mesh (11, 22, 33, 23, 13, 12, its own axes [Pa]),
/// six rows each, and what they change by along the directions with the state.
struct ElasticStressRates {
  VectorXd value;
  MatrixXd rate;
};
ElasticStressRates elastic_stress_rates(const MechanismFactor& factor, int body,
                                        const std::vector<int>& nodes,
                                        const std::vector<Mechanism>& directions,
                                        const MatrixXd& state_rates);

}  // namespace flexopt
