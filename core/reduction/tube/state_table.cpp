#include "core/reduction/tube/state_table.hpp"

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
  return all;
}

}  // namespace

const std::array<StateMonomial, StateTable::even_monomials>& even_monomials() {
  static const auto all = monomials_of<StateTable::even_monomials>(true);
  return all;
}
const std::array<StateMonomial, StateTable::odd_monomials>& odd_monomials() {
  static const auto all = monomials_of<StateTable::odd_monomials>(false);
  return all;
}

}  // namespace flexopt
