#pragma once
// What the energy of an elastic body is made of, seen from its interfaces: plain numbers, own axes
// of the body. Equations (U1)–(U9) of README.md.
#include <array>
#include <memory>
#include <vector>

#include "core/math/types.hpp"
#include "core/mechanism/mechanism.hpp"

namespace flexopt {

/// Coordinates d = (u_1, θ_1, …, u_N, θ_N): displacement [m] and rotation vector [rad] of each
/// interface in the floating frame. The energy is
///     W(d) = ½ dᵀ K d + 1/6 A[e, e, e] + 1/24 B[e, e, e, e],   e = basisᵀ d.
/// The derivative of a model along a change of the body's sizes or material is a model too: of
/// every number its rate (the basis does not change).
struct ElasticModel {
  std::vector<Vector3d> origins;  ///< of the interfaces [m]
  MatrixXd stiffness;             ///< K, 6N × 6N; exactly zero for rigid motions
  MatrixXd mass;                  ///< over d, 6N × 6N [kg, kg m, kg m²]
  /// First moments ∫ρΦ, 3 × 6N [kg, kg m]: gravity g, own axes, does the work gᵀ · moments · d on
  /// the deformation.
  MatrixXd moments;
  double total_mass = 0;                    ///< [kg]
  Vector3d mass_moment = Vector3d::Zero();  ///< mass · centre of mass, undeformed [kg m]
  /// The basis has orthonormal columns, 6N × m with m = 6N − 6, on which Z d = 0, Z the mean of
  /// displacements and of rotations. It is empty where A is not known.
  MatrixXd basis;
  /// A and B, all entries, index ((i m + j) m + k) …, symmetric. B is empty for a linear body,
  /// whose energy has no A either: it tells how far the body may deform.
  std::vector<double> cubic, quartic;

  int interfaces() const { return static_cast<int>(origins.size()); }
};

/// The surface of a solid mesh.
struct SolidSurface {
  std::vector<int> nodes;  ///< ascending
  /// It tells of each node whether one of its cells has a node of a patch. A rigid patch ends
  /// in a singular stress, whose value there would only tell the size of the cells.
  std::vector<bool> beside_patch;
  std::vector<int> corners;  ///< of the cells, those in `nodes`, by their places there
  /// The outer faces between corners alone, counterclockwise seen from outside, by places in
  /// `corners`.
  std::vector<std::array<int, 3>> triangles;
};

/// What a solid mesh tells beside its model; the fields it was condensed with.
struct CondensedSolid {
  ElasticModel model;
  MatrixXd fields;  ///< Φ: displacements of all nodes (3 rows each) for unit d, 3n × 6N
  /// A body of degree 4 has second-order fields Θ_ij, columns of the pairs i ≥ j (i = 0 j = 0, i =
  /// 1 j = 0, i = 1 j = 1, …): displacements Φ d + ½ Σ_ij Θ_ij e_i e_j. Else empty.
  MatrixXd second_fields;
  double rigid_residual = 0;  ///< |K Φ_rig| over |K| before it was projected away
  int unknowns = 0;           ///< that were condensed
  SolidSurface surface;
};

/// The condensed body, kept for as long as a few others have not been asked for since: the same
/// numbers are never reduced twice. Thread-safe. The body must have passed check_solid().
std::shared_ptr<const CondensedSolid> condensed(const ElasticBody& body);
/// Rate of its model along a change of the body; `direction`: of every number its rate. Kept too.
std::shared_ptr<const ElasticModel> model_rate(const ElasticBody& body,
                                               const ElasticBody& direction);
/// Rates of the fields Φ and Θ: for the derivative of stress. Kept together with that.
struct FieldRates {
  MatrixXd fields, second_fields;
};
std::shared_ptr<const FieldRates> field_rates(const ElasticBody& body,
                                              const ElasticBody& direction);

/// Whether the mesh can be condensed: cells that are not inverted (det J > 0 at all points, and
/// their aspect), patches with three nodes off a line at least that do not share nodes, N ≥ 2, one
/// piece; N ≤ 3 for degree 4; matrices that fit. Tells what is wrong.
Check check_solid(const ElasticBody& body);

}  // namespace flexopt
