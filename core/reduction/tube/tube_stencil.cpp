#include "core/reduction/tube/tube_stencil.hpp"

#include <cassert>

#include "core/math/polynomial.hpp"

namespace flexopt {
namespace {

constexpr int off_ray = 5;  // variables (τ, φ, N, M1, M2)
constexpr int highest = 7;  // degree of a potential
constexpr int third_order = 3;

// Derivatives of a function of (τ, φ, N, M1, M2) stand like monomials.
const MonomialTable& off_ray_table() { return monomials<off_ray, highest - 1>(); }

// A monomial off the ray, and what its derivatives are.
struct Term {
  int degree;
  bool odd;                ///< in (τ, φ): with an odd power of σ the mirror forbids it at σ = 0
  std::vector<int> place;  ///< of its coefficients in a node's, by the power of σ
  struct Derivative {
    int at;    ///< which
    int rest;  ///< the monomial that is left
    double factor;
    int order;
  };
  std::vector<Derivative> derivatives;  ///< by ascending order
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
    for (int d = 0; d < table.count(third_order); ++d) {
      const auto by = table.exponents(d);
      std::array<int, off_ray> rest{};
      double factor = 1;
      for (int v = 0; v < off_ray; ++v) {
        rest[v] = e[v] - by[v];
        for (int k = 0; k < by[v]; ++k) factor *= e[v] - k;
      }
      if (factor != 0) term.derivatives.push_back({d, table.index(rest), factor, table.degree(d)});
    }
    terms.push_back(std::move(term));
  }
  return terms;
}

// By ascending degree.
const std::vector<Term>& terms() {
  static const std::vector<Term> all = make_terms();
  return all;
}

// Values and derivatives in t of tʲ (1 − t)^q Σ_k C(q−1+k, k) tᵏ, k < q − j: the polynomials of
// degree 2q − 1 that have one Taylor coefficient j at t = 0 and none of the others at both ends.
void add_hermite(int q, double t, double width, bool right,
                 std::array<std::vector<double>, 4>& weights) {
  const double x = right ? 1 - t : t, y = 1 - x;
  // powers of y with their derivatives in x: y^q, −q y^(q−1), …
  std::array<double, 4> yq{};
  double c = 1;
  for (int o = 0; o < 4; ++o) {
    double power = 1;
    for (int k = 0; k < q - o; ++k) power *= y;
    yq[o] = q - o < 0 ? 0 : c * power;
    c *= -(q - o);
  }
  double scale = 1;
  for (int j = 0; j < q; ++j, scale *= width) {
    std::array<double, 4> p{};  // of the polynomial beside y^q
    double binomial = 1;
    for (int k = 0; k + j < q; ++k) {
      const int n = k + j;
      double factor = binomial;
      for (int o = 0; o < 4 && o <= n; ++o) {
        double power = 1;
        for (int i = 0; i < n - o; ++i) power *= x;
        p[o] += factor * power;
        factor *= n - o;
      }
      binomial *= static_cast<double>(q + k) / (k + 1);
    }
    const double sign = right && j % 2 != 0 ? -scale : scale, turn = right ? -1 : 1;
    weights[0].push_back(sign * p[0] * yq[0]);
    weights[1].push_back(sign * turn / width * (p[1] * yq[0] + p[0] * yq[1]));
    weights[2].push_back(sign / (width * width) * (p[2] * yq[0] + 2 * p[1] * yq[1] + p[0] * yq[2]));
    weights[3].push_back(sign * turn / (width * width * width) *
                         (p[3] * yq[0] + 3 * p[2] * yq[1] + 3 * p[1] * yq[2] + p[0] * yq[3]));
  }
}

}  // namespace

TubeStencil::TubeStencil(const TubePotential& potential, const Vector3d& s, const Vector3d& f)
    : degree_(potential.degree()), mirrored_(potential.mirrored()) {
  const TubeLocation where = potential.locate(s);
  const double mirror = mirrored_ && where.sigma < 0 ? -1 : 1;
  interval_ = static_cast<std::size_t>(where.interval);
  const double start = potential.nodes()[interval_].sigma,
               width = potential.nodes()[interval_ + 1].sigma - start,
               t = (mirror * where.sigma - start) / width;
  weights_.resize(static_cast<std::size_t>(degree_ + 2));
  for (int q = 2; q <= degree_ + 1; ++q)
    for (const bool right : {false, true})
      add_hermite(q, t, width, right, weights_[static_cast<std::size_t>(q)]);

  const Vector3d df = f - potential.force_centre();
  const std::array<double, off_ray> z{mirror * where.tau, mirror * s[2], df[0], df[1], df[2]};
  const MonomialTable& table = off_ray_table();
  const int count = table.count(degree_ - 1);
  powers_.assign(static_cast<std::size_t>(count), 1.0);
  for (int m = 0; m < count; ++m)
    for (int v = 0; v < off_ray; ++v)
      for (int k = 0; k < table.exponents(m)[v]; ++k) powers_[static_cast<std::size_t>(m)] *= z[v];
  to_ray_.topLeftCorner<2, 2>() = mirror * potential.ray().inverse();
  to_ray_(2, 2) = mirror;
}

