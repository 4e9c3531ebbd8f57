#pragma once
// Forward differentiation of short formulas: a value with its derivatives in a fixed number of
// variables. Everything that is written for a template scalar and calls its functions unqualified
// (sqrt(x) after `using std::sqrt`) accepts these numbers, and so do Eigen's matrices of them.
//
// For the few scalars that enter a formula, not for matrices: where matrices are multiplied, carry
// values and derivatives as matrices of double and write out the product rule. Eigen would compile
// its product kernels anew for each of these types.
//
// Where the number of variables is known at run time only, take a Dual<1> for one direction after
// the other: no upper bound is needed, and directions that nobody wants cost nothing.
#include <Eigen/Core>
#include <array>
#include <cmath>
#include <compare>

namespace flexopt {

/// x + Σ_k ẋ_k ε_k with ε_j ε_k = 0.
template <int n>
struct Dual {
  static_assert(n > 0);
  using Derivatives = std::array<double, n>;

  double value = 0;
  Derivatives derivatives{};

  Dual() = default;
  Dual(double constant) : value(constant) {}
  Dual(double value, const Derivatives& derivatives) : value(value), derivatives(derivatives) {}
  /// The variable k of the n, 0 ≤ k < n.
  static Dual variable(double value, int k) {
    Dual x(value);
    x.derivatives[k] = 1;
    return x;
  }

  /// f(x) of an f with this value and slope at x: the chain rule.
  Dual chained(double f, double slope) const {
    Dual y(f);
    for (int k = 0; k < n; ++k) y.derivatives[k] = slope * derivatives[k];
    return y;
  }

  Dual& operator+=(const Dual& b) {
    value += b.value;
    for (int k = 0; k < n; ++k) derivatives[k] += b.derivatives[k];
    return *this;
  }
  Dual& operator-=(const Dual& b) {
    value -= b.value;
    for (int k = 0; k < n; ++k) derivatives[k] -= b.derivatives[k];
    return *this;
  }
  Dual& operator*=(const Dual& b) {
    const double a = value, by = b.value;  // b may be *this
    value = a * by;
    for (int k = 0; k < n; ++k) derivatives[k] = derivatives[k] * by + a * b.derivatives[k];
    return *this;
  }
  Dual& operator/=(const Dual& b) {
    const double by = b.value, quotient = value / by;
    value = quotient;
    for (int k = 0; k < n; ++k)
      derivatives[k] = (derivatives[k] - quotient * b.derivatives[k]) / by;
    return *this;
  }
  Dual& operator+=(double b) {
    value += b;
    return *this;
  }
  Dual& operator-=(double b) {
    value -= b;
    return *this;
  }
  Dual& operator*=(double b) {
    value *= b;
    for (double& d : derivatives) d *= b;
    return *this;
  }
  Dual& operator/=(double b) {
    value /= b;
    for (double& d : derivatives) d /= b;
    return *this;
  }

  friend Dual operator+(const Dual& a) { return a; }
  friend Dual operator-(const Dual& a) { return a.chained(-a.value, -1); }
  friend Dual operator+(Dual a, const Dual& b) { return a += b; }
  friend Dual operator+(Dual a, double b) { return a += b; }
  friend Dual operator+(double a, Dual b) { return b += a; }
  friend Dual operator-(Dual a, const Dual& b) { return a -= b; }
  friend Dual operator-(Dual a, double b) { return a -= b; }
  friend Dual operator-(double a, const Dual& b) { return b.chained(a - b.value, -1); }
  friend Dual operator*(Dual a, const Dual& b) { return a *= b; }
  friend Dual operator*(Dual a, double b) { return a *= b; }
  friend Dual operator*(double a, Dual b) { return b *= a; }
  friend Dual operator/(Dual a, const Dual& b) { return a /= b; }
  friend Dual operator/(Dual a, double b) { return a /= b; }
  friend Dual operator/(double a, const Dual& b) {
    return b.chained(a / b.value, -a / (b.value * b.value));
  }

  /// Values alone are compared, so that a formula takes the branch that its value takes.
  friend bool operator==(const Dual& a, const Dual& b) { return a.value == b.value; }
  friend std::partial_ordering operator<=>(const Dual& a, const Dual& b) {
    return a.value <=> b.value;
  }
  friend bool operator==(const Dual& a, double b) { return a.value == b; }
  friend std::partial_ordering operator<=>(const Dual& a, double b) { return a.value <=> b; }

