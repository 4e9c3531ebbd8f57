#include "core/reduction/superelement/superelement_gradient.hpp"

#include <array>
#include <cassert>

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

/// d²γ/dq² of hat_square_factor, by its differential equation q γ′ = 1/8 − 3/2 γ + ½ q γ².
double hat_square_curvature(double q, const HatSquareFactor& g) {
  if (q < 1e-3) return 2 / 30240.0;  // it stands before q² only
  return (-2.5 * g.slope + 0.5 * g.value * g.value + q * g.value * g.slope) / q;
}

// θ2, the second derivative of θ = log(exp(ε hat x + ½ ε² hat Ω2) exp(hat θ)), less J⁻¹ Ω2, and the
// gradient of r·θ2 in θ at constant x.
struct SecondTurn {
  Vector3d value, gradient;
};
SecondTurn second_turn(const Vector3d& theta, const Matrix3d& to_rate, const Vector3d& x,
                       const Vector3d& r, const Matrix3d& slope) {
  const double q = theta.squaredNorm();
  const HatSquareFactor g = hat_square_factor(q);
  const Vector3d t = to_rate * x, p = theta.cross(x), tx = t.cross(x);
  const double along = theta.dot(t);
  const Vector3d twice = theta.cross(p), mixed = t.cross(p) + theta.cross(tx);
  SecondTurn s;
  s.value = -0.5 * tx + 2 * g.slope * along * twice + g.value * mixed;
  const Vector3d k = slope.transpose() * x, r_theta = r.cross(theta);
  s.gradient =
      turned_moment(theta, k, g).slope.transpose() * x +
      (4 * hat_square_curvature(q, g) * along * r.dot(twice) + 2 * g.slope * r.dot(mixed)) * theta +
      2 * g.slope * (r.dot(twice) * t + along * (p.cross(r) + x.cross(r_theta))) +
      g.value * (x.cross(r.cross(t)) + tx.cross(r));
  return s;
}

}  // namespace

Vector6d SuperelementGradient::turned_back(const NodeVector& v) const {
  const Superelement& e = *element_;
  Vector6d sum = Vector6d::Zero();
  for (int a = 0; a < nodes_; ++a) {
    const Vector3d f = v.segment<3>(6 * a);
    sum.head<3>() += f;
    sum.tail<3>() += e.place_[a].cross(f) + e.to_rate_[a].transpose() * v.segment<3>(6 * a + 3);
  }
  return sum;
}

SuperelementGradient::SuperelementGradient(const Superelement& element,
                                           std::span<const SuperelementModel> rates)
    : element_(&element),
      model_(&element.model()),
      rates_(rates),
      n_(model_->coordinates()),
      nodes_(n_ / 6),
      A_(element.A_),
      A_t_(element.A_.transpose()) {
  assert(nodes_ <= most_nodes && element.frame().converged);
  const Superelement& e = element;
  // forces and places in frame axes from here on
  const NodeVector Kq = model_->stiffness.topLeftCorner(n_, n_) * e.q_;
  lambda_ = A_t_.solve(turned_back(Kq));
  for (int a = 0; a < nodes_; ++a) {
    const Vector3d theta = e.q_.segment<3>(6 * a + 3);
    moment_slope_.push_back(
        turned_moment(theta, e.r_.segment<3>(6 * a + 3), hat_square_factor(theta.squaredNorm()))
            .slope);
  }
  const int count = static_cast<int>(rates.size());
  work_rates_.resize(n_, count);
  force_rates_.resize(n_, count);
  local_rates_.resize(n_, count);
  for (int p = 0; p < count; ++p) add_rate(p);
}

void SuperelementGradient::add_rate(int p) {
  const Superelement& e = *element_;
  const SuperelementModel& rate = rates_[p];
  NodeVector dq = NodeVector::Zero(n_);
  for (int a = 0; a < nodes_; ++a) dq.segment<3>(6 * a) = -rate.nodes[a];
  const Vector6d frame = A_.solve(Vector6d(rate.frame_modes * e.q_ + model_->frame_modes * dq));
  frame_rates_.push_back(frame);
  const Vector3d xi = frame.head<3>(), psi = frame.tail<3>();
  Vector6d missing = Vector6d::Zero();
  for (int a = 0; a < nodes_; ++a) {
    const Vector3d dy = -xi - psi.cross(e.place_[a]), dtheta = -e.to_rate_[a] * psi;
    dq.segment<3>(6 * a) += dy;
    dq.segment<3>(6 * a + 3) = dtheta;
    missing.tail<3>() += moment_slope_[a] * dtheta + dy.cross(Vector3d(e.f_.segment<3>(6 * a)));
  }
  local_rates_.col(p) = dq;
  work_rates_.col(p) =
      rate.stiffness.topLeftCorner(n_, n_) * e.q_ - rate.frame_modes.transpose() * lambda_;
  NodeVector dr = work_rates_.col(p) + model_->stiffness.topLeftCorner(n_, n_) * dq;
  dr -= model_->frame_modes.transpose() * A_t_.solve(Vector6d(missing + turned_back(dr)));
  for (int a = 0; a < nodes_; ++a) {
    const Vector3d f = e.f_.segment<3>(6 * a), m = e.f_.segment<3>(6 * a + 3);
    force_rates_.block<3, 1>(6 * a, p) = e.frame_.axes * (dr.segment<3>(6 * a) + psi.cross(f));
    force_rates_.block<3, 1>(6 * a + 3, p) =
        e.frame_.axes * (e.to_rate_[a].transpose() * dr.segment<3>(6 * a + 3) +
                         moment_slope_[a] * dq.segment<3>(6 * a + 3) + psi.cross(m));
  }
}

