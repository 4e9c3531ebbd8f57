#include "core/reduction/tube/tube_potential.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <utility>
#include <vector>

#include "core/math/polynomial.hpp"
#include "core/reduction/expansion/point_lanes.hpp"
#include "core/reduction/tube/potential_terms.hpp"

// How a value with all derivatives stays cheap. Sort the terms by their degree k in
// y = (φ, M1, M2), k = 0, 2, 4, … or all. A homogeneous polynomial p of degree k ≥ 2 is
//
//     p = yᵀ S y,   ∂p/∂y = k S y,   ∂²p/∂y² = k (k − 1) S,   S(y) = ∂²p/∂y² / (k (k − 1)),
//
// so the six entries of S, of degree k − 2 in y, give everything; they fill one vector of lanes
// with polynomials in (σ, x). For k = 0 the lanes hold the monomials in x instead, for k = 1 the
// three entries of ∂p/∂y. The dependence on σ is in Bernstein form on each interval: two-point
// Hermite data turn into its coefficients by positive sums, and no digits are lost between the
// nodes.

namespace flexopt {

using namespace potential;

namespace {

// ---- Bernstein polynomials with two derivatives --------------------------------------------

/// Values and derivatives in σ of the Bernstein polynomials of degree 2q − 1 for q = 2 … Q. T here
/// and below: double, or a Dual, whose derivatives those of the result follow.
template <int Q, class T>
struct BernsteinBasis {
  static constexpr int top = 2 * Q - 1;
  T value[Q + 1][16], first[Q + 1][16], second[Q + 1][16];

  BernsteinBasis(const T& t, double width) {
    // b[m][r + 2] = C(m,r) tʳ (1−t)^(m−r), with zeros beside it
    constexpr auto C = [] {
      std::array<std::array<double, top + 1>, top + 1> c{};
      for (int m = 0; m <= top; ++m)
        for (int r = 0; r <= m; ++r) c[m][r] = binomial(m, r);
      return c;
    }();
    T tp[top + 1], sp[top + 1];  // tʳ and (1−t)^(top−r)
    tp[0] = sp[top] = 1;
    for (int r = 0; r < top; ++r) {
      tp[r + 1] = tp[r] * t;
      sp[top - r - 1] = sp[top - r] * (1 - t);
    }
    T b[top + 1][top + 5];
    unrolled<top + 1>([&](auto m_) {
      constexpr int m = m_;
      b[m][0] = b[m][1] = b[m][m + 3] = b[m][m + 4] = 0;
      for (int r = 0; r <= m; ++r) b[m][r + 2] = C[m][r] * tp[r] * sp[top - m + r];
    });
    const double ih = 1 / width, ih2 = ih * ih;
    unrolled<Q - 1>([&](auto i) {
      constexpr int q = i + 2, n = 2 * q - 1;
      for (int r = 0; r <= n; ++r) {
        value[q][r] = b[n][r + 2];
        first[q][r] = n * ih * (b[n - 1][r + 1] - b[n - 1][r + 2]);
        second[q][r] = n * (n - 1) * ih2 * (b[n - 2][r] - 2 * b[n - 2][r + 1] + b[n - 2][r + 2]);
      }
    });
  }

  struct Sums {
    LanesOf<T> value, first, second;
  };
  /// Sums of the polynomials of degree 2q − 1 times the coefficients at C, which moves on.
  template <int q>
  [[gnu::always_inline]] Sums sums(const Lanes*& C) const {
    Sums s = {};
    for (int r = 0; r < 2 * q; ++r) {
      const Lanes Cr = *C++;
      s.value += value[q][r] * Cr;
      s.first += first[q][r] * Cr;
      s.second += second[q][r] * Cr;
    }
    return s;
  }
};

/// p = (1, x, x², …).
template <int count, class T>
[[gnu::always_inline]] inline void set_powers(T (&p)[count], const T& x) {
  p[0] = 1;
  for (int i = 1; i < count; ++i) p[i] = p[i - 1] * x;
}

/// τᵃ Nᵇ of every monomial in x, and its derivatives by τ, N, ττ, τN, NN.
template <int Degree, class T>
struct XWeights {
  static constexpr auto X = x_monomials<Degree - 1>();
  static constexpr int vectors = x_vectors<Degree>();
  alignas(64) T w[6][vectors * lanes] = {};

