#pragma once
// Power series in a path parameter s, cut off after s²: c[0] + c[1] s + c[2] s².
#include <array>

#include "core/math/types.hpp"

namespace flexopt {

template <class T>
using Series = std::array<T, 3>;

/// sum += a b, order by order; `product(a_i, b_j)` returns what is added.
template <class A, class B, class C, class Product>
void add_product(Series<C>& sum, const Series<A>& a, const Series<B>& b, const Product& product) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; i + j < 3; ++j) sum[i + j] += product(a[i], b[j]);
}

}  // namespace flexopt
