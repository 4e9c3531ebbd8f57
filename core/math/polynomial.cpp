#include "core/math/polynomial.hpp"

#include <cassert>

namespace flexopt {

MonomialTable::MonomialTable(int variables, int order) : variables_(variables), order_(order) {
  assert(variables > 0 && order >= 0 && monomial_count(variables, order) <= 65536);
  for (int d = 0; d <= order; ++d) count_.push_back(monomial_count(variables, d));
  const int n = count_.back();
  degree_.reserve(n);
  exponents_.reserve(static_cast<std::size_t>(n) * variables);

  // Successor within a degree: takes one from the last nonzero exponent before the end and gives
  // it, with all that stood at the end, to its right neighbour.
  std::vector<std::uint8_t> e(variables);
  for (int d = 0; d <= order; ++d) {
    std::fill(e.begin(), e.end(), 0);
    e[0] = static_cast<std::uint8_t>(d);
    while (true) {
      degree_.push_back(d);
      exponents_.insert(exponents_.end(), e.begin(), e.end());
      int v = variables - 2;
      while (v >= 0 && e[v] == 0) --v;
      if (v < 0) break;
      const std::uint8_t tail = e[variables - 1];
      e[variables - 1] = 0;
      --e[v];
      e[v + 1] = static_cast<std::uint8_t>(tail + 1);
    }
  }

  std::vector<int> sum(variables);
  for (int i = 0; i < n; ++i) {
    product_start_.push_back(static_cast<std::uint32_t>(product_.size()));
    const auto ei = this->exponents(i);
    for (int j = 0; j < count(order - degree_[i]); ++j) {
      const auto ej = this->exponents(j);
      for (int v = 0; v < variables; ++v) sum[v] = ei[v] + ej[v];
      product_.push_back(static_cast<std::uint16_t>(index(sum)));
    }
  }
}

int MonomialTable::index(std::span<const int> exponents) const {
  assert(static_cast<int>(exponents.size()) == variables_);
  int rest = 0;
  for (int e : exponents) rest += e;
  if (rest > order_) return -1;
  int i = count(rest - 1);
  for (int v = 0; v < variables_; ++v) {
    // those before it share the exponents so far and have a larger one here
    const int room = rest - exponents[v] - 1;
    if (room >= 0) i += monomial_count(variables_ - v - 1, room);
    rest -= exponents[v];
  }
  return i;
}

}  // namespace flexopt
