#include "core/mechanism/drive.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

Vector3d axis_of(const Drive& drive) { return drive.axes.col(index(drive.direction) % 3); }

// a bᵀ, entry by entry: no matrix products on series.
template <class S>
Matrix3<S> dyad(const Vector3<S>& a, const Vector3<S>& b) {
  Matrix3<S> m;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) m(i, j) = a[i] * b[j];
  return m;
}
template <class S>
Matrix3<S> times(const Matrix3<S>& a, const Matrix3<S>& b) {
  return a.lazyProduct(b);
}
template <class S>
Vector3<S> times(const Matrix3<S>& a, const Vector3<S>& b) {
  return a.lazyProduct(b);
}
template <class S>
Matrix3<S> symmetric(const Matrix3<S>& a) {
  return 0.5 * (a + Matrix3<S>(a.transpose()));
}
template <class S>
Vector3<S> constant(const Vector3d& a) {
  return a.cast<S>();
}

// Both bodies, whose places are the first and the second half of 12 coordinates.
constexpr int spin = 3, other_at = 6, other_spin = 9;

template <class S>
void add_transposed(Eigen::Matrix<S, 12, 12>& H, int row, int column, const Matrix3<S>& block) {
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) {
      H(row + i, column + j) += block(i, j);
      H(column + j, row + i) += block(i, j);
    }
}

// Translation: everything is a product of the present axis and what stands beside it.
template <class S>
struct Apart {
  Vector3<S> axis, between;  ///< a, p − p′
};
template <class S>
void add_axis(DriveStroke<S>& s, const Vector3<S>& a) {
  for (int i = 0; i < 3; ++i) {
    s.gradient[i] += a[i];
    s.gradient[other_at + i] -= a[i];
  }
  add_transposed<S>(s.curvature, other_spin, 0, hat(a));
  add_transposed<S>(s.curvature, other_spin, other_at, Matrix3<S>(-hat(a)));
}
template <class S>
void add_apart(DriveStroke<S>& s, const Vector3<S>& a, const Vector3<S>& between) {
  s.value += a.dot(between);
  const Vector3<S> moment = a.cross(between);
  const S along = a.dot(between);
  const Matrix3<S> both = symmetric(dyad(between, a));
  for (int i = 0; i < 3; ++i) {
    s.gradient[other_spin + i] += moment[i];
    for (int j = 0; j < 3; ++j) s.curvature(other_spin + i, other_spin + j) += both(i, j);
    s.curvature(other_spin + i, other_spin + i) -= along;
  }
}

// Rotation: γ of J⁻¹ = 1 − ½ hat v + γ hat² v with its derivatives by q = |v|²: Σ cₙ qⁿ⁻¹ with
// cₙ = 2 ζ(2n)/(2π)²ⁿ, terms of ratio q/4π².
template <class S>
struct Gamma {
  S value, slope, second;
};
template <class S>
Gamma<S> gamma_of(const S& q) {
  constexpr int terms = 40;
  static const std::array<double, terms> c = [] {
    std::array<double, terms> list{};
    double power = 1;
    for (int n = 1; n <= terms; ++n) {
      power *= 4 * std::numbers::pi * std::numbers::pi;
      double zeta = n == 1   ? std::pow(std::numbers::pi, 2) / 6
                    : n == 2 ? std::pow(std::numbers::pi, 4) / 90
                    : n == 3 ? std::pow(std::numbers::pi, 6) / 945
                             : 1;
      if (n > 3)
        for (int k = 100; k >= 2; --k) zeta += std::pow(k, -2.0 * n);
      list[static_cast<std::size_t>(n - 1)] = 2 * zeta / power;
    }
    return list;
  }();
  Gamma<S> g{0, 0, 0};
  for (int k = terms - 1; k >= 0; --k) {
    g.second = g.second * q + 2.0 * g.slope;
    g.slope = g.slope * q + g.value;
    g.value = g.value * q + S(c[static_cast<std::size_t>(k)]);
  }
  return g;
}

