#pragma once
// Numbers that a leaf's state determines, as polynomials to second order about the bent states of a
// tube, joined between neighbouring ones. Equation (D6) of core/reduction/README.md.
#include <array>

#include "core/math/types.hpp"

namespace flexopt {

/// Taylor coefficients of any numbers about one bent state, in (σ − sigma, τ, φ, N, M1, M2), forces
/// over their scale and from the force centre: numbers × monomials (polynomial.hpp, 6 variables,
/// degree ≤ 2). Numbers that the mirror across the width keeps have the monomials that are even in
/// (φ, M1, M2), the others those that are odd.
struct StateTable {
  static constexpr int even_monomials = 16, odd_monomials = 12;
  double sigma = 0;
  MatrixXd even, odd;
};

/// A monomial σ^along (τ, φ, N, M1, M2)^… of one parity.
struct StateMonomial {
  int along = 0, off_ray = 0;     ///< degrees
  std::array<int, 2> variable{};  ///< its factors off the ray, so many as off_ray says
  int number = 0;                 ///< in monomials<6, 2>()

  /// Whether the mirror in the thickness, which turns (σ, τ, φ), changes its sign about a flat
  /// leaf.
  bool turned() const {
    int sum = along;
    for (int f = 0; f < off_ray; ++f) sum += variable[f] < 2;
    return sum % 2 != 0;
  }
};
/// In the order of the columns.
const std::array<StateMonomial, StateTable::even_monomials>& even_monomials();
const std::array<StateMonomial, StateTable::odd_monomials>& odd_monomials();

/// Weights of the coefficients of two neighbouring tables a, b: a number is a·even[0] + b·even[1],
/// or with odd. Monomials off the ray of degree d are the two-point Hermite polynomials of the
/// total + 1 − d Taylor coefficients at either end, for a total degree of 2 or, as a check of that,
/// of 1: then coefficients of degree 2 have no weight.
template <class S>
struct StateWeights {
  std::array<Eigen::Matrix<S, StateTable::even_monomials, 1>, 2> even;
  std::array<Eigen::Matrix<S, StateTable::odd_monomials, 1>, 2> odd;
};

namespace detail {

// Of the Taylor coefficient j (times width^j) of q at t = 0, and of that at t = 1.
template <class S>
std::array<S, 2> hermite_ends(int q, int j, const S& t) {
  const S r = 1.0 - t;
  if (q == 1) return {r, t};
  if (q == 2 && j == 0) return {r * r * (1.0 + 2.0 * t), t * t * (1.0 + 2.0 * r)};
  if (q == 2) return {t * r * r, -1.0 * r * t * t};
  const S r3 = r * r * r, t3 = t * t * t;
  if (j == 0) return {r3 * (1.0 + 3.0 * t + 6.0 * t * t), t3 * (1.0 + 3.0 * r + 6.0 * r * r)};
  if (j == 1) return {t * r3 * (1.0 + 3.0 * t), -1.0 * r * t3 * (1.0 + 3.0 * r)};
  return {t * t * r3, r * r * t3};
}

}  // namespace detail

/// At (σ, z = (τ, φ, N, M1, M2)) between the bent states `a` and `b`.
template <class S>
StateWeights<S> state_weights(double a, double b, const S& sigma, const std::array<S, 5>& z,
                              int total = 2) {
  const double width = b - a;
  const S t = (sigma - a) * (1 / width);
  std::array<std::array<std::array<S, 2>, 3>, 3> ends;  // degree off the ray, along it, end
  const std::array<double, 3> power{1, width, width * width};
  for (int off = 0; off <= total; ++off)
    for (int j = 0; j + off <= total; ++j) {
      ends[off][j] = detail::hermite_ends(total + 1 - off, j, t);
      for (S& x : ends[off][j]) x *= power[j];
    }
  StateWeights<S> weights;
  const auto fill = [&](const auto& monomials, auto& out) {
    for (std::size_t k = 0; k < monomials.size(); ++k) {
      const StateMonomial& m = monomials[k];
      const auto row = static_cast<Eigen::Index>(k);
      for (int end = 0; end < 2; ++end) {
        if (m.along + m.off_ray > total) {
          out[end][row] = S(0.0);
          continue;
        }
        S x = ends[m.off_ray][m.along][end];
        for (int f = 0; f < m.off_ray; ++f) x *= z[m.variable[f]];
        out[end][row] = x;
      }
    }
  };
  fill(even_monomials(), weights.even);
  fill(odd_monomials(), weights.odd);
  return weights;
}

/// The weights for a total degree of 2, a column for their values and one for each of their
/// derivatives along (σ, τ, φ, N, M1, M2).
struct StateWeightSlopes {
  std::array<Eigen::Matrix<double, StateTable::even_monomials, 7>, 2> even;
  std::array<Eigen::Matrix<double, StateTable::odd_monomials, 7>, 2> odd;
};
StateWeightSlopes state_weight_slopes(double a, double b, double sigma,
                                      const std::array<double, 5>& z);

}  // namespace flexopt
