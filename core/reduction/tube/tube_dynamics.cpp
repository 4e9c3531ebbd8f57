#include "core/reduction/tube/tube_dynamics.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "core/math/decompositions.hpp"

namespace flexopt {
namespace {

constexpr int P = TubeDynamics::amplitudes, R = TubeDynamics::rates;
using Square = Eigen::Matrix<double, P, P>;
using Flat = Eigen::Matrix<double, 3, P>;
using Six = Eigen::Matrix<double, P, 6>;
using RateMatrix = Eigen::Matrix<double, R, R>;
using RateSigns = Eigen::Matrix<double, R, 1>;

enum Part { k_part, G_part, F_part, g_part, mass_part };

// Taylor coefficients along the ray that a monomial off it takes from each end, for a total degree
// of 2 or, as a check of that, of 1.
constexpr int hermite_order(int degree, int total) { return total + 1 - degree; }

// A monomial off the ray, (τ, φ, N, M1, M2).
struct Across {
  std::array<int, 5> power{};
  int degree = 0;
  int variable[2] = {-1, -1};  ///< its factors

  bool even() const { return (power[1] + power[3] + power[4]) % 2 == 0; }
  int columns(int total) const { return 2 * hermite_order(degree, total); }
};

// Those of one parity in (φ, M1, M2), by ascending degree.
std::vector<Across> across_monomials(bool even) {
  const MonomialTable& table = monomials<6, 2>();
  std::vector<Across> found;
  for (int m = 0; m < table.size(); ++m) {
    const auto e = table.exponents(m);
    if (e[0] != 0) continue;
    Across a;
    a.degree = table.degree(m);
    int factors = 0;
    for (int v = 0; v < 5; ++v) {
      a.power[v] = e[1 + v];
      for (int p = 0; p < e[1 + v]; ++p) a.variable[factors++] = v;
    }
    if (a.even() == even) found.push_back(a);
  }
  return found;
}
const std::vector<Across>& basis(bool even) {
  static const std::vector<Across> both[2] = {across_monomials(false), across_monomials(true)};
  return both[even];
}
int basis_size(bool even, int total) {
  int n = 0;
  for (const Across& a : basis(even)) n += a.columns(total);
  return n;
}
constexpr int most_functions = 32;

// Powers of t of the polynomial that takes q Taylor coefficients (of powers of t) from each end.
void hermite_powers(int q, const double* a, const double* b, double* c) {
  const double d = b[0] - a[0];
  if (q == 1) {
    c[0] = a[0];
    c[1] = d;
  } else if (q == 2) {
    c[0] = a[0];
    c[1] = a[1];
    c[2] = 3 * d - 2 * a[1] - b[1];
    c[3] = a[1] + b[1] - 2 * d;
  } else {
    c[0] = a[0];
    c[1] = a[1];
    c[2] = a[2];
    c[3] = 10 * d - 6 * a[1] - 4 * b[1] - 3 * a[2] + b[2];
    c[4] = -15 * d + 8 * a[1] + 7 * b[1] + 3 * a[2] - 2 * b[2];
    c[5] = 6 * d - 3 * (a[1] + b[1]) - a[2] + b[2];
  }
}

// A = L Lᵀ in place, the lower triangle; false where A is not positive.
bool factorise(Square& A) {
  for (int j = 0; j < P; ++j) {
    for (int k = 0; k < j; ++k) A.col(j).tail(P - j) -= A(j, k) * A.col(k).tail(P - j);
    if (!(A(j, j) > 0)) return false;
    A.col(j).tail(P - j) /= std::sqrt(A(j, j));
  }
  return true;
}
// L⁻¹ B, rows of B at once.
template <class B>
void solve_lower(const Square& L, B& X) {
  for (int j = 0; j < P; ++j) {
    X.row(j) /= L(j, j);
    for (int i = j + 1; i < P; ++i) X.row(i) -= L(i, j) * X.row(j);
  }
}
template <class B>
void solve_upper(const Square& L, B& X) {
  for (int j = P - 1; j >= 0; --j) {
    X.row(j) /= L(j, j);
    for (int i = 0; i < j; ++i) X.row(i) -= L(j, i) * X.row(j);
  }
}

bool positive(const Matrix3d& A) {
  return A(0, 0) > 0 && A(0, 0) * A(1, 1) > A(1, 0) * A(0, 1) && A.determinant() > 0;
}

constexpr std::array<double, 12> across_parity{1, -1, 1, -1, 1, -1, 1, 1, -1, 1, -1, -1};
constexpr std::array<double, 12> thickness_parity{1, 1, -1, -1, -1, 1, -1, -1, -1, 1, 1, 1};

}  // namespace

struct TubeDynamics::Entries {
  Square k = Square::Zero();
  Flat G = Flat::Zero();
  Eigen::Matrix<double, P, 3> g = Eigen::Matrix<double, P, 3>::Zero();
  Matrix3d F = Matrix3d::Zero();
  RateMatrix mass = RateMatrix::Zero();

