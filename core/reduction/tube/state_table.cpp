#include "core/reduction/tube/state_table.hpp"

#include "core/math/dual.hpp"
#include "core/math/polynomial.hpp"

namespace flexopt {
namespace {

template <std::size_t N>
std::array<StateMonomial, N> monomials_of(bool even) {
  const MonomialTable& table = monomials<6, 2>();
  std::array<StateMonomial, N> all;
  std::size_t n = 0;
  for (int m = 0; m < table.size(); ++m) {
    const auto e = table.exponents(m);
    if (((e[2] + e[4] + e[5]) % 2 == 0) != even) continue;
    StateMonomial& one = all[n++];
    one = {e[0], table.degree(m) - e[0], {}, m};
    int factors = 0;
    for (int v = 0; v < 5; ++v)
      for (int p = 0; p < e[1 + v]; ++p) one.variable[factors++] = v;
  }
  for (int tau = 0; n < N; ++n, ++tau) all[n] = {3 - tau, tau, {}, table.size() + tau};
  return all;
}

}  // namespace

template <int evens>
const std::array<StateMonomial, evens>& even_monomials() {
  static const auto all = monomials_of<evens>(true);
  return all;
}
const std::array<StateMonomial, StateTable::odd_monomials>& odd_monomials() {
  static const auto all = monomials_of<StateTable::odd_monomials>(false);
  return all;
}

template <int evens>
StateWeightSlopes<evens> state_weight_slopes(double a, double b, double sigma,
                                             const std::array<double, 5>& z) {
  using Dual6 = Dual<6>;
  std::array<Dual6, 5> variables;
  for (int v = 0; v < 5; ++v)
    variables[static_cast<std::size_t>(v)] = Dual6::variable(z[static_cast<std::size_t>(v)], 1 + v);
  const auto weights = state_weights<evens>(a, b, Dual6::variable(sigma, 0), variables);
  StateWeightSlopes<evens> slopes;
  const auto fill = [](const auto& from, auto& to) {
    for (std::size_t end = 0; end < 2; ++end)
      for (Eigen::Index m = 0; m < from[end].size(); ++m) {
        to[end](m, 0) = from[end][m].value;
        for (int v = 0; v < 6; ++v)
          to[end](m, 1 + v) = from[end][m].derivatives[static_cast<std::size_t>(v)];
      }
  };
  fill(weights.even, slopes.even);
  fill(weights.odd, slopes.odd);
  return slopes;
}

template const std::array<StateMonomial, StateTable::even_monomials>&
even_monomials<StateTable::even_monomials>();
template const std::array<StateMonomial, StateTable::even_of_stress>&
even_monomials<StateTable::even_of_stress>();
template StateWeightSlopes<StateTable::even_monomials> state_weight_slopes(
    double a, double b, double sigma, const std::array<double, 5>& z);
template StateWeightSlopes<StateTable::even_of_stress> state_weight_slopes(
    double a, double b, double sigma, const std::array<double, 5>& z);

}  // namespace flexopt
