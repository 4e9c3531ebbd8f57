#pragma once
// How a leaf answers to small dead loads on its nodes, along its bent states: the second set of
// fields beside those of TubeExpansion. Equation (D1) of core/reduction/README.md.
#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {

/// Number of loads that are expanded together.
inline constexpr int field_loads = 10;

/// Amplitudes of a leaf's internal motion: a = Lᵀ r of fixed loads L on its nodes, in the chord
/// frame. The loads are the inertia of separable motions of the flat leaf between held edges, modes
/// of beams along and across, so that they change smoothly with the sizes of the leaf. Each is of
/// one parity in both mirrors.
struct LoadParity {
  std::array<int, field_loads> normal{}, across{};  ///< −1 or +1, in the mirror of the thickness
};
struct InternalLoads {
  MatrixXd loads;  ///< as in expand_load_fields
  LoadParity parity;
};

/// Derivatives by the size of each load of the state (σ, τ, φ, N, M1, M2) about the present one, of
/// a flat leaf of uniform width and thickness. `fields`: expand_fields of the same leaf, degree 2
/// at least. `loads`: a column each; functions_per_line × 3 numbers a line, component by component,
/// in the chord frame. Taylor coefficients to degree 2, a block of monomial_count(6, 2) columns for
/// each load.
FieldExpansion expand_load_fields(const ChordLeaf& leaf, const Eigen::Matrix2d& ray,
                                  const MatrixXd& fields, const InternalLoads& loads);

}  // namespace flexopt
