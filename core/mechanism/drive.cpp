#include "core/mechanism/drive.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/math/rotation.hpp"

namespace flexopt {
namespace {

Vector3d axis_of(const Drive& drive) { return drive.axes.col(index(drive.direction) % 3); }
bool is_along_coordinate(const Drive& drive) {
  return drive.other == ground && drive.axes == Matrix3d::Identity();
}

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

// Offsets in the 12 coordinates of the two bodies: (displacement, spin) of the first, then of the
// second.
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

// Rotation: with b the axis on `other`, c that on `body`, both as they now are, the gradient of the
// stroke is W = (b + c)/(1 + b·c), and its second derivative −½ (W Vᵀ + V Wᵀ), V = c×b/(1 + b·c).
template <class S>
struct Bisector {
  S size;  ///< 1 + b·c
  Vector3<S> W, V;
};
template <class S>
Bisector<S> bisector(const Vector3<S>& b, const Vector3<S>& c) {
  const S size = S(1) + b.dot(c);
  return {size, (b + c) / size, c.cross(b) / size};
}

// The stroke is the angle of (cosine, sine), of the relative rotation Q about a and, by parts, e.
template <class S>
S sine(const Vector3<S>& a, const Matrix3<S>& Q) {
  return 0.5 *
         (a[0] * (Q(2, 1) - Q(1, 2)) + a[1] * (Q(0, 2) - Q(2, 0)) + a[2] * (Q(1, 0) - Q(0, 1)));
}
template <class S>
S cosine(const Vector3<S>& a, const Vector3<S>& e, const Matrix3<S>& Q) {
  return 0.5 * (a.dot(e) * (Q(0, 0) + Q(1, 1) + Q(2, 2)) - a.dot(times<S>(Q, e)));
}
double angle(double sine, double cosine) { return std::atan2(sine, cosine); }
// Angle along the path from its sine and cosine: the tangent of the part beyond the start is its
// angle up to s².
Jet angle(const Jet& sine, const Jet& cosine) {
  const double y = sine.c[0], x = cosine.c[0];
  return std::atan2(y, x) + (sine * x - cosine * y) / (cosine * x + sine * y);
}

// The stroke's gradient W on both spins, which do not commute, and H between them.
template <class S>
void add_spins(DriveStroke<S>& s, const Vector3<S>& W, const Matrix3<S>& H) {
  for (int i = 0; i < 3; ++i) {
    s.gradient[spin + i] += W[i];
    s.gradient[other_spin + i] -= W[i];
    for (int j = 0; j < 3; ++j) {
      s.curvature(spin + i, spin + j) += H(i, j);
      s.curvature(other_spin + i, other_spin + j) += H(i, j);
      s.curvature(spin + i, other_spin + j) -= H(i, j);
      s.curvature(other_spin + i, spin + j) -= H(i, j);
    }
  }
  add_transposed<S>(s.curvature, other_spin, spin, Matrix3<S>(0.5 * hat(W)));
}

}  // namespace

std::optional<int> coordinate_of(const Drive& drive) {
  if (is_rotation(drive.direction) || drive.axes_change || !is_along_coordinate(drive))
    return std::nullopt;
  return 6 * drive.body + index(drive.direction);
}

std::vector<int> conditional_drives(const Mechanism& mechanism) {
  std::vector<int> list;
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k)
    if (!coordinate_of(mechanism.drives[k])) list.push_back(static_cast<int>(k));
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

std::array<bool, 6> prescribed_directions(const Mechanism& mechanism,
                                          const std::bitset<6>& drives) {
  std::array<bool, 6> prescribed{};
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k)
    if (const auto d = end_effector_direction(mechanism, mechanism.drives[k]); d && drives[k])
      prescribed[index(*d)] = true;
  return prescribed;
}

template <class S>
DriveStroke<S> drive_stroke(const Drive& drive, const JointBodyOf<S>& body,
                            const JointBodyOf<S>& other) {
  DriveStroke<S> s;
  const Vector3d own = axis_of(drive);
  const Vector3<S> a = constant<S>(own), axis = times<S>(other.rotation, a);
  if (!is_rotation(drive.direction)) {
    const Vector3<S> between = body.position - other.position;
    add_axis<S>(s, axis);
    add_apart<S>(s, axis, between);
    s.value -= S(own.dot(body.reference - other.reference));
    return s;
  }
  const Matrix3<S> Q = times<S>(Matrix3<S>(other.rotation.transpose()), body.rotation);
  s.value = angle(sine<S>(a, Q), cosine<S>(a, a, Q));
  const Bisector<S> at = bisector<S>(axis, times<S>(body.rotation, a));
  add_spins<S>(s, at.W, Matrix3<S>(-symmetric<S>(dyad(at.W, at.V))));
  return s;
}

