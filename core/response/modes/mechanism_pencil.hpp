#pragma once
// K and M of a mechanism over its bodies and the internal motions of its leaves.
#include <array>
#include <optional>
#include <vector>

#include "core/equilibrium/system.hpp"
#include "core/math/bordered_pencil.hpp"
#include "core/response/modes/frequencies.hpp"
#include "core/response/modes/mechanism_factor.hpp"

namespace flexopt {

/// Number of coordinates from which the lowest pairs are computed in Krylov spaces.
inline constexpr int krylov_from = 150;

/// Coordinates: those of the bodies, internal ones of leaf 0, of leaf 1, …, the fixed-interface
/// modes of the elastic bodies.
struct MechanismPencil {
  int size = 0;
  int bodies = 0;        ///< coordinates of the bodies
  BlockMatrix K_bodies;  ///< the leaves add a block each beside it: no coupling
  BlockMatrix M_bodies;  ///< of the rigid and elastic bodies alone
  VectorXd highest;      ///< highest kept mode of each leaf [Hz]
  double check = 0;
  /// A leaf, or behind the leaves what the modes of an elastic body add.
  struct Leaf {
    std::vector<int> coordinates;  ///< of its bodies, its point and its modes in the pencil
    int modes;                     ///< the last of them
    MatrixXd mass, stiffness;      ///< over them; of the modes alone
    MatrixXd stations, shape;

    Eigen::Index boundary() const { return mass.rows() - modes; }
    /// Index of the first mode of the leaf in the pencil; 0 if it has none.
    int first() const { return modes > 0 ? coordinates[boundary()] : 0; }
  };
  std::vector<Leaf> leaves;

  MatrixXd mass_times(const MatrixXd& X) const;
  /// Mode::motion for every column.
  MatrixXd motions(const System& system, const MatrixXd& phi) const;
  void add_shape(const System& system, const VectorXd& phi, Mode& mode) const;
};

/// The system must be assembled at an equilibrium. `leaf_modes`: of each leaf.
MechanismPencil mechanism_pencil(System& system, const std::vector<int>& leaf_modes,
                                 const FrequencyOptions& options);
/// Pencil of a mechanism whose leaves all know their internal motions; nothing for others.
struct InternalPencil {
  MechanismPencil pencil;
  /// InternalMotions::unknowns of each leaf, and 1 of the modes of each elastic body.
  std::vector<MatrixXd> unknowns;
  std::vector<int> offsets;  ///< of these unknowns in a vector of the factor
};
std::optional<InternalPencil> internal_pencil(const MechanismFactor& factor);

/// Pencil whose internal coordinates are every leaf's modes between held edges.
struct LeafModes {
  BorderedPencil pencil;         ///< its border: the bodies
  std::vector<MatrixXd> shapes;  ///< of each leaf, over its internal coordinates

  explicit LeafModes(const MechanismPencil& of);
  /// Vectors with these bodies' rows, the others those of pairs of the bordered pencil, in the
  /// coordinates of the mechanism's.
  MatrixXd expanded(const MechanismPencil& to, const MatrixXd& of_bodies,
                    const MatrixXd& vectors) const;
};

/// The lowest pairs of a mechanism, drives free and held, in its coordinates; those next to the
/// last ones too. By dense matrices, whose cost is cubic. Nothing where some are missing.
std::optional<std::array<EigenPairs, 2>> free_and_held_pairs(const System& system,
                                                             const MechanismPencil& pencil,
                                                             const LeafModes& modes,
                                                             PairCounts counts);

}  // namespace flexopt
