#include "core/math/polynomial.hpp"

#include <catch2/catch.hpp>
#include <random>

#include "support/monomials.hpp"

using namespace flexopt;

namespace {

template <int NV, int ORDER>
Polynomial<NV, ORDER> random_polynomial(std::mt19937& engine) {
  std::uniform_real_distribution<double> d(-1, 1);
  Polynomial<NV, ORDER> p;
  for (double& c : p.c) c = d(engine);
  return p;
}

}  // namespace

TEST_CASE("monomials stand in graded order and are found by their exponents") {
  CHECK(monomial_count(6, 2) == 28);
  CHECK(monomial_count(6, 3) == 84);
  CHECK(monomial_count(6, 5) == 462);
  CHECK(monomial_count(6, 7) == 1716);

  for (int variables : {1, 2, 6})
    for (int order : {0, 1, 2, 3, 5, 7}) {
      const MonomialTable t(variables, order);
      REQUIRE(t.size() == monomial_count(variables, order));
      for (int i = 0; i < t.size(); ++i) {
        const auto e = t.exponents(i);
        const std::vector<int> ei(e.begin(), e.end());
        int degree = 0;
        for (int k : ei) degree += k;
        REQUIRE(degree == t.degree(i));
        REQUIRE(t.index(ei) == i);
        REQUIRE((t.count(degree - 1) <= i && i < t.count(degree)));
        if (i > 0 && t.degree(i - 1) == degree) {  // falling exponents within a degree
          const auto b = t.exponents(i - 1);
          REQUIRE(std::vector<int>(b.begin(), b.end()) > ei);
        }
      }
    }

  const MonomialTable t(6, 5);
  const std::vector<int> too_high{2, 2, 2, 0, 0, 0};
  CHECK(t.index(too_high) == -1);
  for (int v = 0; v < 6; ++v) {
    std::vector<int> e(6, 0);
    e[v] = 1;
    CHECK(t.index(e) == 1 + v);
  }
}

TEST_CASE("the product of polynomials is the product of their values") {
  std::mt19937 engine(1);
  // degrees 3 and 4: nothing of the product is cut off at 7
  auto a = random_polynomial<6, 7>(engine), b = random_polynomial<6, 7>(engine);
  const MonomialTable& t = a.table();
  for (int i = t.count(3); i < t.size(); ++i) a[i] = 0;
  for (int i = t.count(4); i < t.size(); ++i) b[i] = 0;
  const auto c = a * b;
  auto partial = Polynomial<6, 7>::constant(0);
  add_product(t, partial.c.data(), a.c.data(), b.c.data(), 3, 4);

  std::uniform_real_distribution<double> d(-1, 1);
  for (int n = 0; n < 20; ++n) {
    std::vector<double> x(6);
    for (double& v : x) v = d(engine);
    const double expected = test::polynomial_value(t, a.c, x) * test::polynomial_value(t, b.c, x);
    REQUIRE(std::abs(expected) > 1e-6);
    CHECK(test::polynomial_value(t, c.c, x) == Approx(expected).epsilon(1e-11));
    CHECK(test::polynomial_value(t, partial.c, x) == Approx(expected).epsilon(1e-11));
  }
}

TEST_CASE("truncation keeps a prefix, and parts of a product add up") {
  std::mt19937 engine(2);
  const auto a = random_polynomial<6, 5>(engine), b = random_polynomial<6, 5>(engine);
  const auto c = a * b;
  Polynomial<6, 3> a3, b3;
  std::copy_n(a.c.begin(), a3.size, a3.c.begin());
  std::copy_n(b.c.begin(), b3.size, b3.c.begin());
  const auto c3 = a3 * b3;
  for (int i = 0; i < c3.size; ++i) CHECK(c3[i] == Approx(c[i]).epsilon(1e-13));

  const MonomialTable& t = a.table();
  auto by_degree = Polynomial<6, 5>::constant(0);
  for (int n = 0; n <= 5; ++n)
    add_product_of_degree(t, by_degree.c.data(), a.c.data(), b.c.data(), n, 5, 5);
  auto by_pairs = Polynomial<6, 5>::constant(0);
  for (int p = 0; p <= 5; ++p)
    for (int q = 0; q <= 5; ++q)
      add_homogeneous_product(t, by_pairs.c.data(), a.c.data(), b.c.data(), p, q);
  for (int i = 0; i < c.size; ++i) {
    CHECK(by_degree[i] == Approx(c[i]).epsilon(1e-12).margin(1e-13));
    CHECK(by_pairs[i] == Approx(c[i]).epsilon(1e-12).margin(1e-13));
  }
}