template <class S>
DriveStroke<S> drive_stroke_rate(const StrokeState<S>& at, const StrokeState<S>& rate) {
  DriveStroke<S> s;
  const Vector3d own = axis_of(at.drive), own_rate = axis_of(rate.drive);
  const Vector3<S> a = constant<S>(own), da = constant<S>(own_rate);
  const Vector3<S> axis = times<S>(at.other.rotation, a),
                   moves = times<S>(rate.other.rotation, a) + times<S>(at.other.rotation, da);
  if (!is_rotation(at.drive.direction)) {
    const Vector3<S> between = at.body.position - at.other.position,
                     parts = rate.body.position - rate.other.position;
    add_axis<S>(s, moves);
    add_apart<S>(s, moves, between);
    add_apart<S>(s, axis, parts);
    s.value -= S(own_rate.dot(at.body.reference - at.other.reference) +
                 own.dot(rate.body.reference - rate.other.reference));
    return s;
  }
  const Matrix3<S> back = at.other.rotation.transpose(), Q = times<S>(back, at.body.rotation),
                   dQ = times<S>(Matrix3<S>(rate.other.rotation.transpose()), at.body.rotation) +
                        times<S>(back, rate.body.rotation);
  const S y = sine<S>(a, Q), x = cosine<S>(a, a, Q), dy = sine<S>(da, Q) + sine<S>(a, dQ),
          dx = cosine<S>(da, a, Q) + cosine<S>(a, da, Q) + cosine<S>(a, a, dQ);
  s.value = (x * dy - y * dx) / (x * x + y * y);
  const Vector3<S> c = times<S>(at.body.rotation, a),
                   dc = times<S>(rate.body.rotation, a) + times<S>(at.body.rotation, da);
  const Bisector<S> here = bisector<S>(axis, c);
  const S dsize = moves.dot(c) + axis.dot(dc);
  const Vector3<S> dW = (moves + dc - dsize * here.W) / here.size,
                   dV = (dc.cross(axis) + c.cross(moves) - dsize * here.V) / here.size;
  add_spins<S>(s, dW, Matrix3<S>(-symmetric<S>(dyad(dW, here.V) + dyad(here.W, dV))));
  return s;
}

template DriveStroke<double> drive_stroke(const Drive&, const JointBody&, const JointBody&);
template DriveStroke<Jet> drive_stroke(const Drive&, const JointBodyOf<Jet>&,
                                       const JointBodyOf<Jet>&);
template DriveStroke<double> drive_stroke_rate(const StrokeState<double>&,
                                               const StrokeState<double>&);
template DriveStroke<Jet> drive_stroke_rate(const StrokeState<Jet>&, const StrokeState<Jet>&);

Check check_drives(const Mechanism& mechanism) {
  const int bodies = static_cast<int>(mechanism.bodies.size());
  if (mechanism.drives.size() > 6) return Because("there are more than six drives");
  for (std::size_t k = 0; k < mechanism.drives.size(); ++k) {
    const Drive& drive = mechanism.drives[k];
    const std::string who = drive.name.empty() ? "the drive" : "drive " + drive.name;
    const auto known = [&](int body) { return body >= 0 && body < bodies; };
    if (!known(drive.body)) return Because(fmt::format("{}: there is no body {}", who, drive.body));
    if (drive.other != ground && !known(drive.other))
      return Because(fmt::format("{}: there is no body {}", who, drive.other));
    if (drive.body == drive.other) return Because(who + ": it drives a body against itself");
    if (!((drive.axes.transpose() * drive.axes - Matrix3d::Identity()).norm() < 1e-9) ||
        drive.axes.determinant() < 0)
      return Because(who + ": its axes must be orthonormal and right-handed");
    for (std::size_t j = 0; j < k; ++j)
      if (mechanism.drives.size() > 1 && mechanism.drives[j].name == drive.name)
        return Because(fmt::format("two drives have the name {}", drive.name));
    if (is_along_coordinate(drive) && mechanism.bodies[drive.body].held[index(drive.direction)])
      return Because(drive.body == mechanism.end_effector
                         ? "the end-effector cannot move in the direction of the drive"
                         : mechanism.bodies[drive.body].name +
                               " cannot move in the direction of the drive");
  }
  return {};
}

}  // namespace flexopt
