#pragma once
// How far elastic bodies may deform: what their energies leave out. README.md of
// core/elements/solid, "Degree 4".
#include <optional>

#include "core/equilibrium/elastic_bodies.hpp"

namespace flexopt {

/// Geometric share of body `k` in the state of the last evaluation: the largest relative change of
/// a stiffness by the deformation; of degree 2, which leaves it out, at least the forces of second
/// order ½ A[e, e] over those of first order, in the norm of the energy. Nothing of imported
/// matrices, and at rest.
std::optional<double> geometric_share(const ElasticBodies& bodies, int k);

/// How much a stiffness of body `k` is off by the terms that its degree leaves out, relative, in
/// the state of the last evaluation with this share. Zero of imported matrices.
double degree_error(const ElasticBodies& bodies, int k, const std::optional<double>& share);
/// Largest error that is believed: of degree 4, of which it is a bound, and of degree 2, of which
/// it is that of the stiffness that changes most, often one that hardly counts.
inline double largest_degree_error(const ElasticBody& body) {
  return body.degree == ElasticDegree::linear ? 0.3 : 0.1;
}
/// Whether a body holds a deformation with this error; else why not.
Check check_degree(const ElasticBody& body, double error);

/// The geometric stiffness yᵀ (A·e) y of a body of degree 2, which its energy leaves out, for
/// motions y of all rigid bodies, six rows each. Zero of bodies that have it, and of imported ones.
double left_out_stiffness(const ElasticBodies& bodies, int k, const VectorXd& motion);

}  // namespace flexopt