MatrixXd SuperelementGradient::frame_rates(const MatrixXd& Z) const {
  MatrixXd b = Z;
  for (int i = 0; i < n_; i += 3)
    b.middleRows<3>(i) = element_->frame_.axes.transpose() * Z.middleRows<3>(i);
  return element_->Z_ * b;
}

MatrixXd SuperelementGradient::force_rates(const MatrixXd& Z) const {
  MatrixXd rates = element_->tangent() * Z;
  for (int i = 3; i < n_; i += 6)  // spins do not commute
    rates.middleRows<3>(i) -=
        0.5 * hat(Vector3d(element_->force().segment<3>(i))) * Z.middleRows<3>(i);
  return rates;
}

/// A column y of increments, and how the element moves along it: q = q0 + ε q1 + ½ ε² q2.
struct SuperelementGradient::Motion {
  NodeVector increments;  ///< of the nodes, frame axes
  NodeVector momentum;    ///< mass times y
  Vector3d xi, psi;       ///< of the frame: displacement, spin
  NodeVector q1, q2, r1;
  Vector6d lambda1;
  std::array<Vector3d, most_nodes> turn;  ///< spin of each node less that of the frame
  std::array<Vector3d, most_nodes> along_turn, turn_gradient;
};

void SuperelementGradient::add_mass(const VectorXd& y, double mu, Motion& motion,
                                    Quadratic& form) const {
  const Matrix3d& F = element_->frame_.axes;
  const int n = n_, own = amplitudes();
  form.increment = y;
  for (int i = 0; i < n; i += 3) form.increment.segment<3>(i) = F.transpose() * y.segment<3>(i);
  motion.increments = form.increment.head(n);
  const NodeVector& b = motion.increments;
  const auto modal = y.tail(own);
  form.stiffness = form.mass = 0;
  for (std::size_t p = 0; p < rates_.size(); ++p) {
    const auto dM = rates_[p].mass.topLeftCorner(n, n);
    form.model[p] = -mu * b.dot(dM * b);
    if (own > 0)
      form.model[p] -= mu * (2 * b.dot(rates_[p].mass.topRightCorner(n, own) * modal) +
                             modal.dot(rates_[p].mass.bottomRightCorner(own, own) * modal)) -
                       modal.dot(rates_[p].stiffness.bottomRightCorner(own, own) * modal);
  }
  NodeVector& Mb = motion.momentum;
  Mb = model_->mass.topLeftCorner(n, n) * b;
  if (own > 0) {
    Mb.noalias() += model_->mass.topRightCorner(n, own) * modal;
    auto c = form.increment.tail(own);
    c.noalias() = model_->mass.bottomLeftCorner(own, n) * b;
    c.noalias() += model_->mass.bottomRightCorner(own, own) * modal;
    form.mass += modal.dot(c);
    c *= -2 * mu;
    for (int k = 0; k < own; ++k) {
      const double Ka = model_->stiffness(n + k, n + k) * modal[k];
      form.stiffness += modal[k] * Ka;
      c[k] += 2 * Ka;
    }
  }
  form.mass += b.dot(Mb);
}

// (R16)
double SuperelementGradient::move(Motion& motion) const {
  const Superelement& e = *element_;
  const auto K = model_->stiffness.topLeftCorner(n_, n_);
  const NodeVector& b = motion.increments;
  const Vector6d frame = e.Z_ * b;
  motion.xi = frame.head<3>();
  motion.psi = frame.tail<3>();
  const Vector3d &xi = motion.xi, &psi = motion.psi;
  motion.q1.resize(n_);
  motion.q2.resize(n_);
  NodeVector &q1 = motion.q1, &q2 = motion.q2;
  Vector6d by_frame = Vector6d::Zero();  // ½ ∂(r·q2)/∂(ξ, ψ)
  for (int a = 0; a < nodes_; ++a) {
    const int i = 6 * a;
    const Vector3d &place = e.place_[a], r = e.r_.segment<3>(i), rt = e.r_.segment<3>(i + 3),
                   m = e.f_.segment<3>(i + 3), u = b.segment<3>(i) - xi, w = b.segment<3>(i + 3);
    const Matrix3d &to_rate = e.to_rate_[a], &slope = moment_slope_[a];
    const Vector3d x = motion.turn[a] = w - psi, turned = psi.cross(place);
    q1.segment<3>(i) = u - turned;
    q1.segment<3>(i + 3) = to_rate * x;
    q2.segment<3>(i) = psi.cross(turned - 2 * u);
    const SecondTurn second = second_turn(e.q_.segment<3>(i + 3), to_rate, x, rt, slope);
    motion.turn_gradient[a] = second.gradient;
    q2.segment<3>(i + 3) = second.value - to_rate * psi.cross(w);
    motion.along_turn[a] =
        slope * q1.segment<3>(i + 3) + to_rate.transpose() * (slope.transpose() * x);
    by_frame.head<3>() += r.cross(psi);
    by_frame.tail<3>() +=
        0.5 * (turned.cross(r) + place.cross(r.cross(psi)) - motion.along_turn[a] - w.cross(m)) -
        u.cross(r);
  }
  const NodeVector Kq1 = K * q1;
  const double stiffness = q1.dot(Kq1) + e.r_.dot(q2);
  motion.lambda1 = A_t_.solve(Vector6d(turned_back(Kq1) - by_frame));
  motion.r1 = Kq1;
  motion.r1.noalias() -= model_->frame_modes.transpose() * motion.lambda1;
  return stiffness;
}