template <class S>
Matrix3<S> inverse_tangent(const Vector3<S>& v, const S& gamma) {
  const Matrix3<S> V = hat(v);
  return Matrix3<S>(Matrix3<S>::Identity() - 0.5 * V + gamma * times<S>(V, V));
}

Vector3d log_of(const Matrix3d& Q) { return rotation_log(Q); }
// Newton's method from the rotation at the start: every round doubles the orders that hold.
Vector3<Jet> log_of(const Matrix3<Jet>& Q) {
  const Vector3d start = rotation_log(coefficients(Q, 0));
  Vector3<Jet> v = start.cast<Jet>();
  for (int round = 0; round < 2; ++round) {
    const Matrix3<Jet> back = jet_rotation_exp(v).transpose();
    const Matrix3<Jet> E = times<Jet>(Q, back);
    const Vector3<Jet> rest(0.5 * (E(2, 1) - E(1, 2)), 0.5 * (E(0, 2) - E(2, 0)),
                            0.5 * (E(1, 0) - E(0, 1)));
    v += times<Jet>(inverse_tangent<Jet>(v, gamma_of<Jet>(v.dot(v)).value), rest);
  }
  return v;
}

// Seen from `other`: the rotation vector v, J⁻¹, w = J⁻ᵀ a and ∂w/∂v.
template <class S>
struct Turned {
  Matrix3<S> Q;
  Vector3<S> v;
  Gamma<S> gamma;
  Matrix3<S> inverse, slope;
  Vector3<S> w;
};
template <class S>
Turned<S> turned(const Vector3<S>& a, const JointBodyOf<S>& body, const JointBodyOf<S>& other) {
  Turned<S> t;
  t.Q = times<S>(Matrix3<S>(other.rotation.transpose()), body.rotation);
  t.v = log_of(t.Q);
  t.gamma = gamma_of<S>(t.v.dot(t.v));
  t.inverse = inverse_tangent<S>(t.v, t.gamma.value);
  const Vector3<S> va = t.v.cross(a), vva = t.v.cross(va);
  t.w = a + 0.5 * va + t.gamma.value * vva;
  t.slope = -0.5 * hat(a) - t.gamma.value * (hat(va) + times<S>(hat(t.v), hat(a))) +
            (2.0 * t.gamma.slope) * dyad<S>(vva, t.v);
  return t;
}

// The stroke's gradient W = R′w on both spins, the load's moment on them, the spins that do not
// commute, and G between them.
template <class S>
void add_spins(DriveStroke<S>& s, const Vector3<S>& W, const Vector3<S>& moment,
               const Matrix3<S>& G) {
  for (int i = 0; i < 3; ++i) {
    s.gradient[spin + i] += W[i];
    s.gradient[other_spin + i] -= W[i];
    s.load[spin + i] += moment[i];
    s.load[other_spin + i] -= moment[i];
    for (int j = 0; j < 3; ++j) {
      s.winding(spin + i, spin + j) += G(i, j);
      s.winding(other_spin + i, other_spin + j) += G(i, j);
      s.winding(spin + i, other_spin + j) -= G(i, j);
      s.winding(other_spin + i, spin + j) -= G(i, j);
    }
  }
  add_transposed<S>(s.curvature, other_spin, spin, Matrix3<S>(0.5 * hat(moment)));
}
template <class S>
Matrix3<S> seen(const Matrix3<S>& R, const Matrix3<S>& H, const Matrix3<S>& L) {
  return times<S>(times<S>(R, H), Matrix3<S>(L.transpose()));
}

}  // namespace

std::optional<int> coordinate_of(const Mechanism& mechanism, std::size_t drive) {
  const Drive& d = mechanism.drives[drive];
  if (d.other != ground || d.axes_change || d.axes != Matrix3d::Identity()) return std::nullopt;
  if (is_rotation(d.direction) && mechanism.drives.size() > 1) return std::nullopt;
  return 6 * d.body + index(d.direction);
}

DriveLoad load_of_rotations(const Mechanism& mechanism) {
  return mechanism.drives.size() > 1 ? DriveLoad::conjugate : DriveLoad::about_axis;
}

