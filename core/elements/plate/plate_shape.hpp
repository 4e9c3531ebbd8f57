#pragma once
// The shape of a leaf once size and Young's modulus are scaled out, how it changes, and what the
// meshes of such shapes are made of: graded lines, Gauss points, cubic Hermite functions. Lengths
// in units of the leaf length L.
#include <array>
#include <optional>
#include <vector>

#include "core/elements/leaf/leaf_rates.hpp"
#include "core/math/alike.hpp"
#include "core/math/types.hpp"
#include "core/mechanism/mechanism.hpp"
#include "core/mechanism/model_options.hpp"

namespace flexopt {

/// c of the layer along free edges: equation (E2) of core/elements/README.md.
inline constexpr double free_edge_coefficient = 0.105;

/// What distinguishes the leaves once size and Young's modulus are scaled out.
struct PlateShape {
  double width = 0.3;       ///< w/L
  double thickness = 5e-3;  ///< t/L
  double poissons_ratio = 0.3;
  std::array<int, 2> mesh = default_mesh;  ///< elements along, across
  bool free_edge_torsion = true;           ///< see core/elements/README.md (E2)
  Flexure flexure = Flexure::plate;
  Section section = Section::rectangular;  ///< of a beam; circular: width = thickness = diameter
  Warping warping = Warping::clamped;      ///< of the ends of a beam of rectangular section
  /// Factors on width and thickness along the leaf: core/mechanism/profile.hpp.
  std::vector<double> width_profile{}, thickness_profile{};
  std::optional<double> curve{};  ///< angle of the arc [rad]; none: flat
  /// Place and radius of the fold over L, and its angle; `mesh` is then that of each leg.
  std::optional<LeafFoldT<double>> fold{};
  /// Mesh for a superelement, which must represent constant strains exactly: (E9) takes nothing
  /// back.
  bool linear = false;
  bool transverse_shear = true;  ///< (E10)

  bool is_beam() const { return flexure == Flexure::beam; }
  bool has_profile() const { return !width_profile.empty() || !thickness_profile.empty(); }
  double width_at(double x) const;      ///< over L, at x in [0, 1]
  double thickness_at(double x) const;  ///< over L
  /// Mean width and thickness over L: means of the values that a profile is made of.
  double mean_width() const;
  double mean_thickness() const;
  auto operator<=>(const PlateShape&) const = default;
};
/// Whether rounding alone tells two shapes apart, as of leaves between bodies that stand otherwise:
/// what is made of the one then serves the other.
bool alike(const PlateShape& a, PlateShape b);

/// How a shape changes along one direction.
struct ShapeRate : ProfileRate {
  Vector3d size = Vector3d::Zero();  ///< of w/L, t/L, ν

  ShapeRate() = default;
  ShapeRate(const Vector3d& of_size) : size(of_size) {}
  explicit ShapeRate(const ProfileRate& profile) : ProfileRate(profile) {}
};

/// Mesh points from a to b, graded towards both ends: g = 0 uniform, g = 1 Chebyshev–Lobatto.
std::vector<double> graded_points(double a, double b, int intervals, double g);

struct GaussRule {
  std::vector<double> point, weight;  ///< on [0, 1]
};
/// Gauss rule of 2 or 4 points.
GaussRule gauss_rule(int points);

template <class S>
struct HermiteValuesT {
  std::array<S, 4> value, slope, curvature;
};
using HermiteValues = HermiteValuesT<double>;
/// Cubic Hermite functions on [0, h] at sh, in the order (value, slope) at 0, (value, slope) at h.
template <class S, class Place = double>
HermiteValuesT<S> hermite(const Place& s, const S& h) {
  return {{S(1 - 3 * s * s + 2 * s * s * s), h * (s - 2 * s * s + s * s * s),
           S(3 * s * s - 2 * s * s * s), h * (s * s * s - s * s)},
          {(-6 * s + 6 * s * s) / h, S(1 - 4 * s + 3 * s * s), (6 * s - 6 * s * s) / h,
           S(3 * s * s - 2 * s)},
          {(-6 + 12 * s) / (h * h), (-4 + 6 * s) / h, (6 - 12 * s) / (h * h), (6 * s - 2) / h}};
}
inline HermiteValues hermite(double s, double h) { return hermite<double>(s, h); }

/// The 16 products X[2p + kx] Y[2q + ky], at function 8p + 4q + kx + 2ky of an element.
template <class A, class B>
auto hermite_products(const std::array<A, 4>& X, const std::array<B, 4>& Y) {
  Eigen::Matrix<decltype(A() * B()), 16, 1> row;
  for (int p = 0; p < 2; ++p)
    for (int q = 0; q < 2; ++q)
      for (int k = 0; k < 4; ++k) row[8 * p + 4 * q + k] = X[2 * p + k % 2] * Y[2 * q + k / 2];
  return row;
}

/// Functions 4p + k of (r0, r0,x, d, d,x) of a beam: X[2p + k % 2] times `middle` (k < 2) or
/// `across`.
template <class S>
Eigen::Matrix<S, 16, 1> beam_functions(const std::array<S, 4>& X, double middle, double across) {
  Eigen::Matrix<S, 16, 1> row = Eigen::Matrix<S, 16, 1>::Zero();
  for (int p = 0; p < 2; ++p)
    for (int k = 0; k < 4; ++k) row[4 * p + k] = X[2 * p + k % 2] * (k < 2 ? middle : across);
  return row;
}

}  // namespace flexopt
