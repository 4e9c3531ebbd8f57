#pragma once
// The terms of a tube potential and how they stand in lanes: what fills its intervals and what
// evaluates them must agree on.
#include <array>
#include <utility>
#include <vector>

#include "core/reduction/expansion/point_lanes.hpp"
#include "core/reduction/tube/tube_potential.hpp"

namespace flexopt::potential {

using Lanes = TubePotential::Lanes;
constexpr int lanes = 8;
template <class T>
using LanesOf = typename PointLanes<T>::type;

/// Calls f(integral_constant<int, i>) for i = 0 … N − 1, unrolled.
template <int N, class F>
void unrolled(F&& f) {
  [&]<int... i>(std::integer_sequence<int, i...>) { (f(std::integral_constant<int, i>()), ...); }
  (std::make_integer_sequence<int, N>());
}

struct Power2 {
  int tau, N;
};
/// Monomials in x = (τ, N) up to a degree, graded.
template <int Degree>
constexpr auto x_monomials() {
  std::array<Power2, (Degree + 1) * (Degree + 2) / 2> m{};
  int i = 0;
  for (int g = 0; g <= Degree; ++g)
    for (int b = 0; b <= g; ++b) m[i++] = {g - b, b};
  return m;
}

struct Power3 {
  int e[3];
};
/// Monomials in y = (φ, M1, M2) of exactly this degree.
template <int Degree>
constexpr auto y_monomials() {
  std::array<Power3, (Degree + 1) * (Degree + 2) / 2> m{};
  int i = 0;
  for (int a = Degree; a >= 0; --a)
    for (int b = Degree - a; b >= 0; --b) m[i++] = {{a, b, Degree - a - b}};
  return m;
}

/// Entries of a symmetric 3×3 matrix in the first six lanes.
constexpr int pair_i[6] = {0, 0, 0, 1, 1, 2}, pair_j[6] = {0, 1, 2, 1, 2, 2};

constexpr double binomial(int n, int k) {
  double r = 1;
  for (int i = 1; i <= k; ++i) r = r * (n - k + i) / i;
  return r;
}

/// Degrees k ≥ 2 of y, the odd ones too or not.
constexpr int y_blocks(int degree, bool odd) { return odd ? degree - 2 : (degree - 1) / 2; }
constexpr int y_degree(int block, bool odd) { return odd ? block + 2 : 2 * block + 2; }

template <int Degree>
constexpr int x_vectors() {
  return (static_cast<int>(x_monomials<Degree - 1>().size()) + lanes - 1) / lanes;
}

/// Calls f.operator()<degree, odd>(), degrees from 3 to 7, odd ones from 4.
template <int Degree = 3, class F>
auto dispatch(int degree, bool odd, F&& f) {
  if constexpr (Degree < 7)
    if (degree != Degree) return dispatch<Degree + 1>(degree, odd, f);
  if constexpr (Degree > 3)
    if (odd) return f.template operator()<Degree, true>();
  return f.template operator()<Degree, false>();
}

/// Coefficients of an interval in the order in which TubePotential::evaluate() reads them. `odd`:
/// with odd powers of (φ, M1, M2); `mirrored`: about sigma = 0, without what the mirror symmetry in
/// the thickness forbids.
std::vector<Lanes> interval_coefficients(int degree, bool odd, const TubeNode& a, const TubeNode& b,
                                         bool mirrored);

}  // namespace flexopt::potential
