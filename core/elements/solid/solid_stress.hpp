#pragma once
// Stress of a condensed body: what its solid mesh tells at given coordinates d of its interfaces,
// in its floating frame.
#include <array>
#include <optional>
#include <vector>

#include "core/elements/solid/elastic_model.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// The outer faces of a mesh, those that one cell has alone, as triangles of corners and mid-side
/// nodes, counterclockwise seen from outside: six of a quadrilateral, four of a triangle.
std::vector<std::array<int, 3>> surface_triangles(const SolidCells& cells);

/// Displacements of the nodes, three of each [m]: Φ d, of degree 4 Φ d + ½ Σ Θ_ij e_i e_j, in which
/// patches turn to second order.
VectorXd solid_displacements(const CondensedSolid& solid, const VectorXd& d);
/// Their rates while d and the fields change.
VectorXd solid_displacement_rates(const CondensedSolid& solid, const FieldRates& rates,
                                  const VectorXd& d, const VectorXd& d_rate);

/// Second Piola stress [Pa]: 11, 22, 33, 23, 13, 12 in own axes of the body.
using SolidTensor = Vector6d;
double von_mises_stress(const SolidTensor& stress);
/// Zero where the stress is zero.
double von_mises_rate(const SolidTensor& stress, const SolidTensor& rate);

SolidSurface solid_surface(const ElasticBody& body);

/// Stress at the surface. Stresses of a cell's integration points are extrapolated to its nodes,
/// those of its cells averaged at each node: σ = C:E, E = sym H + ½ HᵀH of degree 4, sym H of a
/// linear body.
struct SolidStress {
  std::vector<SolidTensor> at_nodes;  ///< of SolidSurface::nodes
  std::vector<double> von_mises;      ///< of them [Pa]
  /// The largest of those that are not beside a patch; none where all are.
  struct Largest {
    double von_mises = 0;  ///< [Pa]
    int node = 0;
    Vector3d place;  ///< undeformed, own axes [m]
    /// Estimated error of the mesh: the largest von Mises stress of the differences between cells
    /// and their average at the nodes of the cells around [Pa].
    double jump = 0;
  };
  std::optional<Largest> largest;
  double energy = 0;  ///< ½ ∫ σ:E [J]
};
SolidStress solid_stress(const ElasticBody& body, const SolidSurface& surface,
                         const VectorXd& displacements);

/// Stresses at nodes and their rates while the body changes by `direction` and the displacements by
/// theirs.
struct RatedTensor {
  SolidTensor value, rate;
};
std::vector<RatedTensor> node_stresses(const ElasticBody& body, const ElasticBody& direction,
                                       const VectorXd& displacements,
                                       const VectorXd& displacement_rates,
                                       const std::vector<int>& nodes);

}  // namespace flexopt
