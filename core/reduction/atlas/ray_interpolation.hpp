#pragma once
// Expansions of the mixed potential about the same σ of neighbouring rays. Every expansion holds
// terms off its ray, so it knows how it changes when the ray turns. Equations (A3) and (A4) of
// core/reduction/README.md.
#include <array>
#include <vector>

#include "core/reduction/tube/state_table.hpp"

namespace flexopt {

/// Degree of the expansions: monomials in (σ, τ, φ, N, M1, M2), σ counted from that of the node.
inline constexpr int atlas_degree = 5;

/// D of the ray (1, ρ): (θ1y, θ2y)ᵀ = D (σ, τ), D = [1, −ρ; ρ, 1].
Eigen::Matrix2d ray_directions(double rho);

/// The rays of an atlas between which a ray lies. Where it is one of them, the other is not needed.
struct RayNeighbours {
  int left = 0;
  double a = 0, b = 0, rho = 0;
  bool on_left = false, on_right = false;
};
/// `rays`: ascending from −1 to 1.
RayNeighbours ray_neighbours(const std::vector<double>& rays, double rho);

/// ∂W/∂ρ and ∂²W/∂ρ² at constant (σ, τ, φ, N, M1, M2). The first one is right to degree 4, the
/// second to degree 3; higher terms are zero.
struct RayRates {
  std::vector<double> first, second;
};
RayRates ray_rates(const std::vector<double>& W, double sigma, double rho);

/// The expansion on a ray ρ between a < b from those on both: of each degree two-point Hermite
/// interpolation of all derivatives that there are, up to two.
std::vector<double> between_rays(const std::vector<double>& W_a, double a,
                                 const std::vector<double>& W_b, double b, double sigma,
                                 double rho);

/// Interpolation between rays for tables, of which many share a ray. A change of the ray mixes σ
/// and τ alone: the coefficients of the monomials of (σ, τ) to a degree, times any other ones, on
/// the ray ρ are a · (those on the ray a) + b · (those on the ray b), in the order of
/// polynomial.hpp. Index: the degree.
struct RayBlend {
  std::array<MatrixXd, 4> a, b;
};
RayBlend blend_between_rays(double a, double b, double sigma, double rho);
/// The table on the ray of `blend`, from those about the same σ on both rays: to degree 2, and for
/// stress to degree 3 in (σ, τ) alone.
StateTable blended(const StateTable& a, const StateTable& b, const RayBlend& blend);

/// Expansion of a leaf seen from its other end: about the ray (ρ, 1), D = ±[0, 1; 1, 0] [1, −ρ; ρ,
/// 1], for a leaf with the expansion W about (1, ρ). `same_sign`: the sign of D.
std::vector<double> from_other_end(const std::vector<double>& W, bool same_sign);

/// What `W` of a ray ρ = ±1 becomes when the leaf is turned end for end, which the ray survives:
/// equal to W but for rounding.
std::vector<double> end_for_end(const std::vector<double>& W, double rho);

}  // namespace flexopt
