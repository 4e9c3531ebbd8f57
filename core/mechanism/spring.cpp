#include "core/mechanism/spring.hpp"

#include <array>
#include <cmath>

#include "core/mechanism/force_line.hpp"

namespace flexopt {
namespace {

// Arrays of any scalar: matrices of Eigen would compile their products anew for each of these.
template <class T>
using V3 = std::array<T, 3>;
template <class T>
using M3 = std::array<V3<T>, 3>;

template <class A, class B>
auto dot(const V3<A>& a, const V3<B>& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
template <class T>
V3<T> cross(const V3<T>& a, const V3<T>& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
template <class T>
V3<T> operator+(const V3<T>& a, const V3<T>& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
template <class T>
V3<T> operator-(const V3<T>& a, const V3<T>& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
template <class T>
V3<T> operator*(const T& a, const V3<T>& b) {
  return {a * b[0], a * b[1], a * b[2]};
}
template <class T>
V3<T> times(const M3<T>& A, const V3<T>& b) {
  return {dot(A[0], b), dot(A[1], b), dot(A[2], b)};
}
template <class T>
V3<T> transposed_times(const M3<T>& A, const V3<T>& b) {
  return b[0] * A[0] + b[1] * A[1] + b[2] * A[2];
}

// A mixed second derivative: the rate, along a second motion, of a number with its rate along a
// first one.
template <class T>
using Mixed = Rate<Rate<T>>;

// A body whose numbers are of any kind.
template <class T>
struct Place {
  V3<T> position, reference;
  M3<T> rotation;
};
template <class T>
struct SpringNumbers {
  V3<T> place, other_place;
  T stiffness{}, free_length{};
  std::array<std::array<T, 6>, 6> matrix{};  ///< symmetric part
};

// The one reading of a number for values, the other for values with rates.
template <class S>
struct Value {
  using T = S;
  T operator()(const S& x, const S&) const { return x; }
};
template <class S>
struct ValueAndRate {
  using T = Rate<S>;
  T operator()(const S& x, const S& dx) const { return {x, dx}; }
};

template <class S, class Read>
Place<typename Read::T> read(const JointBodyOf<S>& at, const JointBodyOf<S>& rate,
                             const Read& number) {
  Place<typename Read::T> p;
  for (int i = 0; i < 3; ++i) {
    p.position[i] = number(at.position[i], rate.position[i]);
    p.reference[i] = number(S(at.reference[i]), S(rate.reference[i]));
    for (int j = 0; j < 3; ++j) p.rotation[i][j] = number(at.rotation(i, j), rate.rotation(i, j));
  }
  return p;
}
template <class S, class Read>
SpringNumbers<typename Read::T> read(const Spring& at, const Spring& rate, const Read& number) {
  SpringNumbers<typename Read::T> s;
  const bool bushing = at.matrix.has_value();
  for (int i = 0; i < 3; ++i) {
    s.place[i] = number(S(at.place[i]), S(rate.place[i]));
    s.other_place[i] = bushing ? s.place[i] : number(S(at.other_place[i]), S(rate.other_place[i]));
  }
  if (bushing) {
    for (int i = 0; i < 6; ++i)
      for (int j = 0; j < 6; ++j)
        s.matrix[i][j] = number(S(0.5 * ((*at.matrix)(i, j) + (*at.matrix)(j, i))),
                                S(0.5 * ((*rate.matrix)(i, j) + (*rate.matrix)(j, i))));
  } else {
    s.stiffness = number(S(at.stiffness), S(rate.stiffness));
    s.free_length = number(S(at.free_length), S(rate.free_length));
  }
  return s;
}

// Energy, force and tangent in numbers of any kind.
template <class T>
struct Answers {
  T energy{};
  std::array<T, 12> force{};
  std::array<std::array<T, 12>, 12> tangent{};
};

// Arms from the reference points to the ends, and the end on `body` less that on `other`.
template <class T>
struct Ends {
  V3<T> arm, other_arm, apart;
};
template <class T>
Ends<T> ends_of(const SpringNumbers<T>& s, const Place<T>& body, const Place<T>& other) {
  Ends<T> e{times(body.rotation, s.place - body.reference),
            times(other.rotation, s.other_place - other.reference),
            {}};
  e.apart = body.position + e.arm - other.position - e.other_arm;
  return e;
}

// Unit motion along one of the twelve coordinates: which vector of which body.
template <class T>
struct Motion {
  V3<T> u{}, turn{}, other_u{}, other_turn{};
  explicit Motion(int k) { (k < 3 ? u : k < 6 ? turn : k < 9 ? other_u : other_turn)[k % 3] = 1.0; }
  /// First derivative of Ends::apart.
  V3<T> moves(const Ends<T>& e) const {
    return u + cross(turn, e.arm) - other_u - cross(other_turn, e.other_arm);
  }
};

// f · (x × (y × o)), symmetric in x and y.
template <class T>
T turning(const V3<T>& f, const V3<T>& x, const V3<T>& y, const V3<T>& o) {
  return 0.5 * (dot(f, x) * dot(y, o) + dot(f, y) * dot(x, o)) - dot(f, o) * dot(x, y);
}

template <class T>
Pull<T> linear_pull(const SpringNumbers<T>& s, const T& length) {
  const T stretch = length - s.free_length;
  return {0.5 * s.stiffness * stretch * stretch, s.stiffness * stretch, s.stiffness};
}

// The force f/l d between the ends and its derivative f/l 1 + (f′ − f/l)/l² d dᵀ.
template <class T, class PullAt>
Answers<T> point_spring(const PullAt& pull_at, const Ends<T>& e) {
  using std::sqrt;
  const V3<T>& d = e.apart;
  const T length = sqrt(dot(d, d));
  const Pull<T> pull = pull_at(length);
  const T share = pull.force / length, along = (pull.stiffness - share) / (length * length);
  const V3<T> force = share * d;
  Answers<T> r;
  r.energy = pull.energy;
  for (int i = 0; i < 12; ++i) {
    const Motion<T> y(i);
    const V3<T> v = y.moves(e);
    r.force[i] = dot(force, v);
    for (int j = 0; j <= i; ++j) {
      const Motion<T> z(j);
      const V3<T> w = z.moves(e);
      r.tangent[i][j] = r.tangent[j][i] = share * dot(v, w) + along * dot(d, v) * dot(d, w) +
                                          turning(force, y.turn, z.turn, e.arm) -
                                          turning(force, y.other_turn, z.other_turn, e.other_arm);
    }
  }
  return r;
}

// Energy of a bushing whose places are d apart and whose body is turned by Q, seen from `other`.
// The rotation vector is φ = 2ⁿ⁺¹ atan(t)/t v/w, t = |v|/w, with (w, v) the quaternion of Q after n
// halvings of the rotation; the first of these is the rotation of the axes. Only arithmetic and
// roots are used, so that T may be any kind of number.
template <class T>
T bushing_energy(const std::array<std::array<T, 6>, 6>& K, const V3<T>& d, const M3<T>& Q) {
  using std::sqrt;
  T w = 0.5 * sqrt(1.0 + Q[0][0] + Q[1][1] + Q[2][2]);
  const T by = 0.25 / w;
  V3<T> v{by * (Q[2][1] - Q[1][2]), by * (Q[0][2] - Q[2][0]), by * (Q[1][0] - Q[0][1])};
  std::array<T, 6> e;
  for (int n = 0; n < 3; ++n) {
    w = sqrt(0.5 * (1.0 + w));
    v = (0.5 / w) * v;
    if (n > 0) continue;
    const V3<T> vd = cross(v, d), vvd = cross(v, vd);  // d in the turned axes
    for (int i = 0; i < 3; ++i) e[i] = d[i] - 2.0 * (w * vd[i]) + 2.0 * vvd[i];
  }
  const T square = dot(v, v) / (w * w);  // tan²(π/16) = 0.04 at most
  T series = 1.0 / 27;
  for (int k = 12; k >= 0; --k) series = 1.0 / (2 * k + 1) - square * series;
  const T factor = 16.0 * series / w;
  for (int i = 0; i < 3; ++i) e[3 + i] = factor * v[i];
  T energy = 0.0;
  for (int i = 0; i < 6; ++i) {
    T row = 0.5 * K[i][i] * e[i];
    for (int j = 0; j < i; ++j) row = row + K[i][j] * e[j];
    energy = energy + row * e[i];
  }
  return energy;
}

// Derivatives of the relative displacement and rotation with respect to (displacement of the place,
// spin) of `body`, in global axes.
template <class T>
struct RelativeAnswers {
  T energy{};
  V3<T> force{}, moment{};
  std::array<std::array<T, 6>, 6> tangent{};
};
template <class T>
RelativeAnswers<T> relative(const SpringNumbers<T>& s, const V3<T>& apart, const Place<T>& body,
                            const Place<T>& other) {
  const V3<T> d = transposed_times(other.rotation, apart);
  M3<T> columns;  // of the turn seen from `other`
  for (int j = 0; j < 3; ++j)
    columns[j] = transposed_times(
        other.rotation, V3<T>{body.rotation[0][j], body.rotation[1][j], body.rotation[2][j]});
  std::array<std::array<Mixed<T>, 6>, 6> K;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < 6; ++j) K[i][j] = {{s.matrix[i][j], 0.0}, 0.0};
  RelativeAnswers<T> r;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j <= i; ++j) {
      const V3<T> none{T(0.0), T(0.0), T(0.0)},
          &ei = other.rotation[i % 3],
          &ej = other.rotation[j % 3];  // global unit vectors seen from `other`
      const V3<T>&ui = i < 3 ? ei : none, &uj = j < 3 ? ej : none, &wi = i < 3 ? none : ei,
            &wj = j < 3 ? none : ej;
      V3<Mixed<T>> gap;
      for (int k = 0; k < 3; ++k) gap[k] = {{d[k], ui[k]}, {uj[k], 0.0}};
      M3<Mixed<T>> Q;
      for (int c = 0; c < 3; ++c) {
        const V3<T>& q = columns[c];
        const V3<T> first = cross(wi, q), second = cross(wj, q),
                    both = cross(wi, second) + cross(wj, first);
        for (int k = 0; k < 3; ++k) Q[k][c] = {{q[k], first[k]}, {second[k], 0.5 * both[k]}};
      }
      const Mixed<T> energy = bushing_energy(K, gap, Q);
      r.tangent[i][j] = r.tangent[j][i] = energy.rate.rate;
      if (j > 0) continue;
      (i < 3 ? r.force : r.moment)[i % 3] = energy.value.rate;
      r.energy = energy.value.value;
    }
  return r;
}

// The energy does not change when both bodies turn by −ω of `other`. So motions y of both are the
// motion z = (v − ω×d, spin of `body` − ω) of `body` alone, v of Ends::apart, to second order with
//     ½ s − ω×v + ½ ω×(ω×d),   −½ ω×(spin of `body`)
// where s is what the spins make of the arms.
template <class T>
Answers<T> bushing(const SpringNumbers<T>& s, const Ends<T>& e, const Place<T>& body,
                   const Place<T>& other) {
  const RelativeAnswers<T> own = relative(s, e.apart, body, other);
  Answers<T> r;
  r.energy = own.energy;
  std::array<std::array<T, 6>, 12> z, Hz;
  for (int i = 0; i < 12; ++i) {
    const Motion<T> y(i);
    const V3<T> v = y.moves(e) - cross(y.other_turn, e.apart), w = y.turn - y.other_turn;
    for (int k = 0; k < 3; ++k) z[i][k] = v[k], z[i][3 + k] = w[k];
    r.force[i] = dot(own.force, v) + dot(own.moment, w);
    for (int k = 0; k < 6; ++k) {
      Hz[i][k] = 0.0;
      for (int l = 0; l < 6; ++l) Hz[i][k] = Hz[i][k] + own.tangent[k][l] * z[i][l];
    }
  }
  const V3<T>&f = own.force, &m = own.moment;
  for (int i = 0; i < 12; ++i)
    for (int j = 0; j <= i; ++j) {
      const Motion<T> y(i), x(j);
      T k = turning(f, y.turn, x.turn, e.arm) -
            turning(f, y.other_turn, x.other_turn, e.other_arm) +
            turning(f, y.other_turn, x.other_turn, e.apart) -
            dot(f, cross(y.other_turn, x.moves(e)) + cross(x.other_turn, y.moves(e))) -
            0.5 * dot(m, cross(y.other_turn, x.turn) + cross(x.other_turn, y.turn));
      for (int l = 0; l < 6; ++l) k = k + z[j][l] * Hz[i][l];
      r.tangent[i][j] = r.tangent[j][i] = k;
    }
  return r;
}

template <class S, class Read>
Answers<typename Read::T> answers(const SpringState<S>& at, const SpringState<S>& rate,
                                  const Read& number) {
  const auto s = read<S>(*at.spring, *rate.spring, number);
  const auto body = read(at.body, rate.body, number), other = read(at.other, rate.other, number);
  const auto e = ends_of(s, body, other);
  using T = typename Read::T;
  if (at.spring->matrix) return bushing(s, e, body, other);
  if (at.spring->line.empty())
    return point_spring([&](const T& length) { return linear_pull(s, length); }, e);
  const auto point = [&](int i) {
    const auto k = static_cast<std::size_t>(i);
    const std::array<double, 2>&x = at.spring->line[k], &dx = rate.spring->line[k];
    return std::array<T, 2>{number(S(x[0]), S(dx[0])), number(S(x[1]), S(dx[1]))};
  };
  const ForceLine<T, decltype(point)> line{point, static_cast<int>(at.spring->line.size())};
  return point_spring([&](const T& length) { return line.at(length); }, e);
}

template <class S, class T, class Of>
SpringForcesOf<S> collected(const Answers<T>& a, const Of& of) {
  SpringForcesOf<S> r;
  r.energy = of(a.energy);
  for (int i = 0; i < 12; ++i) {
    r.force[i] = of(a.force[i]);
    for (int j = 0; j < 12; ++j) r.tangent(i, j) = of(a.tangent[i][j]);
  }
  return r;
}

}  // namespace

template <class S>
SpringForcesOf<S> spring_forces(const Spring& spring, const JointBodyOf<S>& body,
                                const JointBodyOf<S>& other) {
  const SpringState<S> state{&spring, body, other};
  return collected<S>(answers(state, state, Value<S>{}), [](const S& x) { return x; });
}

template <class S>
SpringForcesOf<S> spring_rates(const SpringState<S>& state, const SpringState<S>& rate) {
  return collected<S>(answers(state, rate, ValueAndRate<S>{}),
                      [](const Rate<S>& x) { return x.rate; });
}

template SpringForcesOf<double> spring_forces(const Spring&, const JointBodyOf<double>&,
                                              const JointBodyOf<double>&);
template SpringForcesOf<Jet> spring_forces(const Spring&, const JointBodyOf<Jet>&,
                                           const JointBodyOf<Jet>&);
template SpringForcesOf<double> spring_rates(const SpringState<double>&,
                                             const SpringState<double>&);
template SpringForcesOf<Jet> spring_rates(const SpringState<Jet>&, const SpringState<Jet>&);

double built_length(const Spring& spring) { return (spring.place - spring.other_place).norm(); }

double pull_at(const Spring& spring, double length) {
  if (spring.line.empty()) return spring.stiffness * (length - spring.free_length);
  const auto point = [&](int i) { return spring.line[static_cast<std::size_t>(i)]; };
  const ForceLine<double, decltype(point)> line{point, static_cast<int>(spring.line.size())};
  return line.at(length).force;
}

bool is_preloaded(const Spring& spring) {
  if (spring.matrix) return false;
  if (!spring.line.empty()) return pull_at(spring, built_length(spring)) != 0;
  const double built = built_length(spring);
  return spring.stiffness > 0 && std::abs(spring.free_length - built) > 1e-12 * built;
}

}  // namespace flexopt