std::vector<int> conditional_drives(const Mechanism& mechanism) {
  std::vector<int> list;
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k)
    if (!coordinate_of(mechanism, k)) list.push_back(static_cast<int>(k));
  return list;
}

std::optional<Direction> end_effector_direction(const Mechanism& mechanism, const Drive& drive) {
  if (drive.body != mechanism.end_effector || drive.other != ground) return std::nullopt;
  const Vector3d a = axis_of(drive);
  int largest = 0;
  const double size = a.cwiseAbs().maxCoeff(&largest);
  if (!(size > 1 - 1e-12)) return std::nullopt;
  return static_cast<Direction>(largest + (is_rotation(drive.direction) ? 3 : 0));
}

std::array<bool, 6> prescribed_directions(const Mechanism& mechanism) {
  std::array<bool, 6> prescribed{};
  for (const Drive& drive : mechanism.drives)
    if (const auto d = end_effector_direction(mechanism, drive)) prescribed[index(*d)] = true;
  return prescribed;
}

template <class S>
DriveStroke<S> drive_stroke(const Drive& drive, DriveLoad load, const JointBodyOf<S>& body,
                            const JointBodyOf<S>& other) {
  DriveStroke<S> s;
  const Vector3d own = axis_of(drive);
  const Vector3<S> a = constant<S>(own);
  if (!is_rotation(drive.direction)) {
    const Vector3<S> axis = times<S>(other.rotation, a), between = body.position - other.position;
    add_axis<S>(s, axis);
    add_apart<S>(s, axis, between);
    s.value -= S(own.dot(body.reference - other.reference));
    s.load = s.gradient;
    return s;
  }
  const Turned<S> t = turned<S>(a, body, other);
  s.value = a.dot(t.v);
  // a load about the axis is no gradient: −½ hat of its moment does not belong to the bodies
  const Vector3<S> axis = times<S>(other.rotation, a), W = times<S>(other.rotation, t.w);
  if (load == DriveLoad::about_axis)
    add_spins<S>(s, W, axis, Matrix3<S>(0.5 * hat(axis)));
  else
    add_spins<S>(
        s, W, W,
        seen<S>(other.rotation, symmetric<S>(times<S>(t.slope, t.inverse)), other.rotation));
  return s;
}

