#pragma once
// Lowest eigenpairs of K x = λ M x where most coordinates are modes of their own that only the mass
// ties to a few others, the border: substructures between the bodies of a mechanism.
#include <optional>
#include <vector>

#include "core/math/dense_pencil.hpp"

namespace flexopt {

///     K = [K_b 0; 0 diag(d)],   M = [M_b C; Cᵀ 1]
struct BorderedPencil {
  MatrixXd K, M;   ///< K_b and M_b of the border
  VectorXd modes;  ///< d, of the coordinates inside
  MatrixXd C;      ///< border × inside

  int border() const { return static_cast<int>(K.rows()); }
  int size() const { return border() + static_cast<int>(modes.size()); }
  MatrixXd dense_stiffness() const;
  MatrixXd dense_mass() const;
  /// The pencil in new coordinates x' of the border, x = Z x'.
  BorderedPencil along(const MatrixXd& Z) const;
  /// The pencil with these coordinates of the border alone, the others held.
  BorderedPencil kept(const std::vector<int>& border_coordinates) const;
};

/// Pairs with the border free and with some of its coordinates held.
struct FreeAndHeldPairs {
  EigenPairs free, held;  ///< zero at the coordinates that are held
};
struct PairCounts {
  int free = 0, held = 0;
};
/// The lowest pairs to rounding: the wanted number of each, and those whose values are next to the
/// last one's. A list of which none are wanted is empty. Pairs of the pencil with its lowest modes
/// alone are the starts of Rayleigh quotient iterations, each a solve with
///
///     S(σ) = K_b − σ M_b − σ² C (d − σ)⁻¹ Cᵀ
///
/// By Sylvester's law of inertia as many eigenvalues lie below σ as of S(σ) below zero and of the d
/// below σ: (S29) of core/response/README.md. That count at the last pair shows that none is
/// missing; where it fails, a whole decomposition is made instead. Nothing where that fails too.
std::optional<FreeAndHeldPairs> lowest_pairs(const BorderedPencil& pencil,
                                             const std::vector<int>& held, PairCounts counts);

}  // namespace flexopt