// The derivative d of (τ, φ, …) and k in σ stands at orders · d + k.
void TubeStencil::sum(const std::vector<TubeNode>& nodes, int order,
                      std::vector<double>& sums) const {
  const TubeNode &left = nodes[interval_], &right = nodes[interval_ + 1];
  sums.assign(static_cast<std::size_t>(orders * off_ray_table().count(order)), 0.0);
  for (const Term& term : terms()) {
    if (term.degree > degree_ - 1) break;
    const int q = degree_ + 1 - term.degree;
    const auto& weights = weights_[static_cast<std::size_t>(q)];
    std::array<double, orders> c{};
    for (int j = 0; j < q; ++j) {
      const auto at = static_cast<std::size_t>(term.place[static_cast<std::size_t>(j)]);
      const bool forbidden = mirrored_ && left.sigma == 0 && (term.odd != (j % 2 != 0));
      const double a = forbidden ? 0 : left.W[at], b = right.W[at];
      for (int k = 0; k <= order; ++k)
        c[k] += weights[k][static_cast<std::size_t>(j)] * a +
                weights[k][static_cast<std::size_t>(q + j)] * b;
    }
    for (const Term::Derivative& d : term.derivatives) {
      if (d.order > order) break;
      const double by = d.factor * powers_[static_cast<std::size_t>(d.rest)];
      for (int k = 0; k + d.order <= order; ++k)
        sums[static_cast<std::size_t>(orders * d.at + k)] += by * c[k];
    }
  }
}

namespace {

// Where the derivative by these variables stands, the first of which is σ.
template <std::size_t n>
std::size_t place_of(const std::array<int, n>& by) {
  std::array<int, off_ray> e{};
  int along = 0;
  for (const int v : by) ++(v == 0 ? along : e[static_cast<std::size_t>(v - 1)]);
  return static_cast<std::size_t>(4 * off_ray_table().index(e) + along);
}

template <std::size_t n>
std::vector<std::size_t> all_places() {
  std::vector<std::size_t> places;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j)
      if constexpr (n == 2)
        places.push_back(place_of<2>({i, j}));
      else
        for (int k = 0; k < 6; ++k) places.push_back(place_of<3>({i, j, k}));
  return places;
}

}  // namespace

PotentialValue TubeStencil::value(const std::vector<TubeNode>& nodes) const {
  static const std::vector<std::size_t> second = all_places<2>();
  std::vector<double> sums;
  sum(nodes, 2, sums);
  PotentialValue p;
  p.value = sums[0];
  Vector6d gradient;
  Matrix6d hessian;
  for (int i = 0; i < 6; ++i) {
    gradient[i] = sums[place_of<1>({i})];
    for (int j = 0; j < 6; ++j) hessian(i, j) = sums[second[static_cast<std::size_t>(6 * i + j)]];
  }
  p.gradient = to_ray_.transpose() * gradient;
  p.hessian = to_ray_.transpose() * hessian * to_ray_;
  return p;
}

std::array<Matrix6d, 6> TubeStencil::third(const std::vector<TubeNode>& nodes) const {
  static const std::vector<std::size_t> places = all_places<3>();
  std::vector<double> sums;
  sum(nodes, third_order, sums);
  std::array<Matrix6d, 6> along, T;
  for (int k = 0; k < 6; ++k) {
    Matrix6d local;
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        local(i, j) = sums[places[static_cast<std::size_t>(36 * k + 6 * i + j)]];
    along[k].noalias() = to_ray_.transpose() * local * to_ray_;
  }
  for (int k = 0; k < 6; ++k) {
    T[k].setZero();
    for (int l = 0; l < 6; ++l)
      if (to_ray_(l, k) != 0) T[k] += to_ray_(l, k) * along[l];
  }
  return T;
}

}  // namespace flexopt
