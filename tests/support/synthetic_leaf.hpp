#pragma once
// A leaf whose mixed potential is a known analytic function: the oracle of the reduced leaf's
// tests. It is written once for any scalar, so that Taylor coefficients of every order are exact.
#include <cmath>
#include <random>

#include "core/math/polynomial.hpp"
#include "core/reduction/tube/mixed_condensation.hpp"

namespace flexopt::synthetic {

constexpr double length = 0.1;                       // [m]
constexpr double EI_over_L = 0.6;                    // [J]
inline const Vector3d force_scale(6.0, 0.18, 0.18);  // EI/L², w EI/L² [N, N m, N m]

inline double exp_of(double x) { return std::exp(x); }
template <int NV, int ORDER>
Polynomial<NV, ORDER> exp_of(const Polynomial<NV, ORDER>& x) {
  std::vector<double> taylor(ORDER + 1, std::exp(x[0]));
  for (int k = 1; k <= ORDER; ++k) taylor[k] = taylor[k - 1] / k;
  return compose<NV, ORDER, double>(std::span<const double>(taylor), x);
}

/// W*(θ1, θ2, φ, N, M1, M2): bending and twist energies of a beam that stiffen with the bend,
/// foreshortening −N u(θ), a transverse compliance that grows with the bend, and couplings; even
/// under (θ, φ) → −(θ, φ) and under (φ, M) → −(φ, M).
template <class S>
S potential(const S& th1, const S& th2, const S& phi, const S& N, const S& M1, const S& M2) {
  const S bend = th1 * th1 + th1 * th2 + th2 * th2;
  const S foreshortening =
      (1.0 / 15) * (th1 * th1) - (1.0 / 30) * (th1 * th2) + (1.0 / 15) * (th2 * th2);
  const S softening = exp_of(2.0 * bend);
  const S W = 2.0 * bend + 0.3 * (bend * bend * softening) + 0.4 * (phi * phi * softening) +
              N * foreshortening + 0.1 * (N * phi * phi) - 0.0008 * (N * N * exp_of(th1 * th2)) -
              0.003 * ((M1 * M1 + M2 * M2 - M1 * M2) * softening) - 1e-5 * (N * N * N * bend) +
              0.02 * (phi * (M1 * th1 - M2 * th2)) - 0.0002 * (N * M1 * M2) -
              0.0001 * (M1 * M1 * M1 * M1 + M1 * phi * M2 * phi);
  return EI_over_L * W;
}

/// Taylor polynomial of the potential in (σ, τ, φ, N, M1, M2) about (sigma, tau, phi, f).
template <int ORDER>
Polynomial<6, ORDER> taylor(const Eigen::Matrix2d& D, double sigma, double tau = 0, double phi = 0,
                            const Vector3d& f = Vector3d::Zero()) {
  using P = Polynomial<6, ORDER>;
  const P s = P::variable(0, sigma, 1), t = P::variable(1, tau, 1);
  return potential<P>(D(0, 0) * s + D(0, 1) * t, D(1, 0) * s + D(1, 1) * t, P::variable(2, phi, 1),
                      P::variable(3, f[0], 1), P::variable(4, f[1], 1), P::variable(5, f[2], 1));
}

template <int ORDER>
TubeNode node(const Eigen::Matrix2d& D, double sigma) {
  const auto p = taylor<ORDER>(D, sigma);
  return {sigma, {p.c.begin(), p.c.end()}};
}

/// Value, gradient and Hessian in (θ1, θ2, φ, N, M1, M2) from the exact function.
inline PotentialValue exact(const Vector3d& s, const Vector3d& f) {
  using P = Polynomial<6, 2>;
  const P p =
      potential<P>(P::variable(0, s[0], 1), P::variable(1, s[1], 1), P::variable(2, s[2], 1),
                   P::variable(3, f[0], 1), P::variable(4, f[1], 1), P::variable(5, f[2], 1));
  PotentialValue v;
  v.value = p[0];
  for (int i = 0; i < 6; ++i) {
    v.gradient[i] = p[1 + i];
    for (int j = 0; j < 6; ++j)
      v.hessian(i, j) = (i == j ? 2 : 1) * p[P::table().products(1 + i)[1 + j]];
  }
  return v;
}

/// Bending rays: both ends alike (S shape), opposite (C shape), and one in between.
inline Eigen::Matrix2d s_ray() { return (Eigen::Matrix2d() << 1, 1, 1, -1).finished(); }
inline Eigen::Matrix2d c_ray() { return (Eigen::Matrix2d() << 1, 1, -1, 1).finished(); }
inline Eigen::Matrix2d skew_ray() { return (Eigen::Matrix2d() << 1, 0.2, 0.4, -1).finished(); }

inline TubePotential tube(const Eigen::Matrix2d& D, std::vector<double> sigmas = {0, 0.1, 0.3}) {
  std::vector<TubeNode> nodes;
  for (double s : sigmas) nodes.push_back(node<5>(D, s));
  return TubePotential(D, force_scale, 5, nodes);
}

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double operator()(double limit = 1) {
    return std::uniform_real_distribution<double>(-limit, limit)(engine_);
  }
  template <int N>
  Eigen::Matrix<double, N, 1> vector(double limit = 1) {
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = (*this)(limit);
    return v;
  }

 private:
  std::mt19937 engine_;
};

/// Slope of log(error) over log(step) between two steps that differ tenfold.
inline double rate(double error_large, double error_small) {
  return std::log10(error_large / error_small);
}

}  // namespace flexopt::synthetic