  [[gnu::always_inline]] XWeights(const T& tau, const T& N) {
    T tp[Degree], np[Degree];
    set_powers(tp, tau);
    set_powers(np, N);
    unrolled<static_cast<int>(X.size())>([&](auto i) {
      constexpr int a = X[i].tau, b = X[i].N;
      w[0][i] = tp[a] * np[b];
      if constexpr (a >= 1) w[1][i] = a * tp[a - 1] * np[b];
      if constexpr (b >= 1) w[2][i] = b * tp[a] * np[b - 1];
      if constexpr (a >= 2) w[3][i] = a * (a - 1) * tp[a - 2] * np[b];
      if constexpr (a >= 1 && b >= 1) w[4][i] = a * b * tp[a - 1] * np[b - 1];
      if constexpr (b >= 2) w[5][i] = b * (b - 1) * tp[a] * np[b - 2];
    });
  }
  /// Derivative d of eight monomials.
  [[gnu::always_inline]] LanesOf<T> at(int d, int vector) const {
    if constexpr (std::is_same_v<T, double>)
      return Lanes::load(&w[d][vector * lanes]);
    else
      return lanes_from(&w[d][vector * lanes]);
  }
};

/// Derivatives of a function of (σ, τ, N) to second order: where each one stands.
enum Jet { v_, s_, t_, n_, ss_, st_, sn_, tt_, tn_, nn_, jets };

/// Adds c · w and its derivatives; c, c1, c2: value and σ-derivatives, G: degree of w at most,
/// w(d): the derivatives of w in the order of XWeights.
template <int G, class L, class Weight>
[[gnu::always_inline]] inline void add_jet(L (&J)[jets], const L& c, const L& c1, const L& c2,
                                           const Weight& w) {
  J[v_] += w(0) * c;
  J[s_] += w(0) * c1;
  J[ss_] += w(0) * c2;
  if constexpr (G >= 1) {
    J[t_] += w(1) * c;
    J[n_] += w(2) * c;
    J[st_] += w(1) * c1;
    J[sn_] += w(2) * c1;
  }
  if constexpr (G >= 2) {
    J[tt_] += w(3) * c;
    J[tn_] += w(4) * c;
    J[nn_] += w(5) * c;
  }
}

inline double sum(const Lanes& a) {
  return ((a[0] + a[4]) + (a[2] + a[6])) + ((a[1] + a[5]) + (a[3] + a[7]));
}
template <int n>
Dual<n> sum(const DualLanes8<n>& a) {
  Dual<n> all(sum(a.value));
  for (int k = 0; k < n; ++k) all.derivatives[k] = sum(a.derivatives[k]);
  return all;
}

/// S y for S given by its lanes.
template <class T>
[[gnu::always_inline]] inline Eigen::Matrix<T, 3, 1> times(const LanesOf<T>& S, const T (&y)[3]) {
  const auto s = [&](int k) { return PointLanes<T>::get(S, k); };
  return {s(0) * y[0] + s(1) * y[1] + s(2) * y[2], s(1) * y[0] + s(3) * y[1] + s(4) * y[2],
          s(2) * y[0] + s(4) * y[1] + s(5) * y[2]};
}

/// Value and derivatives from the sums over all terms: J without y, G of y, S of two y, Σ k S and
/// Σ k (k − 1) S.
template <bool Odd, class T, class L = LanesOf<T>>
[[gnu::always_inline]] inline PotentialOf<T> gathered(const L (&J)[jets], const L (&G)[jets],
                                                      const L (&S)[jets], const L (&kS)[4],
                                                      const L& all_kkS, const T (&y)[3]) {
  T squares[lanes] = {};
  for (int p = 0; p < 6; ++p)
    squares[p] = (pair_i[p] == pair_j[p] ? 1 : 2) * y[pair_i[p]] * y[pair_j[p]];
  const L yy = lanes_from(squares);
  T j[jets];
  for (int d = 0; d < jets; ++d) j[d] = sum(J[d] + S[d] * yy);
  using Vector = Eigen::Matrix<T, 3, 1>;
  Vector gy = times<T>(kS[v_], y), sy = times<T>(kS[s_], y), ty = times<T>(kS[t_], y),
         ny = times<T>(kS[n_], y);
  if constexpr (Odd) {
    const auto entries = [&](int d) {
      return Vector(PointLanes<T>::get(G[d], 0), PointLanes<T>::get(G[d], 1),
                    PointLanes<T>::get(G[d], 2));
    };
    const Vector at(y[0], y[1], y[2]);
    for (int d = 0; d < jets; ++d) j[d] += entries(d).dot(at);
    gy += entries(v_);
    sy += entries(s_);
    ty += entries(t_);
    ny += entries(n_);
  }
  const auto kkS = [&](int k) { return PointLanes<T>::get(all_kkS, k); };

  // order (σ, τ, φ, N, M1, M2)
  PotentialOf<T> p;
  p.value = j[v_];
  p.gradient << j[s_], j[t_], gy[0], j[n_], gy[1], gy[2];
  p.hessian << j[ss_], j[st_], sy[0], j[sn_], sy[1], sy[2],  //
      j[st_], j[tt_], ty[0], j[tn_], ty[1], ty[2],           //
      sy[0], ty[0], kkS(0), ny[0], kkS(1), kkS(2),           //
      j[sn_], j[tn_], ny[0], j[nn_], ny[1], ny[2],           //
      sy[1], ty[1], kkS(1), ny[1], kkS(3), kkS(4),           //
      sy[2], ty[2], kkS(2), ny[2], kkS(4), kkS(5);
  return p;
}

/// Value and derivatives in (σ, τ, φ, N, M1, M2) on the interval from `start` with the coefficients
/// C; z: (τ, φ, N, M1, M2).
template <int Degree, bool Odd, class T>
PotentialOf<T> evaluate_interval(const Lanes* C, double start, double width, const T& sigma,
                                 const std::array<T, 5>& z) {
  using L = LanesOf<T>;
  const T y[3] = {z[1], z[3], z[4]};
  const BernsteinBasis<Degree + 1, T> basis((sigma - start) / width, width);
  const XWeights<Degree, T> weights(z[0], z[2]);
  const auto weight = [&](int i) { return [&w = weights.w, i](int d) { return w[d][i]; }; };

  L J[jets] = {};  // k = 0: lanes are the monomials of x
  for (int v = 0; v < weights.vectors; ++v) {
    const auto [c, c1, c2] = basis.template sums<Degree + 1>(C);
    add_jet<2>(J, c, c1, c2, [&](int d) { return weights.at(d, v); });
  }

  // k = 1: lanes are the entries of ∂p/∂y
  L G[jets] = {};
  if constexpr (Odd)
    unrolled<Degree - 1>([&](auto g) {
      constexpr int q = Degree - g;
      for (int i = g * (g + 1) / 2; i < (g + 1) * (g + 2) / 2; ++i) {
        const auto [c, c1, c2] = basis.template sums<q>(C);
        add_jet<g>(G, c, c1, c2, weight(i));
      }
    });

  // k ≥ 2: lanes are the entries of S
  L S[jets] = {}, kS[4] = {}, kkS = {};  // Σ S; Σ k S of v, s, t, n; Σ k (k − 1) S of v
  T yp[3][Degree];
  for (int i = 0; i < 3; ++i) set_powers(yp[i], y[i]);
  unrolled<y_blocks(Degree, Odd)>([&](auto block) {
    constexpr int k = y_degree(block, Odd);
    constexpr auto Y = y_monomials<k - 2>();
    L Sk[jets] = {};
    unrolled<Degree - k>([&](auto g) {
      constexpr int q = Degree + 1 - k - g;
      for (int i = g * (g + 1) / 2; i < (g + 1) * (g + 2) / 2; ++i) {
        L c = {}, c1 = {}, c2 = {};
        for (const Power3& m : Y) {
          const auto [b, b1, b2] = basis.template sums<q>(C);
          if constexpr (k == 2) {
            c = b;
            c1 = b1;
            c2 = b2;
          } else {
            const T ym = yp[0][m.e[0]] * yp[1][m.e[1]] * yp[2][m.e[2]];
            c += ym * b;
            c1 += ym * b1;
            c2 += ym * b2;
          }
        }
        add_jet<g>(Sk, c, c1, c2, weight(i));
      }
    });
    for (int d = 0; d < jets; ++d) S[d] += Sk[d];
    for (int d = 0; d < 4; ++d) kS[d] += static_cast<double>(k) * Sk[d];
    kkS += static_cast<double>(k * (k - 1)) * Sk[v_];
  });
  return gathered<Odd, T>(J, G, S, kS, kkS, y);
}

}  // namespace

TubePotential::TubePotential(const Eigen::Matrix2d& ray, const Vector3d& force_scale, int degree,
                             std::vector<TubeNode> nodes, const Vector3d& force_centre,
                             bool mirrored)
    : ray_(ray),
      ray_inverse_(ray.inverse()),
      force_scale_(force_scale),
      force_centre_(force_centre),
      degree_(degree),
      mirrored_(mirrored),
      odd_(force_centre[1] != 0 || force_centre[2] != 0),
      nodes_(std::move(nodes)) {
  assert(degree >= (odd_ ? 4 : 3) && degree <= 7);
  assert(std::abs(ray.determinant()) > 0 && (force_scale.array() > 0).all());
  assert(nodes_.size() >= 2 && (!mirrored || nodes_.front().sigma >= 0));
  for (std::size_t i = 0; i < nodes_.size(); ++i) {
    assert(static_cast<int>(nodes_[i].W.size()) >= monomial_count(6, degree));
    assert(i == 0 || nodes_[i - 1].sigma < nodes_[i].sigma);
  }
  make_intervals();
}

void TubePotential::make_intervals() {
  intervals_.clear();
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
    const TubeNode &a = nodes_[i], &b = nodes_[i + 1];
    intervals_.push_back({a.sigma, b.sigma - a.sigma,
                          potential::interval_coefficients(degree_, odd_, a, b, mirrored_)});
  }
}

