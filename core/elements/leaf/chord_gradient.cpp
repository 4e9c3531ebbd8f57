#include "core/elements/leaf/chord_gradient.hpp"

#include <utility>

#include "core/math/dual.hpp"
#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

using chord::edge_turn;
using chord::FrameRate;
using chord::Turn;
using Turns = std::array<Turn<double>, 2>;

// Second derivative in q of chord::sine_factor(q, m).
double sine_factor_curvature(double q, int m) {
  return chord::sine_factor(Dual1::variable(q, 0), m).slope.derivatives[0];
}

// Covectors of the arguments of frame_rate().
struct Arguments {
  std::array<Matrix3d, 2> inverse{Matrix3d::Zero(), Matrix3d::Zero()};
  std::array<Vector3d, 2> spin{Vector3d::Zero(), Vector3d::Zero()};
  Vector3d apart = Vector3d::Zero();
  double chord = 0;
};

// Turns covectors `of` of the results of frame_rate() into covectors of its arguments, and adds
// these to `to`. `rate`: frame_rate(…, spin, …).
void pull_back(const Turns& turns, double chord, const std::array<Vector3d, 2>& spin,
               const FrameRate<double>& rate, FrameRate<double> of, Arguments& to) {
  double weight = 0;
  for (int a = 0; a < 2; ++a) {
    const Vector3d relative = turns[a].inverse.transpose() * of.theta[a];
    to.spin[a] += relative;
    of.spin -= relative;
    to.inverse[a] += of.theta[a] * (spin[a] - rate.spin).transpose();
    weight += turns[a].inverse(0, 0);
  }
  const double rolled = of.spin[0] / weight;
  for (int a = 0; a < 2; ++a) {
    to.spin[a] += rolled * turns[a].inverse.row(0).transpose();
    to.inverse[a].row(0) += rolled * (spin[a] - rate.spin).transpose();
    of.spin.tail<2>() -= rolled * turns[a].inverse.row(0).tail<2>().transpose();
  }
  to.apart += Vector3d(of.stretch, of.spin[2] / chord, -of.spin[1] / chord);
  to.chord -= (of.spin[1] * rate.spin[1] + of.spin[2] * rate.spin[2]) / chord;
}

// Covectors of θ and of t of the number c · Turn(θ).spin_rate(t).
struct SpinRateCovector {
  Vector3d theta, along;
};
SpinRateCovector spin_rate_covector(const Turn<double>& turn, const Vector3d& t, const Vector3d& c,
                                    const std::array<double, 2>& curvature) {
  const Vector3d& x = turn.theta;
  const Vector3d v = x.cross(t), cx = c.cross(x), ct = c.cross(t), vc = v.cross(c);
  const double dq = 2 * x.dot(t), da = 0.5 * turn.a.slope, db = turn.b.slope / 6,
               b = turn.b.value / 6, along_v = c.dot(v), along_vv = cx.dot(v), along_tv = ct.dot(v),
               second = dq * (0.5 * curvature[0] * along_v + curvature[1] / 6 * along_vv),
               first = da * along_v + db * along_vv;
  return {2 * (second + db * along_tv) * x + 2 * first * t + da * dq * t.cross(c) +
              db * dq * (vc + t.cross(cx)) + b * t.cross(ct),
          2 * first * x + dq * (da * cx + db * cx.cross(x)) + b * (vc + ct.cross(x))};
}

// Covector of θ from the covector M of J⁻¹ = 1 − ½ hat θ + γ hat² θ.
Vector3d inverse_covector(const Vector3d& x, const HatSquareFactor& g, const Matrix3d& M) {
  const Vector3d axial(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1)),
      both = (M + M.transpose()) * x;
  const double trace = M.trace(), square = 0.5 * x.dot(both) - x.squaredNorm() * trace;
  return -0.5 * axial + 2 * (g.slope * square - g.value * trace) * x + g.value * both;
}

// Covector of a FrameRate from the covector c of the six rates that FrameRate::e() lists.
FrameRate<double> of_rates(const Vector6d& c) {
  FrameRate<double> of;
  of.spin.setZero();
  of.stretch = c[elongation];
  of.theta[0] = Vector3d(-c[twist], c[theta1y], c[theta1z]);
  of.theta[1] = Vector3d(c[twist], c[theta2y], c[theta2z]);
  return of;
}

}  // namespace

