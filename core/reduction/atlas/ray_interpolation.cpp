#include "core/reduction/atlas/ray_interpolation.hpp"

#include <array>
#include <cassert>

#include "core/math/polynomial.hpp"

namespace flexopt {
namespace {

const MonomialTable& table() { return monomials<6, atlas_degree>(); }

std::array<int, 6> exponents(int m) {
  std::array<int, 6> e{};
  for (int v = 0; v < 6; ++v) e[v] = table().exponents(m)[v];
  return e;
}

// Where the neighbours of a monomial stand that a turn of the ray mixes with it; −1: nowhere.
struct Neighbours {
  int sigma = 0, tau = 0;  ///< its own exponents
  int more_sigma = -1;     ///< σ^(i+1) τ^a
  int more_tau = -1;       ///< σ^i τ^(a+1)
  int to_sigma = -1;       ///< σ^(i+1) τ^(a−1)
  int to_tau = -1;         ///< σ^(i−1) τ^(a+1)
};
const std::vector<Neighbours>& neighbours() {
  static const std::vector<Neighbours> all = [] {
    std::vector<Neighbours> list;
    for (int m = 0; m < table().size(); ++m) {
      std::array<int, 6> e = exponents(m);
      Neighbours n{e[0], e[1]};
      const auto shifted = [&](int by_sigma, int by_tau) {
        if (e[0] + by_sigma < 0 || e[1] + by_tau < 0) return -1;
        std::array<int, 6> other = e;
        other[0] += by_sigma;
        other[1] += by_tau;
        return table().index(other);
      };
      n.more_sigma = shifted(1, 0);
      n.more_tau = shifted(0, 1);
      n.to_sigma = shifted(1, -1);
      n.to_tau = shifted(-1, 1);
      list.push_back(n);
    }
    return list;
  }();
  return all;
}

// out += [(α σ − β τ) ∂/∂σ + (β σ + α τ) ∂/∂τ] W to a degree, σ the full value.
void add_turned(const std::vector<double>& W, double sigma, double alpha, double beta, int degree,
                std::vector<double>& out) {
  const std::vector<Neighbours>& near = neighbours();
  for (int m = 0; m < table().count(degree); ++m) {
    const Neighbours& n = near[static_cast<std::size_t>(m)];
    double sum = alpha * (n.sigma + n.tau) * W[static_cast<std::size_t>(m)];
    const auto at = [&](int k) { return k < 0 ? 0.0 : W[static_cast<std::size_t>(k)]; };
    sum += alpha * sigma * (n.sigma + 1) * at(n.more_sigma);
    sum += beta * sigma * (n.tau + 1) * at(n.more_tau);
    sum -= beta * (n.sigma + 1) * at(n.to_sigma);
    sum += beta * (n.tau + 1) * at(n.to_tau);
    out[static_cast<std::size_t>(m)] += sum;
  }
}

// M1 and M2 change places; each monomial takes the sign of its exponents.
template <class Sign>
std::vector<double> ends_swapped(const std::vector<double>& W, const Sign& sign) {
  std::vector<double> out(W.size());
  for (int m = 0; m < table().size(); ++m) {
    const std::array<int, 6> e = exponents(m);
    const int from = table().index(std::array<int, 6>{e[0], e[1], e[2], e[3], e[5], e[4]});
    out[static_cast<std::size_t>(m)] = sign(e) * W[static_cast<std::size_t>(from)];
  }
  return out;
}

double odd(int power) { return power % 2 == 0 ? 1.0 : -1.0; }

}  // namespace

Eigen::Matrix2d ray_directions(double rho) {
  Eigen::Matrix2d D;
  D << 1, -rho, rho, 1;
  return D;
}

RayRates ray_rates(const std::vector<double>& W, double sigma, double rho) {
  assert(static_cast<int>(W.size()) == table().size());
  const double q = 1 / (1 + rho * rho);
  RayRates rates{std::vector<double>(W.size(), 0.0), std::vector<double>(W.size(), 0.0)};
  add_turned(W, sigma, q * rho, q, atlas_degree - 1, rates.first);
  // the field itself turns, and so does what it acts on
  add_turned(W, sigma, q - 2 * rho * q * q * rho, -2 * rho * q * q, atlas_degree - 2, rates.second);
  add_turned(rates.first, sigma, q * rho, q, atlas_degree - 2, rates.second);
  return rates;
}

std::vector<double> between_rays(const std::vector<double>& W_a, double a,
                                 const std::vector<double>& W_b, double b, double sigma,
                                 double rho) {
  assert(a < b);
  if (rho == a) return W_a;
  if (rho == b) return W_b;
  const RayRates A = ray_rates(W_a, sigma, a), B = ray_rates(W_b, sigma, b);
  const double h = b - a, t = (rho - a) / h, r = 1 - t;
  std::vector<double> W(W_a.size());
  const auto fill = [&](int degree, double v, double v1, double v2, double w, double w1,
                        double w2) {
    for (int m = table().count(degree - 1); m < table().count(degree); ++m) {
      const auto k = static_cast<std::size_t>(m);
      W[k] = v * W_a[k] + h * v1 * A.first[k] + h * h * v2 * A.second[k] + w * W_b[k] +
             h * w1 * B.first[k] + h * h * w2 * B.second[k];
    }
  };
  for (int degree = 0; degree <= atlas_degree - 2; ++degree)
    fill(degree, r * r * r * (1 + 3 * t + 6 * t * t), r * r * r * t * (1 + 3 * t),
         0.5 * r * r * r * t * t, t * t * t * (1 + 3 * r + 6 * r * r), -t * t * t * r * (1 + 3 * r),
         0.5 * t * t * t * r * r);
  fill(atlas_degree - 1, r * r * (1 + 2 * t), r * r * t, 0, t * t * (1 + 2 * r), -t * t * r, 0);
  fill(atlas_degree, r, 0, 0, t, 0, 0);
  return W;
}

std::vector<double> from_other_end(const std::vector<double>& W, bool same_sign) {
  return ends_swapped(W, [&](const std::array<int, 6>& e) { return same_sign ? odd(e[2]) : 1.0; });
}

std::vector<double> end_for_end(const std::vector<double>& W, double rho) {
  return ends_swapped(
      W, [&](const std::array<int, 6>& e) { return odd(e[1]) * (rho > 0 ? odd(e[2]) : 1.0); });
}

}  // namespace flexopt
