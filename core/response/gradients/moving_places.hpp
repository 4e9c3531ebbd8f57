#pragma once
// What places of leaves and bodies change by as the state moves with the design parameters.
#include <map>
#include <memory>
#include <vector>

#include "core/response/gradients/design_rates.hpp"
#include "core/response/gradients/elastic_gradients.hpp"
#include "core/response/solids.hpp"

namespace flexopt {

/// Fields of the leaves that were asked for, and of the nodes of elastic bodies.
class MovingFields {
 public:
  MovingFields(const MechanismFactor& factor, const DesignRates<double>& design,
               const MatrixXd& state_rates)
      : factor_(&factor), design_(&design), state_rates_(&state_rates) {}

  const LeafFields& of(int i) {
    auto& fields = made_[i];
    if (!fields)
      fields = design_->leaf(i).fields(factor_->leaf_rows(factor_->leaves()[i], *state_rates_),
                                       design_->variations(i));
    return *fields;
  }
  ElasticStressRates elastic(int body, const std::vector<int>& nodes) const {
    return elastic_stress_rates(*factor_, body, nodes, design_->directions(), *state_rates_);
  }
  const std::vector<Mechanism>& directions() const { return design_->directions(); }

 private:
  const MechanismFactor* factor_;
  const DesignRates<double>* design_;
  const MatrixXd* state_rates_;
  std::map<int, std::unique_ptr<LeafFields>> made_;
};

/// Derivatives of the place of a leaf's material point, which is now at `place`: 3 × parameters.
MatrixXd leaf_place_rates(const Mechanism& mechanism, int i, double along, double across,
                          const Vector3d& place, const std::vector<Mechanism>& directions,
                          const LeafFields& fields);

/// What Young's modulus of a leaf changes by along the directions.
VectorXd modulus_rates(const std::vector<Mechanism>& directions, int leaf);
/// Derivatives of a stress, and of its notch factors where it is at a leaf's fillet.
VectorXd stress_rates(MovingFields& fields, const StressPeak& peak, const Mechanism& mechanism,
                      const std::optional<double>& fillet = {});

/// Derivatives of the displacement of O as the point of the path lists it, where the end-effector
/// follows the mean displacement of a tip edge: 3 × parameters.
MatrixXd tip_displacement_rates(const Mechanism& mechanism, int i, const PathPoint& point,
                                const std::vector<Mechanism>& directions, const LeafFields& fields);

/// Derivatives of all places that extents and clearances need.
PlaceRates moving_places(const MechanismFactor& factor, const Solids& solids,
                         const std::vector<Mechanism>& directions, const MatrixXd& state_rates,
                         MovingFields& fields);

}  // namespace flexopt
