#pragma once
// Energy of a deformed mesh beside that of its condensed model. Equation (U11) of README.md.
#include "core/elements/solid/elastic_model.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Energy of the St. Venant–Kirchhoff solid between its interfaces at coordinates d, to degree 7,
/// over that of its model of degree 4, less one. `local`: d of nonzero deformation, 6N.
double left_out_energy(const ElasticBody& body, const CondensedSolid& solid, const VectorXd& local);

}  // namespace flexopt