template <class S>
DriveStroke<S> drive_stroke_rate(const StrokeState<S>& at, DriveLoad load,
                                 const StrokeState<S>& rate) {
  DriveStroke<S> s;
  const Vector3d own = axis_of(at.drive), own_rate = axis_of(rate.drive);
  const Vector3<S> a = constant<S>(own), da = constant<S>(own_rate);
  const Matrix3<S>&R = at.other.rotation, &dR = rate.other.rotation;
  if (!is_rotation(at.drive.direction)) {
    const Vector3<S> axis = times<S>(R, a), moves = times<S>(dR, a) + times<S>(R, da),
                     between = at.body.position - at.other.position,
                     parts = rate.body.position - rate.other.position;
    add_axis<S>(s, moves);
    add_apart<S>(s, moves, between);
    add_apart<S>(s, axis, parts);
    s.value -= S(own_rate.dot(at.body.reference - at.other.reference) +
                 own.dot(rate.body.reference - rate.other.reference));
    s.load = s.gradient;
    return s;
  }
  const Turned<S> t = turned<S>(a, at.body, at.other);
  const Matrix3<S> dQ = times<S>(Matrix3<S>(dR.transpose()), at.body.rotation) +
                        times<S>(Matrix3<S>(R.transpose()), rate.body.rotation);
  const Matrix3<S> turn = times<S>(dQ, Matrix3<S>(t.Q.transpose()));
  const Vector3<S> omega(0.5 * (turn(2, 1) - turn(1, 2)), 0.5 * (turn(0, 2) - turn(2, 0)),
                         0.5 * (turn(1, 0) - turn(0, 1)));
  const Vector3<S> dv = times<S>(t.inverse, omega);
  const S dq = 2.0 * t.v.dot(dv), dgamma = t.gamma.slope * dq, dslope = t.gamma.second * dq;
  const Matrix3<S> V = hat(t.v), dV = hat(dv), A = hat(a), dA = hat(da);
  const Vector3<S> va = t.v.cross(a), vva = t.v.cross(va), dva = dv.cross(a) + t.v.cross(da),
                   dvva = dv.cross(va) + t.v.cross(dva);
  const Matrix3<S> dinverse =
      -0.5 * dV + dgamma * times<S>(V, V) + t.gamma.value * (times<S>(dV, V) + times<S>(V, dV));
  const Vector3<S> dw = da + 0.5 * dva + dgamma * vva + t.gamma.value * dvva;
  const Matrix3<S> dS = -0.5 * dA - dgamma * (hat(va) + times<S>(V, A)) -
                        t.gamma.value * (hat(dva) + times<S>(dV, A) + times<S>(V, dA)) +
                        (2.0 * dslope) * dyad<S>(vva, t.v) +
                        (2.0 * t.gamma.slope) * (dyad<S>(dvva, t.v) + dyad<S>(vva, dv));
  const Matrix3<S> H = symmetric<S>(times<S>(t.slope, t.inverse)),
                   dH = symmetric<S>(
                       Matrix3<S>(times<S>(dS, t.inverse) + times<S>(t.slope, dinverse)));
  s.value = da.dot(t.v) + a.dot(dv);
  const Vector3<S> W = times<S>(dR, t.w) + times<S>(R, dw),
                   axis = times<S>(dR, a) + times<S>(R, da);
  if (load == DriveLoad::about_axis)
    add_spins<S>(s, W, axis, Matrix3<S>(0.5 * hat(axis)));
  else
    add_spins<S>(s, W, W, Matrix3<S>(seen<S>(dR, H, R) + seen<S>(R, dH, R) + seen<S>(R, H, dR)));
  return s;
}

template DriveStroke<double> drive_stroke(const Drive&, DriveLoad, const JointBodyOf<double>&,
                                          const JointBodyOf<double>&);
template DriveStroke<Jet> drive_stroke(const Drive&, DriveLoad, const JointBodyOf<Jet>&,
                                       const JointBodyOf<Jet>&);
template DriveStroke<double> drive_stroke_rate(const StrokeState<double>&, DriveLoad,
                                               const StrokeState<double>&);
template DriveStroke<Jet> drive_stroke_rate(const StrokeState<Jet>&, DriveLoad,
                                            const StrokeState<Jet>&);

std::optional<std::string> broken_drive_rule(const Mechanism& mechanism) {
  const int bodies = static_cast<int>(mechanism.bodies.size());
  if (mechanism.drives.size() > 6) return "there are more than six drives";
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k) {
    const Drive& drive = mechanism.drives[k];
    const std::string who = drive.name.empty() ? "the drive" : "drive " + drive.name;
    const auto known = [&](int body) { return body >= 0 && body < bodies; };
    if (!known(drive.body)) return fmt::format("{}: there is no body {}", who, drive.body);
    if (drive.other != ground && !known(drive.other))
      return fmt::format("{}: there is no body {}", who, drive.other);
    if (drive.body == drive.other) return who + ": it drives a body against itself";
    if (!((drive.axes.transpose() * drive.axes - Matrix3d::Identity()).norm() < 1e-9) ||
        drive.axes.determinant() < 0)
      return who + ": its axes must be orthonormal and right-handed";
    for (std::size_t j = 0; j < k; ++j)
      if (mechanism.drives.size() > 1 && mechanism.drives[j].name == drive.name)
        return fmt::format("two drives have the name {}", drive.name);
    if (const auto c = coordinate_of(mechanism, k);
        c && mechanism.bodies[drive.body].held[index(drive.direction)])
      return drive.body == mechanism.end_effector
                 ? "the end-effector cannot move in the direction of the drive"
                 : mechanism.bodies[drive.body].name + " cannot move in the direction of the drive";
  }
  return std::nullopt;
}

}  // namespace flexopt