  void put(const Slot& s, double x) {
    switch (s.matrix) {
      case k_part:
        k(s.row, s.column) = k(s.column, s.row) = x;
        break;
      case G_part:
        G(s.row, s.column) = x;
        break;
      case F_part:
        F(s.row, s.column) = F(s.column, s.row) = x;
        break;
      case g_part:
        g(s.row, s.column) = x;
        break;
      default:
        mass(s.row, s.column) = mass(s.column, s.row) = x;
    }
  }
  // Internal stiffness, the stiff deformations held: a sum of positive parts.
  bool stiffness(Square& K, Flat& X) const {
    if (!positive(F)) return false;
    X.noalias() = F.inverse() * G;
    K = k;
    K.noalias() += G.transpose() * X;
    return true;
  }
};

// A place among the tables, mirrored to σ ≥ 0.
struct TubeDynamics::Local {
  bool mirrored = false;
  int interval = 0;
  double t = 0;
  double z[5];
};

TubeDynamics::TubeDynamics(const ChordLeaf& leaf, const Eigen::Matrix2d& ray, double force_centre)
    : ray_(ray), force_centre_(force_centre), loads_(internal_loads(leaf)) {
  make_slots();
}

void TubeDynamics::make_slots() {
  RateSigns parity;
  for (int i = 0; i < R; ++i) parity[i] = i < 12 ? across_parity[i] : loads_.across[i - 12];
  const auto add = [&](Part part, int i, int j, double sign) {
    (sign > 0 ? even_ : odd_).push_back({part, i, j});
  };
  for (int i = 0; i < P; ++i)
    for (int j = 0; j <= i; ++j) add(k_part, i, j, parity[12 + i] * parity[12 + j]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < P; ++j) add(G_part, i, j, parity[9 + i] * parity[12 + j]);
    for (int j = 0; j <= i; ++j) add(F_part, i, j, parity[9 + i] * parity[9 + j]);
  }
  even_stiffness_ = static_cast<int>(even_.size());
  odd_stiffness_ = static_cast<int>(odd_.size());
  for (int i = 0; i < P; ++i)
    for (int j = 0; j < 3; ++j) add(g_part, i, j, parity[12 + i] * parity[6 + j]);
  for (int i = 0; i < R; ++i)
    for (int j = 0; j <= i; ++j) add(mass_part, i, j, parity[i] * parity[j]);
}

VectorXd TubeDynamics::mirror_signs() const {
  VectorXd signs(R);
  for (int i = 0; i < R; ++i) signs[i] = i < 12 ? thickness_parity[i] : loads_.normal[i - 12];
  return signs;
}