void TubePotential::add_node(TubeNode node) {
  assert(static_cast<int>(node.W.size()) >= monomial_count(6, degree_));
  const auto place = std::ranges::lower_bound(nodes_, node.sigma, {}, &TubeNode::sigma);
  assert((!mirrored_ || node.sigma >= 0) && (place == nodes_.end() || place->sigma != node.sigma));
  nodes_.insert(place, std::move(node));
  make_intervals();
}

TubeLocation TubePotential::locate(const Vector3d& s) const {
  const Eigen::Vector2d on_ray = ray_inverse_ * s.head<2>();
  const double sigma = mirrored_ ? std::abs(on_ray[0]) : on_ray[0];
  const double beyond = std::max(sigma - nodes_.back().sigma, nodes_.front().sigma - sigma);
  TubeLocation where{on_ray[0], on_ray[1], beyond, 0};
  const int last = static_cast<int>(intervals_.size()) - 1;
  while (where.interval < last && sigma > nodes_[where.interval + 1].sigma) ++where.interval;
  return where;
}

TubePotential::Local TubePotential::local(const Vector3d& s, const Vector3d& f) const {
  const TubeLocation where = locate(s);
  const double mirror = mirrored_ && where.sigma < 0 ? -1 : 1;
  const Vector3d df = f - force_centre_;
  return {&intervals_[where.interval],
          mirror,
          mirror * where.sigma,
          {mirror * where.tau, mirror * s[2], df[0], df[1], df[2]}};
}

