#include "core/reduction/tube/tube_dynamics.hpp"

#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <numbers>

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

// ---------------------------------------------------------------------------- layout

namespace {

struct Slot {
  int matrix, row, column;
};

// Where the entries of all tables stand: those that are even and odd in (φ, M1, M2); of each first
// those of the stiffness.
struct Layout {
  std::vector<Slot> even, odd;
  int even_stiffness = 0, odd_stiffness = 0;
  RateSigns mirror;  ///< of the rates, by the mirror of the thickness
};

Layout make_layout(const LoadParity& loads) {
  Layout layout;
  RateSigns across;
  for (int i = 0; i < R; ++i) {
    across[i] = i < 12 ? across_parity[i] : loads.across[i - 12];
    layout.mirror[i] = i < 12 ? thickness_parity[i] : loads.normal[i - 12];
  }
  const auto add = [&](Part part, int i, int j, double sign) {
    (sign > 0 ? layout.even : layout.odd).push_back({part, i, j});
  };
  for (int i = 0; i < P; ++i)
    for (int j = 0; j <= i; ++j) add(k_part, i, j, across[12 + i] * across[12 + j]);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < P; ++j) add(G_part, i, j, across[9 + i] * across[12 + j]);
    for (int j = 0; j <= i; ++j) add(F_part, i, j, across[9 + i] * across[9 + j]);
  }
  layout.even_stiffness = static_cast<int>(layout.even.size());
  layout.odd_stiffness = static_cast<int>(layout.odd.size());
  for (int i = 0; i < P; ++i)
    for (int j = 0; j < 3; ++j) add(g_part, i, j, across[12 + i] * across[6 + j]);
  for (int i = 0; i < R; ++i)
    for (int j = 0; j <= i; ++j) add(mass_part, i, j, across[i] * across[j]);
  return layout;
}

const Layout& layout() {
  static const Layout found = make_layout(load_parity());
  return found;
}

}  // namespace

namespace {

// To the amplitudes U⁻ᵀ a.
void change_amplitudes(DynamicsExpansion& e, const MatrixXd& U) {
  for (int m = 0; m < e.k.size(); ++m) {
    e.k[m] = (U * e.k[m] * U.transpose()).eval();
    e.G[m] = (e.G[m] * U.transpose()).eval();
    e.g[m] = (U * e.g[m]).eval();
    e.mass[m].rightCols(P) = (e.mass[m].rightCols(P) * U.transpose()).eval();
    e.mass[m].bottomRows(P) = (U * e.mass[m].bottomRows(P)).eval();
    e.stations[m].rightCols(P) = (e.stations[m].rightCols(P) * U.transpose()).eval();
  }
}

}  // namespace

DynamicsNode dynamics_node(const ChordLeaf& leaf, double sigma, const Eigen::Matrix2d& ray,
                           const InternalLoads& loads, MatrixXd& units) {
  DynamicsExpansion e = expand_dynamics(leaf, ray, loads);
  if (units.size() == 0)  // k = V Vᵀ, V upper: each amplitude beside those that came before it
    units = Cholesky(e.k[0].reverse()).solve_lower(MatrixXd::Identity(P, P)).reverse();
  change_amplitudes(e, units);
  const MatrixPolynomial* parts[] = {&e.k, &e.G, &e.F, &e.g, &e.mass};
  DynamicsNode node;
  node.table.sigma = sigma;
  const auto fill = [&](const std::vector<Slot>& slots, const auto& monomials, MatrixXd& table) {
    table.resize(static_cast<Eigen::Index>(slots.size()),
                 static_cast<Eigen::Index>(monomials.size()));
    for (std::size_t s = 0; s < slots.size(); ++s)
      for (std::size_t c = 0; c < monomials.size(); ++c)
        table(static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(c)) =
            (*parts[slots[s].matrix])[monomials[c].number](slots[s].row, slots[s].column);
  };
  fill(layout().even, even_monomials(), node.table.even);
  fill(layout().odd, odd_monomials(), node.table.odd);
  node.stations.resize(e.stations.rows() * e.stations.cols(), 2);
  for (int k = 0; k < 2; ++k) node.stations.col(k) = e.stations[k].reshaped();
  return node;
}

// ---------------------------------------------------------------------------- tables

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
  std::size_t interval = 0;
  double sigma = 0;
  std::array<double, 5> z;
};

