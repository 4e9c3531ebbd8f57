#include "core/reduction/atlas/ray_interpolation.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <map>

#include "core/math/polynomial.hpp"

namespace flexopt {
namespace {

const MonomialTable& table() { return monomials<6, atlas_degree>(); }

std::array<int, 6> exponents(int m) {
  std::array<int, 6> e{};
  for (int v = 0; v < 6; ++v) e[v] = table().exponents(m)[v];
  return e;
}

// Indices of the neighbours that a turn of the ray mixes with a monomial; −1: none.
struct Neighbours {
  int sigma = 0, tau = 0;  ///< exponents of the monomial
  int more_sigma = -1;     ///< σ^(i+1) τ^a
  int more_tau = -1;       ///< σ^i τ^(a+1)
  int to_sigma = -1;       ///< σ^(i+1) τ^(a−1)
  int to_tau = -1;         ///< σ^(i−1) τ^(a+1)
};

// Polynomials in (σ, τ) and maybe more, and their neighbours.
struct Turning {
  const MonomialTable& table;
  std::vector<Neighbours> neighbours;

  explicit Turning(const MonomialTable& monomials) : table(monomials) {
    for (int m = 0; m < table.size(); ++m) {
      const auto exponents = table.exponents(m);
      const std::vector<int> e(exponents.begin(), exponents.end());
      Neighbours n{e[0], e[1]};
      const auto shifted = [&](int by_sigma, int by_tau) {
        if (e[0] + by_sigma < 0 || e[1] + by_tau < 0) return -1;
        std::vector<int> other = e;
        other[0] += by_sigma;
        other[1] += by_tau;
        return table.index(other);
      };
      n.more_sigma = shifted(1, 0);
      n.more_tau = shifted(0, 1);
      n.to_sigma = shifted(1, -1);
      n.to_tau = shifted(-1, 1);
      neighbours.push_back(n);
    }
  }
};
const Turning& of_potential() {
  static const Turning all(table());
  return all;
}
const Turning& of_bending() {
  static const Turning all(monomials<2, 3>());
  return all;
}

// Coefficients of one expansion, or of many in the columns of a matrix.
double coefficient(const std::vector<double>& W, int m) { return W[static_cast<std::size_t>(m)]; }
double& coefficient(std::vector<double>& W, int m) { return W[static_cast<std::size_t>(m)]; }
auto coefficient(const MatrixXd& W, int m) { return W.row(m); }
auto coefficient(MatrixXd& W, int m) { return W.row(m); }
int size_of(const std::vector<double>& W) { return static_cast<int>(W.size()); }
int size_of(const MatrixXd& W) { return static_cast<int>(W.rows()); }

// out += [(α σ − β τ) ∂/∂σ + (β σ + α τ) ∂/∂τ] W to a degree, σ the full value.
template <class Coefficients>
void add_turned(const Turning& by, const Coefficients& W, double sigma, double alpha, double beta,
                int degree, Coefficients& out) {
  for (int m = 0; m < by.table.count(degree); ++m) {
    const Neighbours& n = by.neighbours[static_cast<std::size_t>(m)];
    const auto add = [&](double factor, int k) {
      if (k >= 0 && k < size_of(W)) coefficient(out, m) += factor * coefficient(W, k);
    };
    add(alpha * (n.sigma + n.tau), m);
    add(alpha * sigma * (n.sigma + 1), n.more_sigma);
    add(beta * sigma * (n.tau + 1), n.more_tau);
    add(-beta * (n.sigma + 1), n.to_sigma);
    add(beta * (n.tau + 1), n.to_tau);
  }
}

// ∂W/∂ρ and ∂²W/∂ρ² of expansions to `degree`, added to `first`, `second`.
template <class Coefficients>
void add_ray_rates(const Turning& by, const Coefficients& W, double sigma, double rho, int degree,
                   Coefficients& first, Coefficients& second) {
  const double q = 1 / (1 + rho * rho);
  add_turned(by, W, sigma, q * rho, q, degree - 1, first);
  // the field itself turns, and so does what it acts on
  add_turned(by, W, sigma, q - 2 * rho * q * q * rho, -2 * rho * q * q, degree - 2, second);
  add_turned(by, first, sigma, q * rho, q, degree - 2, second);
}

// Weights of the value and of both derivatives at either end, for the coefficients of a degree of
// which so many derivatives are known.
struct HermiteInRho {
  std::array<double, 3> a, b;
};
HermiteInRho hermite_in_rho(int derivatives, double h, double t) {
  const double r = 1 - t;
  if (derivatives <= 0) return {{r, 0, 0}, {t, 0, 0}};
  if (derivatives == 1)
    return {{r * r * (1 + 2 * t), h * r * r * t, 0}, {t * t * (1 + 2 * r), -h * t * t * r, 0}};
  const double r3 = r * r * r, t3 = t * t * t;
  return {{r3 * (1 + 3 * t + 6 * t * t), h * r3 * t * (1 + 3 * t), 0.5 * h * h * r3 * t * t},
          {t3 * (1 + 3 * r + 6 * r * r), -h * t3 * r * (1 + 3 * r), 0.5 * h * h * t3 * r * r}};
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

RayNeighbours ray_neighbours(const std::vector<double>& rays, double rho) {
  // A leaf whose ray is this near to one of the atlas uses that ray: half the look-up, and the
  // model does not change with a design that turns its rays by next to nothing.
  constexpr double near_ray = 1e-3;
  RayNeighbours ray;
  while (ray.left + 2 < static_cast<int>(rays.size()) && rho >= rays[ray.left + 1]) ++ray.left;
  ray.a = rays[ray.left];
  ray.b = rays[ray.left + 1];
  ray.on_left = std::abs(rho - ray.a) < near_ray;
  ray.on_right = std::abs(rho - ray.b) < near_ray;
  ray.rho = ray.on_left ? ray.a : ray.on_right ? ray.b : rho;
  return ray;
}

RayRates ray_rates(const std::vector<double>& W, double sigma, double rho) {
  assert(static_cast<int>(W.size()) == table().size());
  RayRates rates{std::vector<double>(W.size(), 0.0), std::vector<double>(W.size(), 0.0)};
  add_ray_rates(of_potential(), W, sigma, rho, atlas_degree, rates.first, rates.second);
  return rates;
}

std::vector<double> between_rays(const std::vector<double>& W_a, double a,
                                 const std::vector<double>& W_b, double b, double sigma,
                                 double rho) {
  assert(a < b);
  if (rho == a) return W_a;
  if (rho == b) return W_b;
  const RayRates A = ray_rates(W_a, sigma, a), B = ray_rates(W_b, sigma, b);
  const double h = b - a, t = (rho - a) / h;
  std::vector<double> W(W_a.size());
  for (int degree = 0; degree <= atlas_degree; ++degree) {
    const HermiteInRho w = hermite_in_rho(atlas_degree - degree, h, t);
    for (int m = table().count(degree - 1); m < table().count(degree); ++m) {
      const auto k = static_cast<std::size_t>(m);
      W[k] = w.a[0] * W_a[k] + w.a[1] * A.first[k] + w.a[2] * A.second[k] + w.b[0] * W_b[k] +
             w.b[1] * B.first[k] + w.b[2] * B.second[k];
    }
  }
  return W;
}

RayBlend blend_between_rays(double a, double b, double sigma, double rho) {
  assert(a < b);
  const double h = b - a, t = (rho - a) / h;
  const MonomialTable& bending = of_bending().table;
  RayBlend blend;
  for (const bool left : {true, false})
    for (int degree = 0; degree <= bending.order(); ++degree) {
      const int size = bending.count(degree);
      MatrixXd first = MatrixXd::Zero(size, size), second = first,
               &out = (left ? blend.a : blend.b)[static_cast<std::size_t>(degree)];
      const MatrixXd W = MatrixXd::Identity(size, size);
      add_ray_rates(of_bending(), W, sigma, left ? a : b, degree, first, second);
      out.resize(size, size);
      for (int m = 0; m < size; ++m) {
        const HermiteInRho weights = hermite_in_rho(degree - bending.degree(m), h, t);
        const std::array<double, 3>& w = left ? weights.a : weights.b;
        out.row(m) = w[0] * W.row(m) + w[1] * first.row(m) + w[2] * second.row(m);
      }
    }
  return blend;
}

namespace {

// The columns of a table that a turn mixes: those with the same factors beside (σ, τ).
struct Mixed {
  int degree = 0;                     ///< of (σ, τ)
  std::vector<Eigen::Index> columns;  ///< by the monomials of (σ, τ)
};
template <std::size_t N>
std::vector<Mixed> mixed_columns(const std::array<StateMonomial, N>& monomials) {
  const MonomialTable& bending = of_bending().table;
  std::map<std::vector<int>, Mixed> all;  // by the other factors
  for (std::size_t k = 0; k < N; ++k) {
    const StateMonomial& m = monomials[k];
    std::array<int, 2> e{m.along, 0};
    std::vector<int> others;
    for (int f = 0; f < m.off_ray; ++f)
      if (m.variable[f] == 0)
        ++e[1];
      else
        others.push_back(m.variable[f]);
    Mixed& mixed = all[others];
    const auto at = static_cast<std::size_t>(bending.index(e));
    mixed.degree = std::max(mixed.degree, e[0] + e[1]);
    mixed.columns.resize(std::max(mixed.columns.size(), at + 1));
    mixed.columns[at] = static_cast<Eigen::Index>(k);
  }
  std::vector<Mixed> list;
  for (const auto& [others, mixed] : all) list.push_back(mixed);
  return list;
}

MatrixXd blended(const MatrixXd& A, const MatrixXd& B, const std::vector<Mixed>& all,
                 const RayBlend& blend) {
  MatrixXd sum = MatrixXd::Zero(A.rows(), A.cols());
  for (const Mixed& mixed : all) {
    const auto degree = static_cast<std::size_t>(mixed.degree);
    for (std::size_t i = 0; i < mixed.columns.size(); ++i)
      for (std::size_t j = 0; j < mixed.columns.size(); ++j) {
        const auto row = static_cast<Eigen::Index>(i), col = static_cast<Eigen::Index>(j);
        const double a = blend.a[degree](row, col), b = blend.b[degree](row, col);
        if (a != 0 || b != 0)
          sum.col(mixed.columns[i]) += a * A.col(mixed.columns[j]) + b * B.col(mixed.columns[j]);
      }
  }
  return sum;
}

}  // namespace

StateTable blended(const StateTable& a, const StateTable& b, const RayBlend& blend) {
  static const std::vector<Mixed> even = mixed_columns(even_monomials()),
                                  even_of_stress =
                                      mixed_columns(even_monomials<StateTable::even_of_stress>()),
                                  odd = mixed_columns(odd_monomials());
  const bool of_stress = a.even.cols() == StateTable::even_of_stress;
  return {a.sigma, blended(a.even, b.even, of_stress ? even_of_stress : even, blend),
          blended(a.odd, b.odd, odd, blend)};
}

std::vector<double> from_other_end(const std::vector<double>& W, bool same_sign) {
  return ends_swapped(W, [&](const std::array<int, 6>& e) { return same_sign ? odd(e[2]) : 1.0; });
}

std::vector<double> end_for_end(const std::vector<double>& W, double rho) {
  return ends_swapped(
      W, [&](const std::array<int, 6>& e) { return odd(e[1]) * (rho > 0 ? odd(e[2]) : 1.0); });
}

}  // namespace flexopt
