#include "core/elements/leaf/chord_frame.hpp"

#include <cmath>

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

constexpr double roll_tolerance = 1e-14;  // [rad]
constexpr int max_roll_steps = 12;        // 2 or 3 happen

/// First entry of J⁻¹: change of θx with the roll of the frame.
double roll_rate(const Vector3d& th) {
  const double q = th.squaredNorm();
  return 1 + hat_square_factor(q).value * (th[0] * th[0] - q);
}

/// Rolls the frame by Newton: d(θ1x + θ2x) = −(J1⁻¹ + J2⁻¹)_xx dr. A roll mixes rows 2, 3 of
/// Q = Eᵀ R.
void roll(ChordFrame& c, const EdgePoses& edges) {
  std::array<Matrix3d, 2> Q;
  for (int a = 0; a < 2; ++a) Q[a].noalias() = c.axes.transpose() * edges[a].axes;
  double previous = 1e300;
  for (int step = 0;; ++step) {
    for (int a = 0; a < 2; ++a) c.theta[a] = rotation_log(Q[a]);
    const double sum = c.theta[0][0] + c.theta[1][0];
    c.roll_residual = std::abs(sum);
    c.converged = c.roll_residual <= roll_tolerance;
    if (c.roll_residual <= 0.1 * roll_tolerance) return;
    if (c.converged && c.roll_residual >= previous) return;  // at the floor of rounding
    if (step == max_roll_steps) return;
    previous = c.roll_residual;
    const double r = sum / (roll_rate(c.theta[0]) + roll_rate(c.theta[1]));
    const double cr = std::cos(r), sr = std::sin(r);
    const Vector3d rolled = cr * c.axes.col(1) + sr * c.axes.col(2);
    c.axes.col(2) = cr * c.axes.col(2) - sr * c.axes.col(1);
    c.axes.col(1) = rolled;
    for (int a = 0; a < 2; ++a) {
      const Eigen::RowVector3d row = cr * Q[a].row(1) + sr * Q[a].row(2);
      Q[a].row(2) = cr * Q[a].row(2) - sr * Q[a].row(1);
      Q[a].row(1) = row;
    }
  }
}

/// Spin of the frame in its own axes: ψy = −E3·ḋ/l, ψz = E2·ḋ/l, and ψx from (F1):
/// Σ_a (J_a⁻¹ (ωa − ψ))_x = 0.
void set_spin(ChordFrame& c) {
  const Matrix3d Et = c.axes.transpose();
  Rows3x12& psi = c.spin_local;
  psi.setZero();
  psi.block<1, 3>(1, 6) = -Et.row(2) / c.chord;
  psi.block<1, 3>(2, 6) = Et.row(1) / c.chord;
  psi.block<2, 3>(1, 0) = -psi.block<2, 3>(1, 6);
  const Eigen::RowVector3d h1 = c.to_rate[0].row(0), h2 = c.to_rate[1].row(0), h = h1 + h2;
  psi.block<1, 3>(0, 3).noalias() = h1 * Et;
  psi.block<1, 3>(0, 9).noalias() = h2 * Et;
  psi.row(0) = (psi.row(0) - h[1] * psi.row(1) - h[2] * psi.row(2)) / h[0];
  c.spin.noalias() = c.axes.lazyProduct(psi);
}

}  // namespace

