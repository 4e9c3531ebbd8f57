#pragma once
// Truncated algebra of multivariate polynomials.
//
// Monomials stand in graded order: 1; x0, x1, …; x0², x0x1, …, x1², …: by total degree, within it
// by falling exponents of x0, then x1, …. A lower order is therefore a prefix of a higher one.
#include <array>
#include <cassert>
#include <cstdint>
#include <span>
#include <vector>

namespace flexopt {

/// Number of monomials of total degree ≤ order: (variables + order choose order).
constexpr int monomial_count(int variables, int order) {
  long long n = 1;
  for (int k = 1; k <= order; ++k) n = n * (variables + k) / k;
  return static_cast<int>(n);
}

/// Exponents, index look-up and products of the monomials in `variables` up to `order`.
class MonomialTable {
 public:
  MonomialTable(int variables, int order);

  int variables() const { return variables_; }
  int order() const { return order_; }
  int size() const { return static_cast<int>(degree_.size()); }
  /// Number of monomials of degree ≤ d; 0 for d < 0. Those of degree d are [count(d − 1),
  /// count(d)).
  int count(int d) const { return d < 0 ? 0 : count_[d < order_ ? d : order_]; }
  int degree(int i) const { return degree_[i]; }
  std::span<const std::uint8_t> exponents(int i) const {
    return {exponents_.data() + static_cast<std::size_t>(i) * variables_,
            static_cast<std::size_t>(variables_)};
  }
  /// Index of the monomial with these exponents; -1 if its degree exceeds the order.
  int index(std::span<const int> exponents) const;
  /// Indices k of x^i · x^j for j = 0 … count(order − degree(i)) − 1.
  const std::uint16_t* products(int i) const { return product_.data() + product_start_[i]; }

 private:
  int variables_, order_;
  std::vector<int> count_;
  std::vector<int> degree_;
  std::vector<std::uint8_t> exponents_;
  std::vector<std::uint32_t> product_start_;
  std::vector<std::uint16_t> product_;
};

/// The table of (NV, ORDER), built at its first use and shared.
template <int NV, int ORDER>
const MonomialTable& monomials() {
  static const MonomialTable table(NV, ORDER);
  return table;
}

/// c += a b, truncated at the order of the table; a and b hold degrees ≤ max_degree_a, _b only.
/// T: double, or any array of lanes (Eigen::Array<double, 8, 1>); a and c may differ in type from b
/// where the products do. c must not alias a or b.
template <class C, class A, class B>
void add_product(const MonomialTable& table, C* c, const A* a, const B* b, int max_degree_a,
                 int max_degree_b) {
  const int na = table.count(max_degree_a);
  for (int i = 0; i < na; ++i) {
    const int room = table.order() - table.degree(i);
    const int nb = table.count(max_degree_b < room ? max_degree_b : room);
    const std::uint16_t* k = table.products(i);
    const A ai = a[i];
    for (int j = 0; j < nb; ++j) c[k[j]] += ai * b[j];
  }
}

/// The part of c += a b that pairs degree p of a with degree q of b.
template <class C, class A, class B>
void add_homogeneous_product(const MonomialTable& table, C* c, const A* a, const B* b, int p,
                             int q) {
  if (p + q > table.order()) return;
  for (int i = table.count(p - 1); i < table.count(p); ++i) {
    const std::uint16_t* k = table.products(i);
    const A ai = a[i];
    for (int j = table.count(q - 1); j < table.count(q); ++j) c[k[j]] += ai * b[j];
  }
}

/// The degree-n part of c += a b alone: all that a recursion over degrees needs.
template <class C, class A, class B>
void add_product_of_degree(const MonomialTable& table, C* c, const A* a, const B* b, int n,
                           int max_degree_a, int max_degree_b) {
  for (int p = 0; p <= n && p <= max_degree_a; ++p)
    if (n - p <= max_degree_b) add_homogeneous_product(table, c, a, b, p, n - p);
}

/// c += weight a², truncated at the order of the table; a holds degrees ≤ max_degree only.
template <class C, class A, class W>
void add_square(const MonomialTable& table, C* c, const A* a, const W& weight, int max_degree) {
  const int na = table.count(max_degree);
  for (int i = 0; i < na; ++i) {
    const int room = table.order() - table.degree(i);
    const int nb = table.count(max_degree < room ? max_degree : room);
    if (nb <= i) break;
    const std::uint16_t* k = table.products(i);
    const A ai = weight * a[i], twice = ai + ai;
    c[k[i]] += ai * a[i];
    for (int j = i + 1; j < nb; ++j) c[k[j]] += twice * a[j];
  }
}

/// Polynomial in NV variables to degree ORDER with coefficients T.
template <int NV, int ORDER, class T = double>
struct Polynomial {
  static constexpr int size = monomial_count(NV, ORDER);
  std::array<T, size> c;

  static const MonomialTable& table() { return monomials<NV, ORDER>(); }

  static Polynomial constant(const T& value) {
    Polynomial p;
    p.c.fill(T(value * 0.0));
    p.c[0] = value;
    return p;
  }
  /// value + slope · x_i.
  static Polynomial variable(int i, const T& value, const T& slope) {
    Polynomial p = constant(value);
    p.c[1 + i] = slope;
    return p;
  }

  T& operator[](int i) { return c[i]; }
  const T& operator[](int i) const { return c[i]; }

  Polynomial& operator+=(const Polynomial& b) {
    for (int i = 0; i < size; ++i) c[i] += b.c[i];
    return *this;
  }
  Polynomial& operator-=(const Polynomial& b) {
    for (int i = 0; i < size; ++i) c[i] -= b.c[i];
    return *this;
  }
  Polynomial& operator*=(const T& s) {
    for (int i = 0; i < size; ++i) c[i] *= s;
    return *this;
  }
  friend Polynomial operator+(Polynomial a, const Polynomial& b) { return a += b; }
  friend Polynomial operator-(Polynomial a, const Polynomial& b) { return a -= b; }
  friend Polynomial operator*(Polynomial a, const T& s) { return a *= s; }
  friend Polynomial operator*(const T& s, Polynomial a) { return a *= s; }
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b) {
    Polynomial r = constant(T(a.c[0] * 0.0));
    add_product(table(), r.c.data(), a.c.data(), b.c.data(), ORDER, ORDER);
    return r;
  }
};

/// f(q) where taylor[k] = f⁽ᵏ⁾(q0)/k! at q0 = q[0]; terms beyond ORDER vanish by truncation.
template <int NV, int ORDER, class T>
Polynomial<NV, ORDER, T> compose(std::span<const T> taylor, Polynomial<NV, ORDER, T> q) {
  using P = Polynomial<NV, ORDER, T>;
  q.c[0] = T(q.c[0] * 0.0);
  assert(!taylor.empty());
  int k = static_cast<int>(taylor.size()) - 1;
  if (k > ORDER) k = ORDER;
  P r = P::constant(taylor[k]);
  // Horner. k factors q, which has no constant part, are still to come: degree ≤ ORDER − k will do.
  while (k-- > 0) {
    P next = P::constant(taylor[k]);
    add_product(P::table(), next.c.data(), q.c.data(), r.c.data(), ORDER - k, ORDER - k - 1);
    r = next;
  }
  return r;
}

}  // namespace flexopt
