#pragma once
// Expansion of the strains of a leaf about a bent state: what its surface stresses are made of.
// Equations (T1) and (T2) of core/reduction/README.md.
#include "core/reduction/expansion/tube_expansion.hpp"

namespace flexopt {

/// Places at which the strains and positions of a flat leaf of uniform width and thickness are
/// tabulated: on one half of its width, y ≤ 0, of which the other half is the mirror image. All
/// places keep their share of length and width whatever the shape.
struct StressPlaces {
  std::vector<double> x, y;          ///< of the strains, over L, on the whole leaf: Gauss stations
  std::vector<double> lines, nodes;  ///< of the mesh, over L

  explicit StressPlaces(const PlateShape& shape);
  /// Takes a leaf of default sizes: only the numbers of places count then.
  explicit StressPlaces(std::array<int, 2> mesh) : StressPlaces(PlateShape{.mesh = mesh}) {}
  int stations_along() const { return static_cast<int>(x.size()); }
  int half_across() const { return static_cast<int>(y.size()) / 2; }
  int half_nodes() const { return static_cast<int>(nodes.size() + 1) / 2; }
  /// Components of the strains one after the other, of each all stations, along fastest; then three
  /// for each node, along slowest.
  int strain_rows() const { return 6 * stations_along() * half_across(); }
  int rows() const { return strain_rows() + 3 * static_cast<int>(lines.size()) * half_nodes(); }
};

/// Taylor coefficients in x = (σ, τ, φ, N, M1, M2), rows as of StressPlaces: strains (e11, e22,
/// 2 e12, κ11, κ22, 2 κ12 of Strains) and places in the chord frame over L. Columns: the monomials
/// to degree 2, then σ³, σ²τ, στ² and τ³. `fields`: to order 2. About the state where `leaf`
/// stands.
MatrixXd expand_stress(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, const MatrixXd& fields);

}  // namespace flexopt
