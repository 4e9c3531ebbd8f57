#pragma once
// A frame that takes up the rigid motion of a body between rigid interfaces, found anew at every
// state, and what an energy of the deformations in it does in absolute coordinates. For numbers of
// any kind. Equations (U4)–(U6) of core/elements/solid/README.md.
#include <cmath>
#include <concepts>
#include <span>
#include <vector>

#include "core/math/rate.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {

/// Place of an interface: its origin [m] and the own axes of the body as the interface carries
/// them; or of the floating frame.
template <class S>
struct FramePoseOf {
  Vector3<S> position = Vector3<S>::Zero();
  Matrix3<S> axes = Matrix3<S>::Identity();
};
using FramePose = FramePoseOf<double>;

/// Coordinates are d = (u_1, θ_1, …): displacement [m] and rotation vector [rad] of each interface,
/// frame axes. Nothing is allocated once as many interfaces have been there.
template <class S>
class FloatingFrame {
 public:
  using Vector6 = Eigen::Matrix<S, 6, 1>;

  struct Interface {
    Vector3<S> origin;  ///< X, undeformed [m]
    Matrix6d weights;   ///< Z_a of Z = (Z_1 … Z_N), which maps a rigid motion of all to itself

    // what find() sets
    Vector3<S> place, turn;  ///< x = X + u, θ
    HatSquareFactorOf<S> gamma;
    Matrix3<S> to_rate;  ///< J: dθ = J spin
    Matrix6<S> share;    ///< Z~_a: motion of the frame by that of the interface, frame axes
    // what balance() sets, frame axes
    Vector3<S> force, moment;        ///< f̄: what holds the body
    Vector3<S> rotation_force;       ///< what does work on θ: rows of h − Zᵀ μ
    Eigen::Matrix<S, 6, 3> turning;  ///< C_a of (U6)
    Matrix6<S> beside;               ///< U_a of (U6)

    Matrix6<S> rigid() const {  ///< G_a: motion of the interface by that of the frame
      Matrix6<S> G = Matrix6<S>::Identity();
      G.template topRightCorner<3, 3>() = -hat(place);
      return G;
    }
    /// A_aᵀ, of d at the interface by its motion: rows of rotations times Jᵀ.
    template <class Rows>
    void to_motion(Rows&& rows) const {
      rows.template bottomRows<3>() = (to_rate.transpose() * rows.template bottomRows<3>()).eval();
    }
  };

  std::vector<Interface> interfaces;
  FramePoseOf<S> pose;
  Matrix3<S> curvature;  ///< E of (U6), set by balance()

  /// Finds the pose with Z d = 0 by Newton's method from the axes `start`; its place is given by
  /// them. False where there is none.
  bool find(std::span<const FramePoseOf<S>> seen, const Matrix3<S>& start);
  void local(Eigen::VectorX<S>& d) const;

  /// Forces h by d → forces on the interfaces. `held`: derivative of the energy by motions of the
  /// frame at constant d.
  void balance(const Eigen::VectorX<S>& h, const Vector6& held);
  /// Second derivative by d → by motions of the interfaces, global axes, R varied as exp(hat δ) R
  /// to second order; for the forces of balance(). Symmetric.
  void bend(Eigen::MatrixX<S>& K);

 private:
  void place(std::span<const FramePoseOf<S>> seen);

  Matrix6<S> inverse_;  ///< of S = Z A G
  Vector6 rest_;        ///< Z d
};

template <class S>
void FloatingFrame<S>::place(std::span<const FramePoseOf<S>> seen) {
  const Matrix3<S> Ft = pose.axes.transpose();
  Eigen::Matrix<S, 6, 3> turned = Eigen::Matrix<S, 6, 3>::Zero();
  rest_.setZero();
  for (std::size_t a = 0; a < interfaces.size(); ++a) {
    Interface& i = interfaces[a];
    i.place = Ft * (seen[a].position - pose.position);
    i.turn = rotation_log(Matrix3<S>(Ft * seen[a].axes));
    i.gamma = hat_square_factor(S(i.turn.dot(i.turn)));
    const Matrix3<S> K = hat(i.turn);
    i.to_rate = Matrix3<S>::Identity() - 0.5 * K + K * K * i.gamma.value;
    const auto of_places = i.weights.template leftCols<3>(),
               of_turns = i.weights.template rightCols<3>();
    rest_ += of_places * (i.place - i.origin) + of_turns * i.turn;
    turned += of_turns * i.to_rate - of_places * hat(i.place);
  }
  // a translation of all interfaces is one of the frame: S = [1, turned]
  const Matrix3<S> back = turned.template bottomRows<3>().inverse();
  inverse_.setIdentity();
  inverse_.template bottomRightCorner<3, 3>() = back;
  inverse_.template topRightCorner<3, 3>() = -turned.template topRows<3>() * back;
}

