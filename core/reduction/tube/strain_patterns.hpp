#pragma once
// The rows of StressPlaces as few patterns: what tables of stress in an atlas are over. Equation
// (A6) of core/reduction/README.md.
#include <array>
#include <vector>

#include "core/reduction/expansion/stress_expansion.hpp"
#include "core/reduction/tube/pattern_rows.hpp"
#include "core/reduction/tube/state_table.hpp"

namespace flexopt {

/// Strains e = t P a, κ = 2 P a and places P a, each with patterns P and coefficients a of their
/// own. A pattern of strains is its own image in the turn x → 1 − x by 180° about the normal, or
/// that with the other sign; only one half along is kept.
class StrainPatterns {
 public:
  /// e kept by the turn, e whose sign it changes, the same of κ, places; coefficients stand in this
  /// order.
  static constexpr int families = 5, places_family = 4;

  /// `P`: folded() rows of each family × its patterns.
  StrainPatterns(std::array<int, 2> mesh, const std::array<MatrixXd, families>& P);

  /// What the patterns of a family are made to represent, of rows of StressPlaces: so that
  /// coefficients are Pᵀ folded. Strains of no thickness: e over t, κ over 2.
  static MatrixXd folded(const StressPlaces& places, int family, const MatrixXd& rows);

  int count(int family) const { return static_cast<int>(of(family).patterns()); }
  const MatrixXd& P(int family) const { return P_[static_cast<std::size_t>(family)]; }
  Eigen::Index stretching() const { return count(0) + count(1); }
  Eigen::Index strains() const { return stretching() + count(2) + count(3); }
  Eigen::Index all() const { return strains() + count(places_family); }

  /// Table of coefficients of the patterns, from the table of a leaf.
  StateTable coefficients(const StateTable& node, double thickness) const;
  /// The rows of strains of the first strains() coefficients, columns one by one.
  MatrixXd strains_of(const MatrixXd& a, double thickness) const;
  /// `count` rows of places from `first` on, from the last coefficients.
  MatrixXd places_of(Eigen::Index first, Eigen::Index count, const MatrixXd& a) const;
  /// The largest norm of a row: no e over t is larger than that of its coefficients times this;
  /// likewise κ over 2.
  double largest_norm(bool bending) const { return norms_[bending ? 1 : 0]; }

  /// Factors of the coefficients for the three components of a strain at a station. `columns`: some
  /// factors, a column for each coefficient of the kind.
  template <int factors>
  Eigen::Matrix<double, factors, 3> at(
      int along, int across, bool bending,
      const Eigen::Matrix<double, factors, Eigen::Dynamic>& columns) const {
    using Sum = Eigen::Matrix<double, factors, 3>;
    const bool far = along >= along_ / 2;
    const Eigen::Index step = static_cast<Eigen::Index>(along_ / 2) * across_,
                       first = (far ? along_ - 1 - along : along) + along_ / 2 * across;
    std::array<Sum, 2> sums{Sum::Zero(), Sum::Zero()};
    Eigen::Index column = 0;
    for (const int turned : {0, 1}) {
      const PatternRows& P = of((bending ? 2 : 0) + turned);
      const std::array<const double*, 3> row{P.row(first), P.row(first + step),
                                             P.row(first + 2 * step)};
      Sum& sum = sums[static_cast<std::size_t>(turned)];
      for (Eigen::Index k = 0; k < P.patterns(); ++k, ++column)
        for (int j = 0; j < 3; ++j)
          sum.col(j) += row[static_cast<std::size_t>(j)][k] * columns.col(column);
    }
    if (!far) return sums[0] + sums[1];
    Sum image = sums[0] - sums[1];
    image.col(2) *= -1;
    return image;
  }

 private:
  const PatternRows& of(int family) const { return rows_[static_cast<std::size_t>(family)]; }

  StressPlaces places_;
  int along_, across_;  ///< stations
  std::array<MatrixXd, families> P_;
  std::vector<PatternRows> rows_;  ///< of each family
  std::array<double, 2> norms_{};
};

}  // namespace flexopt
