#pragma once
// The strains of a plate leaf's mid-surface at stations, between them and along design parameters.
#include <functional>
#include <utility>
#include <vector>

#include "core/elements/plate/plate_mesh.hpp"
#include "core/math/dual.hpp"

namespace flexopt {

/// Places in an element, each in [0, 1], where its strains are most accurate: Gauss points.
inline constexpr double station[2] = {0.21132486540518713, 0.7886751345948129};

/// The stations along one direction of a mesh with these lines: two between each pair.
std::vector<double> strain_stations(const std::vector<double>& lines);
std::vector<Dual1> strain_stations(const std::vector<Dual1>& lines);

/// e11, e22, 2 e12 and κ11, κ22, 2 κ12 of the mid-surface, lengths over L.
template <class S>
using StrainsT = Eigen::Matrix<S, 6, 1>;
using Strains = StrainsT<double>;

/// Split of the stations of a folded leaf: how many stations along lie before the fold, and the
/// place of the fold. Strains are not interpolated across the fold, which belongs to the first leg.
struct FoldSplit {
  int stations = 0;
  double place = 0;
};
FoldSplit fold_split(const PlateShape& shape);
/// The nearest place behind the fold, read in the second leg.
inline double behind_fold(double fold) { return fold + 1e-9; }

/// Interval of the stations (the first or last one beyond them) and the place in it.
std::pair<int, double> station_interval(const std::vector<double>& points, double s,
                                        const FoldSplit& split = {});

/// Strains known at a tensor grid of stations over the leaf, and between them by bilinear
/// interpolation. Places over L: x from 0, y from −w/2; where the width varies, the y0 of (P2).
class StrainField {
 public:
  /// `values`: stations across run fastest.
  StrainField(std::vector<double> x, std::vector<double> y, const std::vector<Strains>& values,
              FoldSplit split = {});
  /// `values`: a row for each station, stations along run fastest.
  StrainField(std::vector<double> x, std::vector<double> y, MatrixXd values, FoldSplit split = {});
  Strains at(double x, double y) const;
  const MatrixXd& values() const { return values_; }

 private:
  std::vector<double> x_, y_;
  MatrixXd values_;
  FoldSplit split_;
};

/// Share of the bending moment in the plane that belongs to r,xx of a strip, and that clamps, which
/// leave r,xx free, give to the stretching: (E18) of core/elements/README.md.
template <class S>
S line_share(const S& thickness, const S& width, const S& poissons_ratio) {
  const S ratio = thickness / width, square = poissons_ratio * poissons_ratio;
  return ratio * ratio * (1.0 + square) / (1.0 - square);
}

/// The strains of a plate at the 2 × 2 Gauss stations of every element.
StrainField recovered_strains(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal);

/// How a leaf changes along a design parameter, for the strains and the stress in it.
struct StressRate {
  std::vector<MatrixXd> nodal;  ///< of the nodal dofs, per line
  ShapeRate shape;
  double youngs_modulus = 0;
};

/// Numbers with their derivatives.
template <int rows, int columns>
Eigen::Matrix<Dual1, rows, columns> moving(const Eigen::Matrix<double, rows, columns>& value,
                                           const Eigen::Matrix<double, rows, columns>& rate) {
  return value.binaryExpr(rate, [](double v, double by) { return Dual1(v, {by}); });
}
/// Nodal values of an element; the rows of a beam beyond its 8 functions are zero.
Eigen::Matrix<double, 16, 3> element_nodes(const PlateMesh& mesh,
                                           const std::vector<MatrixXd>& nodal, int i, int j);

/// Stations along with their motion, stations across, which move with the width, and the strains at
/// both.
struct MovingStations {
  std::vector<Dual1> x;
  std::vector<double> y;
  std::function<StrainsT<Dual1>(int, int)> strains;
};
/// `mesh`, `nodal` and `rate` must outlive it.
MovingStations moving_stations(const PlateMesh& mesh, const std::vector<MatrixXd>& nodal,
                               const StressRate& rate);

}  // namespace flexopt