DynamicsNode TubeDynamics::weights(const DynamicsNode& node, const PlateShape& shape,
                                   double along) {
  Entries e;
  for (std::size_t s = 0; s < layout().even.size(); ++s)
    e.put(layout().even[s], node.table.even(static_cast<Eigen::Index>(s), 0));
  const RateSigns m = e.mass.diagonal().cwiseSqrt();
  const Eigen::Matrix<double, P, 1> k = e.k.diagonal().cwiseSqrt();
  const Vector3d F = e.F.diagonal().cwiseSqrt();
  const auto unit = [&](const Slot& s) {
    switch (s.matrix) {
      case k_part:
        return k[s.row] * k[s.column];
      case G_part:
        return F[s.row] * k[s.column];
      case F_part:
        return F[s.row] * F[s.column];
      case g_part:
        return k[s.row] * k[s.row] * m[6 + s.column] / m[12 + s.row];
      default:
        return m[s.row] * m[s.column];
    }
  };
  // how far states are from the bent states and off the ray: [rad], a tenth of the buckling load
  const double N =
      0.4 * std::numbers::pi * std::numbers::pi * shape.width / tube_force_scale(shape)[0];
  const std::array<double, 5> away{0.05, 0.01, N, 1, 1};
  const auto fill = [&](const std::vector<Slot>& slots, const auto& monomials, MatrixXd& out) {
    out.resize(static_cast<Eigen::Index>(slots.size()),
               static_cast<Eigen::Index>(monomials.size()));
    for (std::size_t c = 0; c < monomials.size(); ++c) {
      double size = std::pow(along, monomials[c].along);
      for (int f = 0; f < monomials[c].off_ray; ++f) size *= away[monomials[c].variable[f]];
      for (std::size_t s = 0; s < slots.size(); ++s)
        out(static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(c)) = size / unit(slots[s]);
    }
  };
  DynamicsNode weights;
  weights.table.sigma = node.table.sigma;
  fill(layout().even, even_monomials(), weights.table.even);
  fill(layout().odd, odd_monomials(), weights.table.odd);
  const Eigen::Index rows = node.stations.rows() / (R - 3);
  weights.stations.resize(node.stations.rows(), 2);
  for (Eigen::Index j = 0; j < R - 3; ++j)
    weights.stations.middleRows(j * rows, rows).setConstant(std::sqrt(shape.width) / m[3 + j]);
  weights.stations.col(1) *= along;
  return weights;
}

std::array<int, 2> TubeDynamics::entries() {
  return {static_cast<int>(layout().even.size()), static_cast<int>(layout().odd.size())};
}

void TubeDynamics::add(DynamicsNode node) {
  assert(nodes_.empty() ? node.table.sigma == 0 : node.table.sigma > nodes_.back().table.sigma);
  // the highest internal frequency that the loads tell well, at the bent state itself
  const std::vector<Slot>& slots = layout().even;  // the others vanish there
  Entries e;
  for (std::size_t s = 0; s < slots.size(); ++s)
    e.put(slots[s], node.table.even(static_cast<Eigen::Index>(s), 0));
  Square K;
  Flat X;
  double reach = 0;
  if (e.stiffness(K, X)) {
    MatrixXd T = MatrixXd::Zero(R, P);
    T.bottomRows(P).setIdentity();
    T.middleRows<3>(9) = -X;
    reach = SymmetricEigen(K, T.transpose() * e.mass * T).eigenvalues()[reach_mode];
  }
  nodes_.push_back(std::move(node));
  reach_.push_back(reach);
}

TubeDynamics::Local TubeDynamics::locate(const Place& place) const {
  assert(nodes_.size() >= 2);
  Local at;
  at.mirrored = place.sigma < 0;
  const double sign = at.mirrored ? -1 : 1;
  at.sigma = sign * place.sigma;
  while (at.interval + 2 < nodes_.size() && at.sigma > nodes_[at.interval + 1].table.sigma)
    ++at.interval;
  at.z = {sign * place.tau, sign * place.twist, place.f[0] - force_centre_, place.f[1], place.f[2]};
  return at;
}

// All entries to a total degree of 2, or those of the stiffness to 1 or 2.
void TubeDynamics::read(const Local& at, bool all, int total, Entries& entries) const {
  const StateTable &a = nodes_[at.interval].table, &b = nodes_[at.interval + 1].table;
  const StateWeights<double> w = state_weights(a.sigma, b.sigma, at.sigma, at.z, total);
  const auto sum = [&](const MatrixXd& A, const MatrixXd& B, const auto& weights,
                       const std::vector<Slot>& slots, int stiffness) {
    const Eigen::Index rows = all ? A.rows() : stiffness;
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, R*(R + 1), 1> values(rows);
    values.noalias() = A.topRows(rows) * weights[0];
    values.noalias() += B.topRows(rows) * weights[1];
    for (Eigen::Index r = 0; r < rows; ++r)
      entries.put(slots[static_cast<std::size_t>(r)], values[r]);
  };
  sum(a.even, b.even, w.even, layout().even, layout().even_stiffness);
  sum(a.odd, b.odd, w.odd, layout().odd, layout().odd_stiffness);
}

TubeDynamics::Answer TubeDynamics::evaluate(const Place& place) const {
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
    const RateSigns& signs = layout().mirror;
    const auto internal = signs.template tail<P>();
    answer.stiffness = (internal.asDiagonal() * answer.stiffness * internal.asDiagonal()).eval();
    answer.mass = (signs.asDiagonal() * answer.mass * signs.asDiagonal()).eval();
  }
  answer.reach = std::min(reach_[at.interval], reach_[at.interval + 1]);
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
  const DynamicsNode &a = nodes_[at.interval], &b = nodes_[at.interval + 1];
  const double h = b.table.sigma - a.table.sigma, t = (at.sigma - a.table.sigma) / h, r = 1 - t;
  const Eigen::Index rows = a.stations.rows() / (R - 3);
  MatrixXd all = MatrixXd::Zero(rows, R);
  for (Eigen::Index i = 0; i < rows; i += 6) all.block<3, 3>(i, 0).setIdentity();
  all.rightCols(R - 3) =
      (r * r * (1 + 2 * t) * a.stations.col(0) + h * t * r * r * a.stations.col(1) +
       t * t * (1 + 2 * r) * b.stations.col(0) - h * r * t * t * b.stations.col(1))
          .reshaped(rows, R - 3);
  if (!at.mirrored) return all;
  for (Eigen::Index i = 2; i < rows; i += 3) all.row(i) *= -1;
  return all * layout().mirror.asDiagonal();
}

}  // namespace flexopt
