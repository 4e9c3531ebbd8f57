#pragma once
// Terms of degree 3 and 4 of a condensed body, exact for its St. Venant–Kirchhoff solid up to that
// degree: modal derivatives of the interfaces' static modes. Equations (U7)–(U9) of README.md.
#include <functional>

#include "core/elements/solid/elastic_model.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Displacements of all nodes under forces on them while the patches are held, 3n × k both: by the
/// factor of K_ii that the condensation has. Forces on patches are not read; patches do not move.
using HeldSolve = std::function<MatrixXd(const MatrixXd& forces)>;

/// Orthonormal basis of the coordinates d whose mean displacement and mean rotation are zero,
/// 6N × (6N − 6).
MatrixXd elastic_basis(int interfaces);

/// Adds basis, cubic, quartic and second-order fields to a solid whose fields Φ are there. N ≤ 3.
void add_quartic(const ElasticBody& body, const HeldSolve& solve, CondensedSolid& solid);

/// Adds basis and cubic to a linear body whose fields Φ are there, for its geometric share: how far
/// it may deform. `stiffness_fields`: K_fe Φ, 3n × 6N.
void add_cubic(const ElasticBody& body, const MatrixXd& stiffness_fields, CondensedSolid& solid);

/// A[e, ·, ·] on the basis, for coordinates d: from `cubic` where that is known, else of a linear
/// body from its mesh. Empty for imported matrices.
MatrixXd cubic_along(const ElasticBody& body, const CondensedSolid& solid, const VectorXd& local);

/// Adds the rates of `cubic` and `quartic` along a change of the body to `rate`, and those of the
/// second-order fields to `fields`, where that of Φ is.
void add_quartic_rate(const ElasticBody& body, const ElasticBody& direction,
                      const CondensedSolid& solid, const HeldSolve& solve, FieldRates& fields,
                      ElasticModel& rate);

}  // namespace flexopt
