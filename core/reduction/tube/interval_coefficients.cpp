// Coefficients of a tube potential between two bent states.
#include <array>
#include <cassert>
#include <cstdint>

#include "core/math/polynomial.hpp"
#include "core/reduction/tube/potential_terms.hpp"

namespace flexopt::potential {
namespace {

/// Bernstein coefficients; those of the largest degree take 16 places.
using Bernstein = std::array<double, 16>;

/// Degree 2q − 1, of the Hermite polynomial of q Taylor coefficients at each end: tʲ = Σ_r
/// C(r,j)/C(n,j) B_r, and the coefficients r < q see the left end only. The others are zero.
Bernstein hermite_bernstein(int q, const double* left, const double* right, double h) {
  constexpr int most = 8;
  static constexpr auto share = [] {  // C(r,j)/C(n,j)
    std::array<std::array<std::array<double, most>, most>, most + 1> s{};
    for (int order = 1; order <= most; ++order)
      for (int j = 0; j < order; ++j)
        for (int r = j; r < order; ++r)
          s[order][j][r] = binomial(r, j) / binomial(2 * order - 1, j);
    return s;
  }();
  assert(q <= most);
  const int n = 2 * q - 1;
  Bernstein beta{};
  double scale = 1;
  for (int j = 0; j < q; ++j, scale *= h)
    for (int r = j; r < q; ++r) {
      const double c = share[q][j][r] * scale;
      beta[r] += c * left[j];
      beta[n - r] += (j % 2 ? -c : c) * right[j];
    }
  return beta;
}

/// Raises the degree of a Bernstein polynomial without changing the polynomial.
void elevate(Bernstein& beta, int from, int to) {
  for (int n = from; n < to; ++n) {
    for (int r = n + 1; r > 0; --r) {
      const double s = static_cast<double>(r) / (n + 1);
      beta[r] = s * beta[r - 1] + (1 - s) * beta[r];
    }
  }
}

/// Places of the Taylor coefficients of an interval among those of its nodes, in the order in which
/// they are read: of σ^j τ^a N^b y^e for all j.
struct TaylorPlaces {
  struct Run {
    int count;      ///< of j
    bool odd_even;  ///< whether a + e0 is odd: what the mirror forbids for even j at σ = 0
  };
  std::vector<Run> runs;
  std::vector<std::uint16_t> places;

  void add(const MonomialTable& table, int count, Power2 x, const int (&y)[3]) {
    runs.push_back({count, (x.tau + y[0]) % 2 != 0});
    for (int j = 0; j < count; ++j)
      places.push_back(static_cast<std::uint16_t>(
          table.index(std::array<int, 6>{j, x.tau, y[0], x.N, y[1], y[2]})));
  }
};

/// Calls bernstein(x, y) for all polynomials in σ of an interval, and puts their coefficients into
/// lanes.
template <int Degree, bool Odd, class Polynomial>
std::vector<Lanes> in_lanes(const Polynomial& bernstein) {
  std::vector<Lanes> all;
  constexpr auto X = x_monomials<Degree - 1>();
  constexpr int top = 2 * Degree + 1;
  for (int v = 0; v < x_vectors<Degree>(); ++v) {
    std::array<Lanes, top + 1> c{};
    for (int l = 0; l < lanes && v * lanes + l < static_cast<int>(X.size()); ++l) {
      const Power2 x = X[v * lanes + l];
      Bernstein beta = bernstein(x, {0, 0, 0});
      elevate(beta, 2 * (Degree + 1 - x.tau - x.N) - 1, top);
      for (int r = 0; r <= top; ++r) c[r].set(l, beta[r]);
    }
    all.insert(all.end(), c.begin(), c.end());
  }
  if constexpr (Odd)
    for (const Power2 x : x_monomials<Degree - 2>()) {
      const auto first = static_cast<std::ptrdiff_t>(all.size());
      const int terms = 2 * (Degree - x.tau - x.N);
      all.resize(all.size() + static_cast<std::size_t>(terms), Lanes{});
      for (int i = 0; i < 3; ++i) {
        int e[3] = {};
        e[i] = 1;
        const Bernstein beta = bernstein(x, e);
        for (int r = 0; r < terms; ++r) all[static_cast<std::size_t>(first + r)].set(i, beta[r]);
      }
    }
  unrolled<y_blocks(Degree, Odd)>([&](auto block) {
    constexpr int k = y_degree(block, Odd);
    for (const Power2 x : x_monomials<Degree - 1 - k>())
      for (const Power3& y : y_monomials<k - 2>()) {
        const auto first = static_cast<std::ptrdiff_t>(all.size());
        const int terms = 2 * (Degree + 1 - x.tau - x.N - k);
        all.resize(all.size() + static_cast<std::size_t>(terms), Lanes{});
        for (int p = 0; p < 6; ++p) {
          const int i = pair_i[p], j = pair_j[p];
          int e[3] = {y.e[0], y.e[1], y.e[2]};
          ++e[i];
          ++e[j];
          const double factor = e[i] * (e[j] - (i == j)) / static_cast<double>(k * (k - 1));
          const Bernstein beta = bernstein(x, e);
          for (int r = 0; r < terms; ++r)
            all[static_cast<std::size_t>(first + r)].set(p, factor * beta[r]);
        }
      }
  });
  return all;
}

template <int Degree, bool Odd>
std::vector<Lanes> between(const TubeNode& a, const TubeNode& b, bool mirrored) {
  static const TaylorPlaces plan = [] {
    TaylorPlaces places;
    (void)in_lanes<Degree, Odd>([&](Power2 x, const int(&y)[3]) {
      places.add(monomials<6, Degree>(), Degree + 1 - x.tau - x.N - y[0] - y[1] - y[2], x, y);
      return Bernstein{};
    });
    return places;
  }();
  const TaylorPlaces::Run* run = plan.runs.data();
  const std::uint16_t* place = plan.places.data();
  const double width = b.sigma - a.sigma;
  return in_lanes<Degree, Odd>([&](Power2, const int(&)[3]) {
    std::array<double, Degree + 1> left, right;
    const auto fill = [&](const TubeNode& node, std::array<double, Degree + 1>& of) {
      const bool flat = mirrored && node.sigma == 0;
      for (int j = 0; j < run->count; ++j)
        of[j] = flat && (j % 2 != 0) != run->odd_even ? 0 : node.W[place[j]];
    };
    fill(a, left);
    fill(b, right);
    const Bernstein beta = hermite_bernstein(run->count, left.data(), right.data(), width);
    place += run->count;
    ++run;
    return beta;
  });
}

}  // namespace

std::vector<Lanes> interval_coefficients(int degree, bool odd, const TubeNode& a, const TubeNode& b,
                                         bool mirrored) {
  return dispatch(degree, odd,
                  [&]<int Degree, bool Odd>() { return between<Degree, Odd>(a, b, mirrored); });
}

}  // namespace flexopt::potential