PotentialValue TubePotential::evaluate(const Vector3d& s, const Vector3d& f) const {
  const auto [interval, mirror, sigma, z] = local(s, f);
  PotentialValue p =
      dispatch(degree_, odd_, [&, &on = *interval, at = sigma, &off = z]<int Degree, bool Odd>() {
        return evaluate_interval<Degree, Odd>(on.coefficients.data(), on.start, on.width, at, off);
      });

  // (σ, τ, φ) = A (θ1y, θ2y, φx) up to the mirror
  const Eigen::Matrix2d A = mirror * ray_inverse_;
  p.gradient.head<2>() = A.transpose() * p.gradient.head<2>().eval();
  p.gradient[2] *= mirror;
  auto& H = p.hessian;
  H.topLeftCorner<2, 2>() = A.transpose() * H.topLeftCorner<2, 2>().eval() * A;
  H(1, 0) = H(0, 1);
  H.topRightCorner<2, 4>() = A.transpose() * H.topRightCorner<2, 4>().eval();
  H.block<2, 1>(0, 2) *= mirror;
  H.block<1, 3>(2, 3) *= mirror;
  H.bottomLeftCorner<4, 2>() = H.topRightCorner<2, 4>().transpose();
  H.block<3, 1>(3, 2) = H.block<1, 3>(2, 3).transpose();
  return p;
}

