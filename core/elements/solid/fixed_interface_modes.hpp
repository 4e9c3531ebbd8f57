#pragma once
// How the inside of an elastic body vibrates beside its interfaces: (U10) of README.md.
#include <memory>

#include "core/elements/solid/elastic_model.hpp"

namespace flexopt {

/// Displacements inside are Φ d + Ξ q, of m shapes Ξ that vanish on the patches, q in [m]; own
/// axes of the body. Shapes and interfaces have no stiffness together. The derivative along a
/// change of the body's sizes or material is one too: of every number its rate, without shapes.
struct FixedInterfaceModes {
  MatrixXd shapes;     ///< Ξ, 3n × m; empty for imported matrices, and of rates
  MatrixXd stiffness;  ///< Ξᵀ K Ξ, m × m [N/m]
  MatrixXd mass;       ///< Ξᵀ M Ξ, m × m [kg]
  MatrixXd coupling;   ///< Φᵀ M Ξ, 6N × m [kg, kg m]

  Eigen::Index count() const { return mass.cols(); }
  /// R with RᵀR = mass.
  MatrixXd root_of_mass() const;
  /// Frequency of the highest while all interfaces are held [Hz]; there must be one.
  double highest() const;
};

/// So many of the lowest modes of a body, or as many as it has; kept as condensed() keeps its
/// model. Imported matrices have those that came with them.
std::shared_ptr<const FixedInterfaceModes> fixed_interface_modes(const ElasticBody& body,
                                                                 int count);
/// Their rate along a change of the body; `direction`: of every number its rate. Kept too.
std::shared_ptr<const FixedInterfaceModes> fixed_interface_mode_rates(const ElasticBody& body,
                                                                      const ElasticBody& direction,
                                                                      int count);

}  // namespace flexopt