// (R17): λ̇ answers by l, so that K e stands against q̇, e = q2 + D Φ_rig l
void SuperelementGradient::add_derivatives(const Motion& motion, double mu, Quadratic& form) const {
  const Superelement& e = *element_;
  const Matrix3d& F = e.frame_.axes;
  const auto K = model_->stiffness.topLeftCorner(n_, n_);
  const Vector3d& psi = motion.psi;
  const Vector6d l = A_.solve(Vector6d(-(model_->frame_modes * motion.q2)));
  const Vector3d l_turn = l.tail<3>();
  NodeVector rest = motion.q2;
  for (int a = 0; a < nodes_; ++a) {
    rest.segment<3>(6 * a) += l.head<3>() + l_turn.cross(e.place_[a]);
    rest.segment<3>(6 * a + 3) += e.to_rate_[a] * l_turn;
  }
  const NodeVector Ke = K * rest;
  NodeVector c(n_);                       // ∂q/∂(y, spin of the node) in the frame
  Vector6d by_motion = Vector6d::Zero();  // ∂q/∂(frame)
  for (int a = 0; a < nodes_; ++a) {
    const int i = 6 * a;
    const Vector3d &place = e.place_[a], r = e.r_.segment<3>(i), m = e.f_.segment<3>(i + 3),
                   u = motion.increments.segment<3>(i), w = motion.increments.segment<3>(i + 3),
                   r1u = motion.r1.segment<3>(i), r1t = motion.r1.segment<3>(i + 3),
                   &x = motion.turn[a], theta = e.q_.segment<3>(i + 3);
    const Vector3d r_psi = r.cross(psi);
    const TurnedMoment moment1 = turned_moment(theta, r1t, hat_square_factor(theta.squaredNorm()));
    const Vector3d cy = -2 * r1u.cross(psi) + r_psi.cross(psi) + Ke.segment<3>(i) + r.cross(l_turn);
    const Vector3d ct = 2 * moment1.slope.transpose() * x + motion.turn_gradient[a] +
                        moment_slope_[a].transpose() * (l_turn - psi.cross(w)) +
                        Ke.segment<3>(i + 3);
    const Vector3d cu = 2 * r1u - 2 * r_psi - 2 * mu * motion.momentum.segment<3>(i);
    const Vector3d cw = 2 * moment1.value + motion.along_turn[a] - m.cross(psi) -
                        2 * mu * motion.momentum.segment<3>(i + 3);
    const Vector3d cs = e.to_rate_[a].transpose() * ct;
    c.segment<3>(i) = cy;
    c.segment<3>(i + 3) = cs;
    form.increment.segment<3>(i) = F * cu;
    form.increment.segment<3>(i + 3) = F * cw;
    by_motion.head<3>() -= cy;
    by_motion.tail<3>() -= place.cross(cy) + cs + u.cross(cu) + w.cross(cw);
  }
  c.noalias() += e.Z_.transpose() * by_motion;
  for (int i = 0; i < n_; i += 3) form.state.segment<3>(i) = F * c.segment<3>(i);

  for (std::size_t p = 0; p < rates_.size(); ++p) {
    const SuperelementModel& rate = rates_[p];
    form.model[p] += motion.q1.dot(rate.stiffness.topLeftCorner(n_, n_) * motion.q1) +
                     work_rates_.col(p).dot(rest) -
                     2 * motion.lambda1.dot(rate.frame_modes * motion.q1) +
                     by_motion.dot(frame_rates_[p]);
    for (int a = 0; a < nodes_; ++a) form.model[p] -= Ke.segment<3>(6 * a).dot(rate.nodes[a]);
  }
}

void SuperelementGradient::quadratic(const VectorXd& y, double mu, Quadratic& form) const {
  assert(y.size() == n_ + amplitudes());
  form.increment.resize(n_ + amplitudes());
  form.state.resize(n_);
  form.model.resize(static_cast<Eigen::Index>(rates_.size()));
  Motion motion;
  add_mass(y, mu, motion, form);
  form.stiffness += move(motion);
  add_derivatives(motion, mu, form);
}

}  // namespace flexopt
