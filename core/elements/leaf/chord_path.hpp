#pragma once
// The chord frame along increments of the edges: rates of the deformations e, of the edges'
// rotations in the frame and of the frame itself, to second order and for any scalar. Equation
// (G2) of core/reduction/README.md.
#include <array>

#include "core/elements/leaf/chord_frame.hpp"
#include "core/math/rotation.hpp"

namespace flexopt::chord {

// Rotation vectors of the edges in the chord frame: θ = T e.
inline Eigen::Matrix<double, 3, 6> edge_turn(int edge) {
  Eigen::Matrix<double, 3, 6> T = Eigen::Matrix<double, 3, 6>::Zero();
  T(0, twist) = edge == 0 ? -0.5 : 0.5;
  T(1, edge == 0 ? theta1y : theta2y) = T(2, edge == 0 ? theta1z : theta2z) = 1;
  return T;
}

template <class S>
struct SineFactor {
  S value, slope;
};
// Σ m! (−q)ᵏ/(2k + m)! as in jet.cpp, and its derivative in q.
template <class S>
SineFactor<S> sine_factor(const S& q, int m) {
  SineFactor<S> f{S(1.0), S(0.0)};
  for (int k = 16; k >= 1; --k) {
    const double c = 1.0 / ((2 * k + m - 1) * (2 * k + m));
    const S slope = -c * (f.value + q * f.slope), value = S(1.0) - c * q * f.value;
    f = {value, slope};
  }
  return f;
}

// A rotation exp(θ): its left tangent J, and J⁻¹.
template <class S>
struct Turn {
  Vector3<S> theta;
  Matrix3<S> J, inverse;
  SineFactor<S> a, b;

  explicit Turn(const Vector3<S>& t) : theta(t) {
    const S q = t.dot(t);
    const Matrix3<S> W = hat(t), WW = W * W;
    a = sine_factor(q, 2);
    b = sine_factor(q, 3);
    const S half = S(0.5) * a.value, sixth = S(1.0 / 6) * b.value;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const S one(i == j ? 1.0 : 0.0);
        J(i, j) = one + half * W(i, j) + sixth * WW(i, j);
      }
    const Vector3<S> c0 = J.col(1).cross(J.col(2)), c1 = J.col(2).cross(J.col(0)),
                     c2 = J.col(0).cross(J.col(1));
    const S det = J.col(0).dot(c0);
    for (int j = 0; j < 3; ++j) {
      inverse(0, j) = c0[j] / det;
      inverse(1, j) = c1[j] / det;
      inverse(2, j) = c2[j] / det;
    }
  }
  // (d/dε J(θ + ε t)) t
  Vector3<S> spin_rate(const Vector3<S>& t) const {
    const S dq = S(2.0) * theta.dot(t), da = S(0.5) * a.slope * dq, db = S(1.0 / 6) * b.slope * dq,
            sixth = S(1.0 / 6) * b.value;
    const Vector3<S> v = theta.cross(t), vv = theta.cross(v), tv = t.cross(v);
    Vector3<S> result;
    for (int i = 0; i < 3; ++i) result[i] = da * v[i] + db * vv[i] + sixth * tv[i];
    return result;
  }
};

// Derivatives of the chord frame and of e.
template <class S>
struct FrameRate {
  Vector3<S> spin;
  std::array<Vector3<S>, 2> theta;
  S stretch;

  Eigen::Matrix<S, 6, 1> e() const {
    Eigen::Matrix<S, 6, 1> rate;
    rate << stretch, theta[0][1], theta[0][2], theta[1][1], theta[1][2], theta[1][0] - theta[0][0];
    return rate;
  }
};
template <class S>
FrameRate<S> frame_rate(const std::array<Turn<S>, 2>& turn, const S& chord,
                        const std::array<Vector3<S>, 2>& spin, const Vector3<S>& apart) {
  FrameRate<S> r;
  r.stretch = apart[0];
  r.spin[1] = -apart[2] / chord;
  r.spin[2] = apart[1] / chord;
  // neither edge rolls more than the other
  S sum(0.0), weight(0.0);
  for (int a = 0; a < 2; ++a) {
    for (int c = 0; c < 3; ++c) sum += turn[a].inverse(0, c) * spin[a][c];
    for (int c = 1; c < 3; ++c) sum -= turn[a].inverse(0, c) * r.spin[c];
    weight += turn[a].inverse(0, 0);
  }
  r.spin[0] = sum / weight;
  for (int a = 0; a < 2; ++a) {
    const Vector3<S> relative = spin[a] - r.spin;
    r.theta[a] = turn[a].inverse * relative;
  }
  return r;
}

// First and second derivatives of the deformations, e′ and e″, along increments of the edges, and
// the spin of the frame.
template <class S>
struct FramePath {
  FrameRate<S> first, second;
};
template <class S>
FramePath<S> frame_path(const std::array<Turn<S>, 2>& turn, const S& chord,
                        const std::array<Vector3<S>, 2>& spin, const Vector3<S>& apart) {
  FramePath<S> p;
  p.first = frame_rate(turn, chord, spin, apart);
  const Vector3<S>& w = p.first.spin;
  std::array<Vector3<S>, 2> spin2;
  for (int a = 0; a < 2; ++a) spin2[a] = spin[a].cross(w) - turn[a].spin_rate(p.first.theta[a]);
  Vector3<S> apart2 = apart.cross(w);
  apart2[1] -= p.first.stretch * w[2];
  apart2[2] += p.first.stretch * w[1];
  p.second = frame_rate(turn, chord, spin2, apart2);
  return p;
}

}  // namespace flexopt::chord