ChordFrame chord_frame(const EdgePoses& edges, double length) {
  ChordFrame c;
  const Vector3d d = edges[1].position - edges[0].position;
  c.chord = d.norm();
  const Vector3d E1 = d / c.chord;
  Vector3d width = edges[0].axes.col(1) + edges[1].axes.col(1);
  width -= E1 * E1.dot(width);
  const double width_norm = width.norm();
  if (!(c.chord > 1e-6 * length) || !(width_norm > 1e-6)) return c;
  c.axes.col(0) = E1;
  c.axes.col(1) = width / width_norm;
  c.axes.col(2) = E1.cross(c.axes.col(1));
  roll(c, edges);
  if (!c.converged) return c;

  const auto& [t1, t2] = c.theta;
  c.e << c.chord - length, t1[1], t1[2], t2[1], t2[2], t2[0] - t1[0];
  for (int a = 0; a < 2; ++a) {
    const HatSquareFactor g = hat_square_factor(c.theta[a].squaredNorm());
    c.gamma[a] = g.value;
    c.dgamma[a] = g.slope;
    const Matrix3d K = hat(c.theta[a]);
    c.to_rate[a] = Matrix3d::Identity() - 0.5 * K + g.value * K * K;
  }
  set_spin(c);
  const Matrix3d Et = c.axes.transpose();
  for (int a = 0; a < 2; ++a) {
    Rows3x12 relative = -c.spin_local;
    relative.block<3, 3>(0, 3 + 6 * a) += Et;
    c.theta_rate[a].noalias() = c.to_rate[a].lazyProduct(relative);
    c.B.middleRows<2>(a == 0 ? theta1y : theta2y) = c.theta_rate[a].bottomRows<2>();
  }
  c.B.row(elongation).setZero();
  c.B.block<1, 3>(elongation, 0) = -Et.row(0);
  c.B.block<1, 3>(elongation, 6) = Et.row(0);
  c.B.row(twist) = c.theta_rate[1].row(0) - c.theta_rate[0].row(0);
  return c;
}

Matrix12d geometric_stiffness(const ChordFrame& c, const Vector6d& g) {
  // Bᵀ g is a set of edge forces in equilibrium: moments m_a = J_a⁻ᵀ (c_a + λ x), with λ such that
  // they do not roll the frame, and forces ∓F. Their change with dq at constant g, symmetrised
  // (which is what varying R as exp(hat dω) R to second order means), is the geometric stiffness.
  const double l = c.chord;
  std::array<Vector3d, 2> load{Vector3d(-g[twist], g[theta1y], g[theta1z]),
                               Vector3d(g[twist], g[theta2y], g[theta2z])};
  const double roll = c.to_rate[0](0, 0) + c.to_rate[1](0, 0);
  double lambda = 0;
  for (int a = 0; a < 2; ++a) lambda -= c.to_rate[a].col(0).dot(load[a]) / roll;

  std::array<Vector3d, 2> m;
  std::array<Rows3x12, 2> dm;
  for (int a = 0; a < 2; ++a) {
    load[a][0] += lambda;
    const TurnedMoment<double> moment =
        turned_moment(c.theta[a], load[a], {c.gamma[a], c.dgamma[a]});
    m[a] = moment.value;
    dm[a].noalias() = moment.slope.lazyProduct(c.theta_rate[a]);
  }
  const Eigen::Matrix<double, 1, 12> dlambda = -(dm[0].row(0) + dm[1].row(0)) / roll;
  for (int a = 0; a < 2; ++a)
    for (int i = 0; i < 3; ++i) dm[a].row(i) += c.to_rate[a](0, i) * dlambda;

  const Vector3d M = m[0] + m[1];  // M_x = 0
  const Vector3d F(g[elongation], -M[2] / l, M[1] / l);
  Rows3x12 dF;
  dF.row(0).setZero();
  dF.row(1) = (-(dm[0].row(2) + dm[1].row(2)) - F[1] * c.B.row(elongation)) / l;
  dF.row(2) = ((dm[0].row(1) + dm[1].row(1)) - F[2] * c.B.row(elongation)) / l;

  // Into global axes, with the turning of the frame: d(E v) = E (dv + ψ × v).
  dF.noalias() -= hat(F).lazyProduct(c.spin_local);
  for (int a = 0; a < 2; ++a) dm[a].noalias() -= hat(m[a]).lazyProduct(c.spin_local);
  Eigen::Matrix<double, 12, 12, Eigen::RowMajor> K;
  K.middleRows<3>(6).noalias() = c.axes.lazyProduct(dF);
  K.middleRows<3>(0) = -K.middleRows<3>(6);
  K.middleRows<3>(3).noalias() = c.axes.lazyProduct(dm[0]);
  K.middleRows<3>(9).noalias() = c.axes.lazyProduct(dm[1]);
  return 0.5 * (K + K.transpose());
}

}  // namespace flexopt
