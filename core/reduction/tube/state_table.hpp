#pragma once
// Numbers that a leaf's state determines, as polynomials to second order about the bent states of a
// tube, joined between neighbouring ones. Equation (D6) of core/reduction/README.md.
#include <array>

#include "core/math/types.hpp"

namespace flexopt {

/// Taylor coefficients of any numbers about one bent state, in (σ − sigma, τ, φ, N, M1, M2), forces
/// over their scale and from the force centre: numbers × monomials (polynomial.hpp, 6 variables,
/// degree ≤ 2). Numbers that the mirror across the width keeps have the monomials that are even in
/// (φ, M1, M2), the others those that are odd. Tables of stress have four even ones more, behind
/// the others: σ³, σ²τ, στ² and τ³, for the slopes across the ray.
struct StateTable {
  static constexpr int even_monomials = 16, odd_monomials = 12;
  static constexpr int even_of_stress = even_monomials + 4;
  double sigma = 0;
  MatrixXd even, odd;
};

/// A monomial σ^along (τ, φ, N, M1, M2)^… of one parity.
struct StateMonomial {
  int along = 0, off_ray = 0;     ///< degrees
  std::array<int, 3> variable{};  ///< its factors off the ray, so many as off_ray says
  int number = 0;                 ///< in monomials<6, 2>(), then σ³, σ²τ, στ² and τ³

  /// Whether the monomial is one of (σ, τ) alone.
  bool bending() const {
    int others = 0;
    for (int f = 0; f < off_ray; ++f) others += variable[f];
    return others == 0;
  }
};
/// Monomials in the order of the columns of a table.
template <int evens = StateTable::even_monomials>
const std::array<StateMonomial, evens>& even_monomials();
const std::array<StateMonomial, StateTable::odd_monomials>& odd_monomials();

/// Weights of the coefficients of two neighbouring tables a, b: a number is a·even[0] + b·even[1],
/// or with odd. Monomials off the ray of degree d are the two-point Hermite polynomials of the
/// total + 1 − d Taylor coefficients at either end, for a total degree of 2 (of stress in (σ, τ)
/// alone 3) or, as a check of that, of 1: then coefficients of higher degree have no weight.
template <class S, int evens = StateTable::even_monomials>
struct StateWeights {
  std::array<Eigen::Matrix<S, evens, 1>, 2> even;
  std::array<Eigen::Matrix<S, StateTable::odd_monomials, 1>, 2> odd;
};
using StressWeights = StateWeights<double, StateTable::even_of_stress>;

namespace detail {

// Two-point Hermite weights of the Taylor coefficient j (times width^j) of q at t = 0, and at t =
// 1: tʲ (1 − t)^q Σ_k C(q − 1 + k, k) tᵏ, k < q − j, and its mirror image.
template <class S>
std::array<S, 2> hermite_ends(int q, int j, const S& t) {
  const auto end = [&](const S& x, const S& y) {
    S sum(1.0), power(1.0);
    double binomial = 1;
    for (int k = 1; k < q - j; ++k) {
      power *= x;
      binomial *= static_cast<double>(q - 1 + k) / k;
      sum += binomial * power;
    }
    for (int k = 0; k < q; ++k) sum *= y;
    for (int k = 0; k < j; ++k) sum *= x;
    return sum;
  };
  const S r = 1.0 - t;
  return {end(t, r), (j % 2 == 0 ? 1.0 : -1.0) * end(r, t)};
}

}  // namespace detail

/// Weights at (σ, z = (τ, φ, N, M1, M2)) between the bent states `a` and `b`.
template <int evens = StateTable::even_monomials, class S>
StateWeights<S, evens> state_weights(double a, double b, const S& sigma, const std::array<S, 5>& z,
                                     int total = 2) {
  const double width = b - a;
  const S t = (sigma - a) * (1 / width);
  constexpr bool of_stress = evens == StateTable::even_of_stress;
  const int most = of_stress && total == 2 ? 3 : total;
  std::array<std::array<std::array<S, 2>, 4>, 5>
      ends;  // coefficients at an end, which of them, end
  const std::array<double, 4> power{1, width, width * width, width * width * width};
  for (int q = 1; q <= most + 1; ++q)
    for (int j = 0; j < q; ++j) {
      ends[q][j] = detail::hermite_ends(q, j, t);
      for (S& x : ends[q][j]) x *= power[j];
    }
  StateWeights<S, evens> weights;
  const auto fill = [&](const auto& monomials, auto& out) {
    for (std::size_t k = 0; k < monomials.size(); ++k) {
      const StateMonomial& m = monomials[k];
      const auto row = static_cast<Eigen::Index>(k);
      const int degree = m.bending() ? most : total;
      for (int end = 0; end < 2; ++end) {
        if (m.along + m.off_ray > degree) {
          out[end][row] = S(0.0);
          continue;
        }
        S x = ends[degree + 1 - m.off_ray][m.along][end];
        for (int f = 0; f < m.off_ray; ++f) x *= z[m.variable[f]];
        out[end][row] = x;
      }
    }
  };
  fill(even_monomials<evens>(), weights.even);
  fill(odd_monomials(), weights.odd);
  return weights;
}

/// The weights for a total degree of 2, a column for their values and one for each of their
/// derivatives along (σ, τ, φ, N, M1, M2).
template <int evens = StateTable::even_monomials>
struct StateWeightSlopes {
  std::array<Eigen::Matrix<double, evens, 7>, 2> even;
  std::array<Eigen::Matrix<double, StateTable::odd_monomials, 7>, 2> odd;
};
template <int evens = StateTable::even_monomials>
StateWeightSlopes<evens> state_weight_slopes(double a, double b, double sigma,
                                             const std::array<double, 5>& z);

}  // namespace flexopt