template <class S>
bool FloatingFrame<S>::find(std::span<const FramePoseOf<S>> seen, const Matrix3<S>& start) {
  constexpr int steps = 30;                     // 3 to 6 happen
  int after = std::same_as<S, double> ? 0 : 1;  // of rates, once the numbers have settled
  pose.axes = start;
  pose.position = seen[0].position - start * interfaces[0].origin;
  for (int step = 0; step < steps; ++step) {
    place(seen);
    const Vector6 s = inverse_ * rest_;
    double size = 0, turn = 0;
    for (int k = 0; k < 6; ++k) (k < 3 ? size : turn) += std::abs(plain(s[k]));
    if (!std::isfinite(size + turn)) return false;
    pose.position += pose.axes * s.template head<3>();
    // Cayley's rotation: that of the vector s to second order, by arithmetic alone
    const Vector3<S> r = s.template tail<3>();
    const Matrix3<S> W = hat(r);
    const S by = 1.0 / (1.0 + 0.25 * r.dot(r));
    pose.axes += (pose.axes * Matrix3<S>((W + 0.5 * W * W) * by)).eval();
    if (turn < 1e-9 && after-- == 0) {  // the next step is its square; the place follows exactly
      place(seen);
      for (Interface& i : interfaces) {
        i.share = inverse_ * i.weights;
        i.share.template rightCols<3>() *= i.to_rate;
      }
      return true;
    }
  }
  return false;
}

template <class S>
void FloatingFrame<S>::local(Eigen::VectorX<S>& d) const {
  d.resize(6 * static_cast<Eigen::Index>(interfaces.size()));
  Eigen::Index k = 0;
  for (const Interface& i : interfaces) {
    d.template segment<3>(k) = i.place - i.origin;
    d.template segment<3>(k + 3) = i.turn;
    k += 6;
  }
}

template <class S>
void FloatingFrame<S>::balance(const Eigen::VectorX<S>& h, const Vector6& held) {
  Vector6 left = -held;  // Gᵀ Aᵀ h less what acts on the frame itself
  Eigen::Index k = 0;
  for (const Interface& i : interfaces) {
    Vector6 f = h.template segment<6>(k);
    i.to_motion(f);
    left += i.rigid().transpose() * f;
    k += 6;
  }
  const Vector6 mu = inverse_.transpose() * left;
  curvature.setZero();
  k = 0;
  for (Interface& i : interfaces) {
    const Vector6 f = h.template segment<6>(k) - i.weights.transpose() * mu;
    i.force = f.template head<3>();
    i.rotation_force = f.template tail<3>();
    i.moment = i.to_rate.transpose() * i.rotation_force;
    i.turning.template topRows<3>() = -hat(i.force);
    i.turning.template bottomRows<3>() = -0.5 * hat(i.moment);
    curvature -= arm_curvature(i.force, i.place);
    k += 6;
  }
}

template <class S>
void FloatingFrame<S>::bend(Eigen::MatrixX<S>& K) {
  const auto n = static_cast<Eigen::Index>(interfaces.size());
  const auto block = [&](Eigen::Index a, Eigen::Index b) {
    return K.template block<6, 6>(6 * a, 6 * b);
  };
  // B = Aᵀ H A and the second derivatives of the rotation vectors
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b < n; ++b) {
      const Interface &i = interfaces[a], &j = interfaces[b];
      Matrix6<S> B = block(a, b);
      i.to_motion(B);
      B.template rightCols<3>() *= j.to_rate;
      if (a == b) {
        const Matrix3<S> H = turned_moment(i.turn, i.rotation_force, i.gamma).slope * i.to_rate;
        B.template bottomRightCorner<3, 3>() += 0.5 * (H + H.transpose());
      }
      block(a, b) = B;
    }
  Matrix6<S> frame = Matrix6<S>::Zero();
  for (Eigen::Index a = 0; a < n; ++a) {
    Interface& i = interfaces[a];
    i.beside.setZero();
    for (Eigen::Index b = 0; b < n; ++b) i.beside -= block(a, b) * interfaces[b].rigid();
    i.beside.template rightCols<3>() += i.turning;
    Matrix6<S> twice = i.beside;
    twice.template rightCols<3>() += i.turning;
    frame -= 0.5 * i.rigid().transpose() * twice;
  }
  frame.template bottomRightCorner<3, 3>() += 0.5 * curvature;
  for (Interface& i : interfaces) i.beside += i.share.transpose() * frame;
  for (Eigen::Index a = 0; a < n; ++a)
    for (Eigen::Index b = 0; b <= a; ++b) {
      const Interface &i = interfaces[a], &j = interfaces[b];
      Matrix6<S> sum = block(a, b) + i.beside * j.share + (j.beside * i.share).transpose();
      if (a == b) sum = (0.5 * (sum + sum.transpose())).eval();
      for (int r = 0; r < 6; r += 3)
        for (int c = 0; c < 6; c += 3) {
          const Matrix3<S> seen = pose.axes * sum.template block<3, 3>(r, c);
          K.template block<3, 3>(6 * a + r, 6 * b + c) = seen * pose.axes.transpose();
        }
    }
  for (Eigen::Index b = 0; b < n; ++b) {
    const Matrix6<S> own = block(b, b);
    block(b, b) = 0.5 * (own + own.transpose());
    for (Eigen::Index a = 0; a < b; ++a) block(a, b) = block(b, a).transpose();
  }
}

}  // namespace flexopt