std::array<Matrix6d, 6> TubePotential::third(const Vector3d& s, const Vector3d& f) const {
  assert(degree_ == 5 && !odd_);
  const Local at = local(s, f);
  using Number = Dual<6>;
  std::array<Number, 5> z;
  for (int v = 0; v < 5; ++v) z[v] = Number::variable(at.z[v], 1 + v);
  const auto p = evaluate_interval<5, false>(at.interval->coefficients.data(), at.interval->start,
                                             at.interval->width, Number::variable(at.sigma, 0), z);
  Matrix6d J = Matrix6d::Identity();  // (σ, τ, φ) of (θ1y, θ2y, φx) up to the mirror
  J.topLeftCorner<2, 2>() = at.mirror * ray_inverse_;
  J(2, 2) = at.mirror;
  std::array<Matrix6d, 6> third;
  for (Matrix6d& along : third) along.setZero();
  for (int l = 0; l < 6; ++l) {
    const Matrix6d rate = p.hessian.unaryExpr([&](const Number& x) { return x.derivatives[l]; });
    const Matrix6d along = J.transpose() * rate * J;
    for (int k = 0; k < 6; ++k)
      if (J(l, k) != 0) third[k] += J(l, k) * along;
  }
  return third;
}

TubeRates::TubeRates(const TubePotential& potential, const TubeNodeRates& rates)
    : potential_(&potential) {
  for (const std::vector<TubeNode>& nodes : rates) {
    assert(nodes.size() == potential.nodes().size());
    by_shape_.emplace_back(potential.ray(), potential.force_scale(), potential.degree(), nodes,
                           potential.force_centre(), potential.mirrored());
  }
}

auto TubeRates::evaluate(const Vector3d& s, const Vector3d& f) const -> Answer {
  const PotentialValue none{0, Vector6d::Zero(), Matrix6d::Zero()};
  Answer answer{potential_->evaluate(s, f), potential_->third(s, f), {none, none, none}};
  for (std::size_t p = 0; p < by_shape_.size(); ++p)
    answer.by_shape[p] = by_shape_[p].evaluate(s, f);
  return answer;
}

}  // namespace flexopt
