#pragma once
// Derivatives by central differences.
#include <type_traits>

namespace flexopt::test {

/// The derivative at zero, of fourth order in h, of a function whose values are numbers or
/// matrices.
template <class F>
auto slope_at_zero(const F& f, double h) {
  using Value = std::decay_t<decltype(f(h))>;
  return Value((8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h));
}

}  // namespace flexopt::test
