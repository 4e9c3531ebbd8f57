#include "core/reduction/tube/tube_dynamics.hpp"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>

#include "core/math/decompositions.hpp"
#include "core/reduction/tube/dynamics_entries.hpp"

namespace flexopt {
namespace {

constexpr int P = DynamicsEntries::P, R = DynamicsEntries::R;
using Square = DynamicsEntries::Square;
using Flat = DynamicsEntries::Flat;
using Six = Eigen::Matrix<double, P, 6>;
using RateMatrix = DynamicsEntries::RateMatrix;
using RateSigns = Eigen::Matrix<double, R, 1>;
using Slot = DynamicsEntries::Slot;

const DynamicsLayout& layout() { return DynamicsLayout::get(); }

// Changes to the amplitudes U⁻ᵀ a.
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

// Table of number(slot, monomial) about a bent state.
template <class Number>
StateTable table_of(double sigma, const Number& number) {
  const auto filled = [&](const std::vector<Slot>& slots, const auto& monomials) {
    MatrixXd table(static_cast<Eigen::Index>(slots.size()),
                   static_cast<Eigen::Index>(monomials.size()));
    for (std::size_t s = 0; s < slots.size(); ++s)
      for (std::size_t c = 0; c < monomials.size(); ++c)
        table(static_cast<Eigen::Index>(s), static_cast<Eigen::Index>(c)) =
            number(slots[s], monomials[c]);
    return table;
  };
  return {sigma, filled(layout().even, even_monomials()), filled(layout().odd, odd_monomials())};
}

// The numbers at the bent state itself, where the odd ones vanish.
DynamicsEntries entries_at(const StateTable& table) {
  DynamicsEntries e;
  for (std::size_t s = 0; s < layout().even.size(); ++s)
    e.put(layout().even[s], table.even(static_cast<Eigen::Index>(s), 0));
  return e;
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
  node.table = table_of(sigma, [&](const Slot& s, const StateMonomial& m) {
    return (*parts[s.matrix])[m.number](s.row, s.column);
  });
  node.stations.resize(e.stations.rows() * e.stations.cols(), 2);
  for (int k = 0; k < 2; ++k) node.stations.col(k) = e.stations[k].reshaped();
  return node;
}

// ---------------------------------------------------------------------------- tables

DynamicsNode TubeDynamics::weights(const DynamicsNode& node, const PlateShape& shape,
                                   double along) {
  const DynamicsEntries e = entries_at(node.table);
  const RateSigns m = e.mass.diagonal().cwiseSqrt();
  const Eigen::Matrix<double, P, 1> k = e.k.diagonal().cwiseSqrt();
  const Vector3d F = e.F.diagonal().cwiseSqrt();
  const auto unit = [&](const Slot& s) {
    switch (s.matrix) {
      case DynamicsEntries::k_part:
        return k[s.row] * k[s.column];
      case DynamicsEntries::G_part:
        return F[s.row] * k[s.column];
      case DynamicsEntries::F_part:
        return F[s.row] * F[s.column];
      case DynamicsEntries::g_part:
        return k[s.row] * k[s.row] * m[6 + s.column] / m[12 + s.row];
      default:
        return m[s.row] * m[s.column];
    }
  };
  // how far states are from the bent states and off the ray: [rad], a tenth of the buckling load
  const double N =
      0.4 * std::numbers::pi * std::numbers::pi * shape.width / tube_force_scale(shape)[0];
  const std::array<double, 5> away{0.05, 0.01, N, 1, 1};
  DynamicsNode weights;
  weights.table = table_of(node.table.sigma, [&](const Slot& s, const StateMonomial& m) {
    double size = std::pow(along, m.along);
    for (int f = 0; f < m.off_ray; ++f) size *= away[m.variable[f]];
    return size / unit(s);
  });
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
  const DynamicsEntries e = entries_at(node.table);
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
  return locate_among(
      nodes_, [](const DynamicsNode& n) { return n.table.sigma; }, place, force_centre_);
}

// Reads all entries to a total degree of 2, or those of the stiffness to degree 1 or 2.
void TubeDynamics::read(const Local& at, bool all, int total, DynamicsEntries& entries) const {
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
  DynamicsEntries e;
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
  solve_factorised(e.k, S);
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
  DynamicsEntries e, lower;
  read(at, false, 2, e);
  read(at, false, 1, lower);
  Square K, less;
  Flat X;
  constexpr double endless = 1e9;
  if (!e.stiffness(K, X) || !lower.stiffness(less, X)) return endless;
  less -= K;
  if (!factorise(K)) return endless;
  K.triangularView<Eigen::Lower>().solveInPlace(less);
  less.transposeInPlace();
  K.triangularView<Eigen::Lower>().solveInPlace(less);
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