ChordGradient::ChordGradient(const ChordFrame& frame, const EdgePoses& edges, const LeafRows& rows,
                             Energy energy)
    : frame_(&frame),
      edges_(edges),
      rows_(rows),
      energy_(std::move(energy)),
      turns_({Turn<double>(edge_turn(0) * frame.e), Turn<double>(edge_turn(1) * frame.e)}),
      edge_force_(frame.B.transpose() * energy_.force.head<6>()),
      edge_stiffness_(geometric_stiffness(frame, energy_.force.head<6>())) {
  for (int a = 0; a < 2; ++a) {
    // increments do not commute
    edge_stiffness_.block<3, 3>(6 * a + 3, 6 * a + 3) -=
        0.5 * hat(Vector3d(edge_force_.segment<3>(6 * a + 3)));
    const double q = (*turns_)[static_cast<std::size_t>(a)].theta.squaredNorm();
    curvature_[static_cast<std::size_t>(a)] = {sine_factor_curvature(q, 2),
                                               sine_factor_curvature(q, 3)};
  }
}

VectorXd ChordGradient::force() const {
  VectorXd f(rows_.unknowns + 12);
  f << energy_.force.tail(rows_.unknowns), edge_force_;
  return rows_.body_rows(f);
}

Vector12d ChordGradient::edge_moves(const LeafVariation<double>& v,
                                    std::array<Vector3d, 2>& lever) const {
  Vector12d moved;
  for (int a = 0; a < 2; ++a) {
    const LeafVariation<double>::Edge& edge = v.edge[a];
    const Matrix3d& R = edges_[a].axes;
    const Matrix3d spin = edge.rotation * R.transpose();
    lever[a] = spin * rows_.lever[a] + R * edge.arm;
    moved.segment<3>(6 * a) = edge.position + lever[a];
    moved.segment<3>(6 * a + 3) =
        0.5 * Vector3d(spin(2, 1) - spin(1, 2), spin(0, 2) - spin(2, 0), spin(1, 0) - spin(0, 1));
  }
  return moved;
}

MatrixXd ChordGradient::force_rates(const std::vector<LeafVariation<double>>& variations) const {
  const auto columns = static_cast<Eigen::Index>(variations.size());
  const int m = rows_.unknowns;
  MatrixXd moved(12, columns), turning(6, columns), shape(3, columns);
  for (Eigen::Index k = 0; k < columns; ++k) {
    const LeafVariation<double>& v = variations[static_cast<std::size_t>(k)];
    std::array<Vector3d, 2> lever;
    moved.col(k) = edge_moves(v, lever);
    shape.col(k) = v.shape.head<3>();
    for (int a = 0; a < 2; ++a)
      turning.block<3, 1>(3 * a, k) = lever[a].cross(Vector3d(edge_force_.segment<3>(6 * a)));
  }
  MatrixXd rate = energy_.shape_force * shape;
  rate += energy_.tangent.leftCols<6>() * (frame_->B * moved);
  MatrixXd f(m + 12, columns);
  f.topRows(m) = rate.bottomRows(m);
  f.bottomRows<12>() = frame_->B.transpose() * rate.topRows<6>();
  f.bottomRows<12>() += edge_stiffness_ * moved;
  MatrixXd rows = rows_.body_rows(f);
  for (int a = 0; a < 2; ++a) rows.middleRows<3>(rows_.body(a) + 3) += turning.middleRows<3>(3 * a);
  return rows;
}

auto ChordGradient::column(const Vector12d& y) const -> Column {
  const Matrix3d Et = frame_->axes.transpose();
  Column c;
  for (int a = 0; a < 2; ++a) c.spin[a] = Et * y.segment<3>(6 * a + 3);
  c.base = Et * y.head<3>();
  c.apart = Et * y.segment<3>(6) - c.base;
  c.path = chord::frame_path<double>(*turns_, frame_->chord, c.spin, c.apart);
  c.e1 = c.path.first.e();
  c.e2 = c.path.second.e();
  return c;
}