  friend bool isfinite(const Dual& x) {
    for (const double d : x.derivatives)
      if (!std::isfinite(d)) return false;
    return std::isfinite(x.value);
  }

  /// Absolute value; at the kink, the derivative of the side of positive values.
  friend Dual abs(const Dual& x) { return x.value < 0 ? -x : x; }
  /// Square root. At 0 it has no derivative: infinite, or not a number where x does not change
  /// there.
  friend Dual sqrt(const Dual& x) {
    const double root = std::sqrt(x.value);
    return x.chained(root, 0.5 / root);
  }
  friend Dual exp(const Dual& x) {
    const double e = std::exp(x.value);
    return x.chained(e, e);
  }
  friend Dual log(const Dual& x) { return x.chained(std::log(x.value), 1 / x.value); }
  friend Dual log10(const Dual& x) {
    return x.chained(std::log10(x.value), 1 / (x.value * 2.302585092994045684));
  }
  friend Dual sin(const Dual& x) { return x.chained(std::sin(x.value), std::cos(x.value)); }
  friend Dual cos(const Dual& x) { return x.chained(std::cos(x.value), -std::sin(x.value)); }
  friend Dual tan(const Dual& x) {
    const double t = std::tan(x.value);
    return x.chained(t, 1 + t * t);
  }
  friend Dual asin(const Dual& x) {
    return x.chained(std::asin(x.value), 1 / std::sqrt(1 - x.value * x.value));
  }
  friend Dual acos(const Dual& x) {
    return x.chained(std::acos(x.value), -1 / std::sqrt(1 - x.value * x.value));
  }
  friend Dual atan(const Dual& x) {
    return x.chained(std::atan(x.value), 1 / (1 + x.value * x.value));
  }
  friend Dual atan2(const Dual& y, const Dual& x) {
    const double square = x.value * x.value + y.value * y.value;
    Dual angle(std::atan2(y.value, x.value));
    for (int k = 0; k < n; ++k)
      angle.derivatives[k] = (x.value * y.derivatives[k] - y.value * x.derivatives[k]) / square;
    return angle;
  }
  friend Dual sinh(const Dual& x) { return x.chained(std::sinh(x.value), std::cosh(x.value)); }
  friend Dual cosh(const Dual& x) { return x.chained(std::cosh(x.value), std::sinh(x.value)); }
  friend Dual tanh(const Dual& x) {
    const double t = std::tanh(x.value);
    return x.chained(t, 1 - t * t);
  }
  friend Dual pow(const Dual& x, double power) {
    const double slope = power == 0 ? 0 : power * std::pow(x.value, power - 1);
    return x.chained(std::pow(x.value, power), slope);
  }
  /// x > 0, or x = 0 with an exponent that does not change.
  friend Dual pow(const Dual& x, const Dual& power) {
    Dual y = pow(x, power.value);
    for (int k = 0; k < n; ++k)
      if (power.derivatives[k] != 0)
        y.derivatives[k] += y.value * std::log(x.value) * power.derivatives[k];
    return y;
  }
};

/// The numbers of variables in use: one direction of the design; the shape of a leaf (w/L, t/L, ν);
/// what the chord frame of a leaf sees (generalised strains, spins of the edges, their
/// displacement apart).
using Dual1 = Dual<1>;

/// The number without its derivatives.
inline double value_of(double x) { return x; }
template <int n>
double value_of(const Dual<n>& x) {
  return x.value;
}

}  // namespace flexopt

namespace Eigen {

template <int n>
struct NumTraits<flexopt::Dual<n>> : NumTraits<double> {
  using Real = flexopt::Dual<n>;
  using NonInteger = flexopt::Dual<n>;
  using Nested = flexopt::Dual<n>;
  using Literal = double;
  enum {
    IsComplex = 0,
    IsInteger = 0,
    IsSigned = 1,
    RequireInitialization = 1,
    ReadCost = 1 + n,
    AddCost = 1 + n,
    MulCost = 1 + 3 * n
  };
};

template <int n, class Op>
struct ScalarBinaryOpTraits<flexopt::Dual<n>, double, Op> {
  using ReturnType = flexopt::Dual<n>;
};
template <int n, class Op>
struct ScalarBinaryOpTraits<double, flexopt::Dual<n>, Op> {
  using ReturnType = flexopt::Dual<n>;
};

}  // namespace Eigen
