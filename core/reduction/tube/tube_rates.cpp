#include "core/reduction/tube/tube_rates.hpp"

#include <Eigen/LU>

#include <cassert>

#include "core/math/polynomial.hpp"

namespace flexopt {
namespace {

using Four = TubeRates::Four;
constexpr int off_ray = 5;       // variables (τ, φ, N, M1, M2)
constexpr int highest = 7;       // degree of a potential
constexpr int orders = 4;        // value and three derivatives
constexpr int derivatives = 56;  // of that order at most, in five variables

// Derivatives of a function of (τ, φ, N, M1, M2) stand like monomials.
const MonomialTable& off_ray_table() { return monomials<off_ray, highest - 1>(); }

// A monomial off the ray, and what its derivatives are.
struct Term {
  int degree;
  bool odd;  ///< in (τ, φ): at σ = 0 the mirror forbids even powers of σ, else odd ones
  std::vector<int> place;  ///< of its coefficients among a node's, by the power of σ
  struct Derivative {
    int at;    ///< which
    int rest;  ///< the monomial that is left
    int order;
    double factor;
  };
  std::vector<Derivative> derivatives;
};

std::vector<Term> make_terms() {
  const MonomialTable &table = off_ray_table(), &all = monomials<6, highest>();
  std::vector<Term> terms;
  for (int m = 0; m < table.size(); ++m) {
    const auto e = table.exponents(m);
    if ((e[1] + e[3] + e[4]) % 2 != 0) continue;  // the mirror across the width
    Term term{table.degree(m), (e[0] + e[1]) % 2 != 0, {}, {}};
    for (int j = 0; j + term.degree <= highest; ++j)
      term.place.push_back(all.index(std::array<int, 6>{j, e[0], e[1], e[2], e[3], e[4]}));
    for (int d = 0; d < derivatives; ++d) {
      const auto by = table.exponents(d);
      std::array<int, off_ray> rest{};
      double factor = 1;
      for (int v = 0; v < off_ray; ++v) {
        rest[v] = e[v] - by[v];
        for (int k = 0; k < by[v]; ++k) factor *= e[v] - k;
      }
      if (factor != 0) term.derivatives.push_back({d, table.index(rest), table.degree(d), factor});
    }
    terms.push_back(std::move(term));
  }
  return terms;
}

// Terms by ascending degree.
const std::vector<Term>& terms() {
  static const std::vector<Term> all = make_terms();
  return all;
}

// Weights of two-point Hermite interpolation with q Taylor coefficients at each end: for
// coefficient j of the left end, and of the right end (+ q), for the value and three derivatives.
struct EndWeights {
  std::array<std::array<double, 2 * (highest + 1)>, orders> of{};