auto ChordGradient::seen(const Column& c, const std::array<Vector6d, 3>& of_e,
                         const Vector3d& of_spin) const -> Seen {
  const FrameRate<double>& first = c.path.first;
  const Vector3d& w = first.spin;
  const double chord = frame_->chord;
  const Turns& turns = *turns_;
  // the second rate, and how its arguments come from the first
  std::array<Vector3d, 2> spin2;
  for (int a = 0; a < 2; ++a) spin2[a] = c.spin[a].cross(w) - turns[a].spin_rate(first.theta[a]);
  Arguments to2;
  pull_back(turns, chord, spin2, c.path.second, of_rates(of_e[2]), to2);
  Arguments to;
  to.inverse = to2.inverse;
  to.chord = to2.chord;
  FrameRate<double> of = of_rates(of_e[1]);
  of.spin += of_spin;
  std::array<Vector3d, 2> of_theta;
  for (int a = 0; a < 2; ++a) {
    const SpinRateCovector turned =
        spin_rate_covector(turns[a], first.theta[a], to2.spin[a], curvature_[a]);
    of.theta[a] -= turned.along;
    of_theta[a] = -turned.theta;
    to.spin[a] += w.cross(to2.spin[a]);
    of.spin += to2.spin[a].cross(c.spin[a]);
  }
  to.apart += w.cross(to2.apart);
  of.spin += to2.apart.cross(c.apart);
  of.stretch += to2.apart[2] * w[1] - to2.apart[1] * w[2];
  of.spin[2] -= to2.apart[1] * first.stretch;
  of.spin[1] += to2.apart[2] * first.stretch;
  pull_back(turns, chord, c.spin, first, of, to);

  Seen result;
  result << of_e[0], to.spin[0], to.spin[1], to.apart;
  result[elongation] += to.chord;
  for (int a = 0; a < 2; ++a)
    result.head<6>() +=
        edge_turn(a).transpose() *
        (of_theta[a] +
         inverse_covector(turns[a].theta, {frame_->gamma[a], frame_->dgamma[a]}, to.inverse[a]));
  return result;
}

void ChordGradient::add(const MatrixXd& Y, int k, const Column& c, const Seen& h,
                        const Vector3d& by_base, LeafQuadratic<double>& q) const {
  const int m = rows_.unknowns;
  const Matrix3d& E = frame_->axes;
  const Vector3d h1 = h.segment<3>(6), h2 = h.segment<3>(9), ha = h.segment<3>(12);
  const Vector3d rolled =
      -(c.spin[0].cross(h1) + c.spin[1].cross(h2) + c.apart.cross(ha) + c.base.cross(by_base));
  Vector12d pose = frame_->B.transpose() * h.head<6>() + frame_->spin_local.transpose() * rolled;
  // the lever arms turn: F·(w × (w × lever))
  Vector12d turning = Vector12d::Zero();
  for (int a = 0; a < 2; ++a) {
    const Vector3d w = Y.block<3, 1>(rows_.body(a) + 3, k);
    turning.segment<3>(6 * a) = w.cross(w.cross(rows_.lever[a]));
  }
  const Vector6d of_e = frame_->B * turning,
                 of_force = energy_.tangent.topLeftCorner<6, 6>() * of_e;
  q.stiffness[k] += edge_force_.dot(turning);
  pose += edge_stiffness_.transpose() * turning + frame_->B.transpose() * of_force;
  q.shape.col(k).head<3>() += energy_.shape_force.topLeftCorner<6, 3>().transpose() * of_e;
  q.state.col(k).head(m).noalias() += energy_.tangent.bottomLeftCorner(m, 6) * of_e;
  const std::array<Vector3d, 2> by_displacement{E * (by_base - ha), E * ha},
      by_edge_spin{E * h1, E * h2};
  for (int a = 0; a < 2; ++a) {
    LeafQuadratic<double>::Edge& to = q.edge[static_cast<std::size_t>(k)][a];
    const Vector3d w = Y.block<3, 1>(rows_.body(a) + 3, k), lever = rows_.lever[a];
    const Matrix3d& R = edges_[a].axes;
    const Vector3d moved = pose.segment<3>(6 * a), turned_by = pose.segment<3>(6 * a + 3),
                   force = edge_force_.segment<3>(6 * a), fw = force.cross(w),
                   arm = moved + by_displacement[a].cross(w) + fw.cross(w);
    to.position = moved;
    to.arm = R.transpose() * arm;
    to.rotation = arm * (R.transpose() * lever).transpose() + 0.5 * hat(turned_by) * R;
    to.displacement = by_displacement[a];
    to.spin = by_edge_spin[a] + lever.cross(by_displacement[a] + fw) + w.cross(lever).cross(force);
    q.state.block<3, 1>(rows_.body(a), k) = moved;
    q.state.block<3, 1>(rows_.body(a) + 3, k) = turned_by + lever.cross(arm);
  }
}

}  // namespace flexopt