TEST_CASE("lanes of coefficients multiply like eight polynomials") {
  using Lanes = Eigen::Array<double, 8, 1>;
  std::mt19937 engine(3);
  Polynomial<6, 3, Lanes> A, B;
  std::vector<Polynomial<6, 3>> a, b;
  for (int l = 0; l < 8; ++l) {
    a.push_back(random_polynomial<6, 3>(engine));
    b.push_back(random_polynomial<6, 3>(engine));
    for (int i = 0; i < A.size; ++i) {
      A[i][l] = a[l][i];
      B[i][l] = b[l][i];
    }
  }
  const auto C = A * B;
  auto scaled = Polynomial<6, 3, Lanes>::constant(Lanes::Zero());
  add_product(A.table(), scaled.c.data(), a[0].c.data(), B.c.data(), 3, 3);  // number × lanes
  for (int l = 0; l < 8; ++l) {
    const auto c = a[l] * b[l], s = a[0] * b[l];
    for (int i = 0; i < c.size; ++i) {
      CHECK(C[i][l] == Approx(c[i]).epsilon(1e-13).margin(1e-14));
      CHECK(scaled[i][l] == Approx(s[i]).epsilon(1e-13).margin(1e-14));
    }
  }
}

TEST_CASE("a series of a polynomial is its Taylor polynomial") {
  // sin(q)² + cos(q)² = 1 with a constant part in q, to every degree
  std::mt19937 engine(4);
  auto q = random_polynomial<6, 5>(engine);
  q[0] = 0.7;
  std::vector<double> sine(6), cosine(6);
  const double s = std::sin(0.7), c = std::cos(0.7);
  const double ds[] = {s, c, -s, -c}, dc[] = {c, -s, -c, s};
  double factorial = 1;
  for (int k = 0; k < 6; ++k) {
    if (k > 0) factorial *= k;
    sine[k] = ds[k % 4] / factorial;
    cosine[k] = dc[k % 4] / factorial;
  }
  const auto S = compose<6, 5, double>(std::span<const double>(sine), q);
  const auto C = compose<6, 5, double>(std::span<const double>(cosine), q);
  CHECK(S[3] == Approx(c * q[3]));
  const auto one = S * S + C * C;
  double scale = 0, rest = 0;
  for (int i = 1; i < one.size; ++i) {
    scale = std::max(scale, std::abs(S[i]));
    rest = std::max(rest, std::abs(one[i]));
  }
  REQUIRE(scale > 0.1);
  CHECK(one[0] == Approx(1).epsilon(1e-14));
  CHECK(rest < 1e-10 * scale);
}

TEST_CASE("a weighted square is the product with itself") {
  std::mt19937 engine(11);
  using P = Polynomial<4, 5>;
  for (const int degree : {1, 2, 3, 5}) {
    P a = random_polynomial<4, 5>(engine), expected = P::constant(0), square = P::constant(0);
    for (int k = P::table().count(degree); k < P::size; ++k) a[k] = 0;
    add_product(P::table(), expected.c.data(), a.c.data(), a.c.data(), degree, degree);
    add_square(P::table(), square.c.data(), a.c.data(), -0.7, degree);
    for (int k = 0; k < P::size; ++k) CHECK(square[k] == Approx(-0.7 * expected[k]).margin(1e-13));
  }
}