TubeDynamics::Node TubeDynamics::make_node(const DynamicsExpansion& e, double sigma) const {
  const MatrixPolynomial* parts[] = {&e.k, &e.G, &e.F, &e.g, &e.mass};
  const int m = e.k.size();
  Node node{sigma, MatrixXd(even_.size(), m), MatrixXd(odd_.size(), m), {}, 0};
  for (const bool even : {true, false}) {
    const std::vector<Slot>& slots = even ? even_ : odd_;
    MatrixXd& table = even ? node.even : node.odd;
    for (std::size_t s = 0; s < slots.size(); ++s)
      for (int k = 0; k < m; ++k)
        table(static_cast<Eigen::Index>(s), k) =
            (*parts[slots[s].matrix])[k](slots[s].row, slots[s].column);
  }
  node.stations.resize(e.stations.rows() * e.stations.cols(), 2);
  for (int k = 0; k < 2; ++k) node.stations.col(k) = e.stations[k].reshaped();

  // the fifth internal frequency at the bent state itself
  const MatrixXd X = Lu(e.F[0]).solve(e.G[0]);
  MatrixXd T = MatrixXd::Zero(R, P);
  T.bottomRows(P).setIdentity();
  T.middleRows<3>(9) = -X;
  const SymmetricEigen held(e.k[0] + e.G[0].transpose() * X, T.transpose() * e.mass[0] * T);
  node.reach = held.eigenvalues()[4];
  return node;
}

namespace {

// Entries × basis functions of the first `rows` entries between two bent states `width` apart.
MatrixXd joined(const MatrixXd& left, const MatrixXd& right, Eigen::Index rows, double width,
                bool even, int total) {
  const MonomialTable& table = monomials<6, 2>();
  MatrixXd C(rows, basis_size(even, total));
  int column = 0;
  for (const Across& m : basis(even)) {
    const int q = hermite_order(m.degree, total);
    if (q == 0) continue;
    int index[3];
    for (int j = 0; j < q; ++j)
      index[j] = table.index(
          std::array<int, 6>{j, m.power[0], m.power[1], m.power[2], m.power[3], m.power[4]});
    for (Eigen::Index r = 0; r < rows; ++r) {
      double at_a[3], at_b[3], c[6], scale = 1;
      for (int j = 0; j < q; ++j, scale *= width) {
        at_a[j] = scale * left(r, index[j]);
        at_b[j] = scale * right(r, index[j]);
      }
      hermite_powers(q, at_a, at_b, c);
      for (int j = 0; j < 2 * q; ++j) C(r, column + j) = c[j];
    }
    column += m.columns(total);
  }
  return C;
}

}  // namespace

TubeDynamics::Interval TubeDynamics::make_interval(const Node& a, const Node& b) const {
  const double width = b.sigma - a.sigma;
  return {a.sigma,
          width,
          joined(a.even, b.even, a.even.rows(), width, true, 2),
          joined(a.odd, b.odd, a.odd.rows(), width, false, 2),
          joined(a.even, b.even, even_stiffness_, width, true, 1),
          joined(a.odd, b.odd, odd_stiffness_, width, false, 1)};
}

void TubeDynamics::add(const ChordLeaf& leaf, double sigma) {
  assert(nodes_.empty() ? sigma == 0 : sigma > nodes_.back().sigma);
  nodes_.push_back(make_node(expand_dynamics(leaf, ray_, loads_), sigma));
  if (nodes_.size() > 1) intervals_.push_back(make_interval(nodes_.end()[-2], nodes_.back()));
}

TubeDynamics::Local TubeDynamics::locate(const Place& place) const {
  Local at;
  at.mirrored = place.sigma < 0;
  const double sign = at.mirrored ? -1 : 1, sigma = sign * place.sigma;
  const int last = static_cast<int>(intervals_.size()) - 1;
  while (at.interval < last && sigma > nodes_[at.interval + 1].sigma) ++at.interval;
  const Interval& interval = intervals_[at.interval];
  at.t = (sigma - interval.start) / interval.width;
  at.z[0] = sign * place.tau;
  at.z[1] = sign * place.twist;
  at.z[2] = place.f[0] - force_centre_;
  at.z[3] = place.f[1];
  at.z[4] = place.f[2];
  return at;
}

