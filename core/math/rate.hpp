#pragma once
// A number of any kind with its derivative, as a scalar of Eigen: what is written for any scalar is
// differentiated by it, jets too.
#include "core/math/jet.hpp"

namespace flexopt {

template <class S>
struct Rate {
  S value{}, rate{};

  Rate() = default;
  Rate(double x) : value(x), rate(0.0) {}
  Rate(const S& x, const S& dx) : value(x), rate(dx) {}

  Rate& operator+=(const Rate& b) { return *this = *this + b; }
  Rate& operator-=(const Rate& b) { return *this = *this - b; }
  Rate& operator*=(const Rate& b) { return *this = *this * b; }
  Rate& operator/=(const Rate& b) { return *this = *this / b; }

  friend Rate operator-(const Rate& a) { return {-a.value, -a.rate}; }
  friend Rate operator+(const Rate& a, const Rate& b) {
    return {a.value + b.value, a.rate + b.rate};
  }
  friend Rate operator-(const Rate& a, const Rate& b) {
    return {a.value - b.value, a.rate - b.rate};
  }
  friend Rate operator*(const Rate& a, const Rate& b) {
    return {a.value * b.value, a.value * b.rate + a.rate * b.value};
  }
  friend Rate operator/(const Rate& a, const Rate& b) {
    const S q = a.value / b.value;
    return {q, (a.rate - q * b.rate) / b.value};
  }
  friend bool operator==(const Rate&, const Rate&) = default;
  friend Rate sqrt(const Rate& a) {
    using std::sqrt;
    const S root = sqrt(a.value);
    return {root, 0.5 * a.rate / root};
  }
};

/// The number itself, without its rates.
inline double plain(double x) { return x; }
inline double plain(const Jet& x) { return x.c[0]; }
template <class S>
double plain(const Rate<S>& x) {
  return plain(x.value);
}

}  // namespace flexopt

namespace Eigen {

template <class S>
struct NumTraits<flexopt::Rate<S>> : GenericNumTraits<flexopt::Rate<S>> {
  using Real = flexopt::Rate<S>;
  using NonInteger = flexopt::Rate<S>;
  using Nested = flexopt::Rate<S>;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 0,
    ReadCost = 2 * NumTraits<S>::ReadCost,
    AddCost = 2 * NumTraits<S>::AddCost,
    MulCost = 3 * NumTraits<S>::MulCost
  };
};

template <class S, class Op>
struct ScalarBinaryOpTraits<flexopt::Rate<S>, double, Op> {
  using ReturnType = flexopt::Rate<S>;
};
template <class S, class Op>
struct ScalarBinaryOpTraits<double, flexopt::Rate<S>, Op> {
  using ReturnType = flexopt::Rate<S>;
};

}  // namespace Eigen
