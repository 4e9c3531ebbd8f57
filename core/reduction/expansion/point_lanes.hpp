#pragma once
// Eight numbers at once, with derivatives or without: those at the membrane points of an element,
// or eight coefficients of a potential.
#include <array>

#include "core/math/dual.hpp"
#include "core/math/wide.hpp"

namespace flexopt {

/// A number at the eight membrane points of an element.
using Lanes8 = Eight;

/// A number at the eight membrane points of an element, with its derivatives.
template <int n>
struct DualLanes8 {
  Lanes8 value;
  std::array<Lanes8, n> derivatives;

  DualLanes8& operator+=(const DualLanes8& b) {
    value += b.value;
    for (int k = 0; k < n; ++k) derivatives[k] += b.derivatives[k];
    return *this;
  }
  DualLanes8& operator-=(double b) {
    value -= b;
    return *this;
  }
  DualLanes8& operator-=(const DualLanes8& b) {
    value -= b.value;
    for (int k = 0; k < n; ++k) derivatives[k] -= b.derivatives[k];
    return *this;
  }
  DualLanes8& operator*=(double b) {
    value *= b;
    for (int k = 0; k < n; ++k) derivatives[k] *= b;
    return *this;
  }
  friend DualLanes8 operator+(DualLanes8 a, const DualLanes8& b) { return a += b; }
  friend DualLanes8 operator*(const DualLanes8& a, const DualLanes8& b) {
    DualLanes8 c;
    c.value = a.value * b.value;
    for (int k = 0; k < n; ++k)
      c.derivatives[k] = a.value * b.derivatives[k] + a.derivatives[k] * b.value;
    return c;
  }
  friend DualLanes8 operator*(const Dual<n>& a, const DualLanes8& b) {
    DualLanes8 c;
    c.value = a.value * b.value;
    for (int k = 0; k < n; ++k)
      c.derivatives[k] = a.value * b.derivatives[k] + a.derivatives[k] * b.value;
    return c;
  }
};

template <int n>
DualLanes8<n> operator*(const Dual<n>& a, const Lanes8& b) {
  DualLanes8<n> c{a.value * b, {}};
  for (int k = 0; k < n; ++k) c.derivatives[k] = a.derivatives[k] * b;
  return c;
}

template <class S>
struct PointLanes;
template <>
struct PointLanes<double> {
  using type = Lanes8;
  static type constant(double value) { return Lanes8::all(value); }
  static void set(type& lanes, int g, double value) { lanes.set(g, value); }
  static double get(const type& lanes, int g) { return lanes[g]; }
};
template <int n>
struct PointLanes<Dual<n>> {
  using type = DualLanes8<n>;
  static type constant(double value) {
    type lanes{};
    lanes.value += value;
    return lanes;
  }
  static void set(type& lanes, int g, const Dual<n>& value) {
    lanes.value.set(g, value.value);
    for (int k = 0; k < n; ++k) lanes.derivatives[k].set(g, value.derivatives[k]);
  }
  static Dual<n> get(const type& lanes, int g) {
    Dual<n> value(lanes.value[g]);
    for (int k = 0; k < n; ++k) value.derivatives[k] = lanes.derivatives[k][g];
    return value;
  }
};
/// Eight numbers that stand one after the other.
template <class S>
typename PointLanes<S>::type lanes_from(const S* numbers) {
  typename PointLanes<S>::type lanes;
  for (int g = 0; g < 8; ++g) PointLanes<S>::set(lanes, g, numbers[g]);
  return lanes;
}

}  // namespace flexopt