// All entries to a total degree of 2, or those of the stiffness to 1 or 2.
void TubeDynamics::read(const Local& at, bool all, int total, Entries& entries) const {
  const Interval& interval = intervals_[at.interval];
  for (const bool even : {true, false}) {
    alignas(64) std::array<double, most_functions> w;
    int n = 0;
    for (const Across& m : basis(even)) {
      double x = 1;
      for (int f = 0; f < m.degree; ++f) x *= at.z[m.variable[f]];
      for (int j = 0; j < m.columns(total); ++j, x *= at.t) w[n++] = x;
    }
    const MatrixXd& C = total == 2 ? (even ? interval.even : interval.odd)
                                   : (even ? interval.lower_even : interval.lower_odd);
    const std::vector<Slot>& slots = even ? even_ : odd_;
    const Eigen::Index rows = all ? C.rows() : even ? even_stiffness_ : odd_stiffness_;
    VectorXd values(rows);
    values.noalias() = C.topRows(rows) * Eigen::Map<const VectorXd>(w.data(), n);
    for (Eigen::Index r = 0; r < rows; ++r)
      entries.put(slots[static_cast<std::size_t>(r)], values[r]);
  }
}

TubeDynamics::Answer TubeDynamics::evaluate(const Place& place) const {
  assert(!intervals_.empty());
  const Local at = locate(place);
  Entries e;
  read(at, true, 2, e);
  Answer answer;
  Flat X;
  if (!e.stiffness(answer.stiffness, X) || !factorise(e.k)) {
    answer.reason = "the internal stiffness of the tables is not positive";
    return answer;
  }
  // a' = S (s', f') + eta', the field's f' less X eta'
  Six S;
  S << e.g, e.G.transpose();
  solve_lower(e.k, S);
  solve_upper(e.k, S);
  RateMatrix MT = e.mass;
  MT.template middleCols<6>(6).noalias() += e.mass.template rightCols<P>() * S;
  MT.template rightCols<P>().noalias() -= e.mass.template middleCols<3>(9) * X;
  answer.mass = MT;
  answer.mass.template middleRows<6>(6).noalias() += S.transpose() * MT.template bottomRows<P>();
  answer.mass.template bottomRows<P>().noalias() -= X.transpose() * MT.template middleRows<3>(9);
  if (at.mirrored) {
    const RateSigns signs = mirror_signs();
    const auto internal = signs.template tail<P>();
    answer.stiffness = (internal.asDiagonal() * answer.stiffness * internal.asDiagonal()).eval();
    answer.mass = (signs.asDiagonal() * answer.mass * signs.asDiagonal()).eval();
  }
  const auto& nodes = nodes_.begin() + at.interval;
  answer.reach = std::min(nodes[0].reach, nodes[1].reach);
  return answer;
}

double TubeDynamics::change(const Place& place) const {
  const Local at = locate(place);
  Entries e, lower;
  read(at, false, 2, e);
  read(at, false, 1, lower);
  Square K, less;
  Flat X;
  constexpr double endless = 1e9;
  if (!e.stiffness(K, X) || !lower.stiffness(less, X)) return endless;
  less -= K;
  if (!factorise(K)) return endless;
  solve_lower(K, less);
  less.transposeInPlace();
  solve_lower(K, less);
  return less.norm();
}

MatrixXd TubeDynamics::stations(const Place& place) const {
  const Local at = locate(place);
  const Node &a = nodes_[at.interval], &b = nodes_[at.interval + 1];
  const double h = b.sigma - a.sigma, t = at.t, r = 1 - t;
  const Eigen::Index rows = a.stations.rows() / (R - 3);
  MatrixXd all = MatrixXd::Zero(rows, R);
  for (Eigen::Index i = 0; i < rows; i += 6) all.block<3, 3>(i, 0).setIdentity();
  all.rightCols(R - 3) =
      (r * r * (1 + 2 * t) * a.stations.col(0) + h * t * r * r * a.stations.col(1) +
       t * t * (1 + 2 * r) * b.stations.col(0) - h * r * t * t * b.stations.col(1))
          .reshaped(rows, R - 3);
  if (!at.mirrored) return all;
  for (Eigen::Index i = 2; i < rows; i += 3) all.row(i) *= -1;
  return all * mirror_signs().asDiagonal();
}

}  // namespace flexopt
