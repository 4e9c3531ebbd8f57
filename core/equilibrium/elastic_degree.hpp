#pragma once
// How far elastic bodies may deform: what their energies leave out. README.md of
// core/elements/solid, "Degree 4".
#include <optional>

#include "core/equilibrium/system.hpp"

namespace flexopt {

/// Geometric share of body `k` in the state of the last evaluation: the largest relative change of
/// a stiffness by the deformation; of degree 2, which leaves it out, at least the forces of second
/// order ½ A[e, e] over those of first order, in the norm of the energy. Nothing of imported
/// matrices, and at rest.
std::optional<double> geometric_share(const ElasticBodies& bodies, int k);

/// How much a stiffness is off by the terms that the degree of body `k` leaves out, relative, at an
/// equilibrium with this share: of degree 2 that of the end-effector, drives held or free, to first
/// order; of degree 4 (U12). Zero of imported matrices. The system must be assembled.
double degree_error(const System& system, int k, const std::optional<double>& share);
inline constexpr double largest_degree_error = 0.1;  ///< that is believed
/// Whether a body holds a deformation with this error; else why not.
Check check_degree(const ElasticBody& body, double error);

/// The geometric stiffness yᵀ (A·e) y of a body of degree 2, which its energy leaves out, for
/// motions y of all rigid bodies, six rows each. Zero of bodies that have it, and of imported ones.
double left_out_stiffness(const ElasticBodies& bodies, int k, const VectorXd& motion);

}  // namespace flexopt