  // tʲ (1 − t)^q Σ_k C(q−1+k, k) tᵏ, k < q − j, times widthʲ; the right end mirrors it
  EndWeights() = default;
  EndWeights(int q, double t, double width) {
    const double per[orders] = {1, 1 / width, 1 / (width * width), 1 / (width * width * width)};
    for (const bool right : {false, true}) {
      const double x = right ? 1 - t : t, y = 1 - x, turn = right ? -1 : 1;
      double power[2 * highest + 2] = {1}, yq[orders] = {};
      for (int k = 1; k < 2 * q; ++k) power[k] = power[k - 1] * x;
      double c = 1;
      for (int o = 0; o < orders && o <= q; ++o) {
        yq[o] = c;
        for (int k = 0; k < q - o; ++k) yq[o] *= y;
        c *= -(q - o);
      }
      double scale = 1;
      for (int j = 0; j < q; ++j, scale *= turn * width) {
        double p[orders] = {}, binomial = 1;  // of the sum with tʲ
        for (int k = 0; k + j < q; ++k) {
          double factor = binomial;
          for (int o = 0; o < orders && o <= k + j; ++o) {
            p[o] += factor * power[k + j - o];
            factor *= k + j - o;
          }
          binomial *= static_cast<double>(q + k) / (k + 1);
        }
        const std::size_t at = static_cast<std::size_t>(right ? q + j : j);
        of[0][at] = scale * p[0] * yq[0];
        of[1][at] = scale * turn * per[1] * (p[1] * yq[0] + p[0] * yq[1]);
        of[2][at] = scale * per[2] * (p[2] * yq[0] + 2 * p[1] * yq[1] + p[0] * yq[2]);
        of[3][at] = scale * turn * per[3] *
                    (p[3] * yq[0] + 3 * p[2] * yq[1] + 3 * p[1] * yq[2] + p[0] * yq[3]);
      }
    }
  }
};

// Derivatives in (σ, τ, φ, N, M1, M2): d of those off the ray and k in σ at orders · d + k.
using Sums = std::array<Four, orders * derivatives>;

// `coefficient`: those of an interval of this width, at its share t; z: (τ, φ, N, M1, M2).
Sums sum_terms(const Four* coefficient, int degree, double t, double width,
               const std::array<double, off_ray>& z) {
  std::array<EndWeights, highest + 2> weights;
  for (int q = 2; q <= degree + 1; ++q) weights[static_cast<std::size_t>(q)] = {q, t, width};
  const MonomialTable& table = off_ray_table();
  std::array<double, monomial_count(off_ray, highest - 1)> powers{};
  powers[0] = 1;
  for (int m = 0; m < table.count(degree - 2); ++m) {  // each from one of lower degree
    const std::uint16_t* products = table.products(m);
    for (int v = 0; v < off_ray; ++v)
      powers[products[1 + v]] =
          powers[static_cast<std::size_t>(m)] * z[static_cast<std::size_t>(v)];
  }

  Sums sums{};
  for (const Term& term : terms()) {
    if (term.degree > degree - 1) break;
    const int q = degree + 1 - term.degree;
    const EndWeights& weight = weights[static_cast<std::size_t>(q)];
    std::array<Four, orders> c{};
    for (int j = 0; j < 2 * q; ++j) {
      const Four a = *coefficient++;
      for (int k = 0; k < orders; ++k) c[k] += weight.of[k][static_cast<std::size_t>(j)] * a;
    }
    for (const Term::Derivative& d : term.derivatives) {
      const double by = d.factor * powers[static_cast<std::size_t>(d.rest)];
      for (int k = 0; k + d.order < orders; ++k)
        sums[static_cast<std::size_t>(orders * d.at + k)] += by * c[k];
    }
  }
  return sums;
}

// Index of the derivative by these variables, the first of which is σ.
template <std::size_t n>
int place_of(const std::array<int, n>& by) {
  std::array<int, off_ray> e{};
  int along = 0;
  for (const int v : by) ++(v == 0 ? along : e[static_cast<std::size_t>(v - 1)]);
  return orders * off_ray_table().index(e) + along;
}

struct Places {
  std::array<int, 6> first;
  std::array<std::array<int, 6>, 6> second;
  std::array<std::array<std::array<int, 6>, 6>, 6> third;
  Places() {
    for (int i = 0; i < 6; ++i) {
      first[i] = place_of<1>({i});
      for (int j = 0; j < 6; ++j) {
        second[i][j] = place_of<2>({i, j});
        for (int k = 0; k < 6; ++k) third[i][j][k] = place_of<3>({i, j, k});
      }
    }
  }
};

}  // namespace

TubeRates::TubeRates(const TubePotential& potential, const TubeNodeRates& rates)
    : potential_(&potential) {
  const std::vector<TubeNode>& nodes = potential.nodes();
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    std::vector<Four>& all = intervals_.emplace_back();
    for (const Term& term : terms()) {
      if (term.degree > potential.degree() - 1) break;
      for (const std::size_t end : {i, i + 1})
        for (int j = 0; j + term.degree <= potential.degree(); ++j) {
          const auto at = static_cast<std::size_t>(term.place[static_cast<std::size_t>(j)]);
          const auto rate = [&](std::size_t p) {
            return p < rates.size() ? rates[p][end].W[at] : 0.0;
          };
          const bool forbidden =
              potential.mirrored() && nodes[end].sigma == 0 && term.odd != (j % 2 != 0);
          all.push_back(forbidden ? Four{} : Four{nodes[end].W[at], rate(0), rate(1), rate(2)});
        }
    }
  }
}

auto TubeRates::evaluate(const Vector3d& s, const Vector3d& f) const -> Answer {
  static const Places places;
  const TubeLocation where = potential_->locate(s);
  const double mirror = potential_->mirrored() && where.sigma < 0 ? -1 : 1;
  const auto interval = static_cast<std::size_t>(where.interval);
  const double start = potential_->nodes()[interval].sigma,
               width = potential_->nodes()[interval + 1].sigma - start,
               t = (mirror * where.sigma - start) / width;
  const Vector3d df = f - potential_->force_centre();
  const std::array<double, off_ray> z{mirror * where.tau, mirror * s[2], df[0], df[1], df[2]};
  const Sums sums = sum_terms(intervals_[interval].data(), potential_->degree(), t, width, z);

  // (σ, τ, φ) of (θ1y, θ2y, φx) up to the mirror
  Matrix6d J = Matrix6d::Identity();
  J.topLeftCorner<2, 2>() = mirror * potential_->ray().inverse();
  J(2, 2) = mirror;
  const auto value = [&](int lane) {
    PotentialValue p;
    Vector6d g;
    Matrix6d H;
    for (int i = 0; i < 6; ++i) {
      g[i] = sums[static_cast<std::size_t>(places.first[i])][lane];
      for (int j = 0; j < 6; ++j)
        H(i, j) = sums[static_cast<std::size_t>(places.second[i][j])][lane];
    }
    p.value = sums[0][lane];
    p.gradient = J.transpose() * g;
    p.hessian = J.transpose() * H * J;
    return p;
  };
  Answer answer{value(0), {}, {value(1), value(2), value(3)}};
  for (Matrix6d& T : answer.third) T.setZero();
  for (int l = 0; l < 6; ++l) {
    Matrix6d along;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        along(i, j) = sums[static_cast<std::size_t>(places.third[l][i][j])][0];
    along = (J.transpose() * along * J).eval();
    for (int k = 0; k < 6; ++k)
      if (J(l, k) != 0) answer.third[static_cast<std::size_t>(k)] += J(l, k) * along;
  }
  return answer;
}

}  // namespace flexopt
