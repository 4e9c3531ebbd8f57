#pragma once
// How far elastic bodies may deform: what their energies leave out. README.md of
// core/elements/solid, "Degree 4".
#include <optional>

#include "core/equilibrium/elastic_bodies.hpp"

namespace flexopt {

/// Geometric share of body `k` in the state of the last evaluation. Degree 4: the largest relative
/// change of a stiffness by the deformation. Degree 2: forces of second order ½ A[e, e], which it
/// leaves out, over those of first order, in the norm of the energy.
/// Nothing of imported matrices, and at rest.
std::optional<double> geometric_share(const ElasticBodies& bodies, int k);

/// Whether a body holds a share of this size; else why not.
Check check_share(const ElasticBody& body, double share);
/// The share over what the body holds.
double share_over_limit(const ElasticBody& body, double share);

/// The geometric stiffness yᵀ (A·e) y of a body of degree 2, which its energy leaves out, for
/// motions y of all rigid bodies, six rows each. Zero of bodies that have it, and of imported ones.
double left_out_stiffness(const ElasticBodies& bodies, int k, const VectorXd& motion);

}  // namespace flexopt
