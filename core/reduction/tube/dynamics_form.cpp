#include "core/reduction/tube/dynamics_form.hpp"

#include <Eigen/LU>

#include <cassert>

#include "core/reduction/tube/table_sums.hpp"

namespace flexopt {
DynamicsForm::DynamicsForm(const TubeDynamics& tables, const TubeDynamics::Place& place,
                           const DynamicsRates& rates) {
  const TubeDynamics::Local at = tables.locate(place);
  const auto a = at.interval, b = a + 1;
  assert(rates.size() <= 3 && (rates.empty() || rates.front().size() > b));
  const StateTable &left = tables.node(a).table, &right = tables.node(b).table;
  const StateWeightSlopes<> w = state_weight_slopes(left.sigma, right.sigma, at.sigma, at.z);

  const DynamicsLayout& layout = DynamicsLayout::get();
  slopes_.resize(static_cast<Eigen::Index>(layout.even.size() + layout.odd.size()), 9);
  const auto read = [&](MatrixXd StateTable::*part, const auto& weights,
                        const std::vector<DynamicsEntries::Slot>& slots, Eigen::Index first) {
    const auto count = static_cast<Eigen::Index>(slots.size());
    MatrixXd x = MatrixXd::Zero(count, 10);  // value, by the state, by the shape
    add_table_sums(left.*part, weights[0], 1, x.leftCols<7>());
    add_table_sums(right.*part, weights[1], 1, x.leftCols<7>());
    for (std::size_t p = 0; p < rates.size(); ++p)
      for (const std::size_t end : {a, b})
        add_table_sums(rates[p][end].*part, weights[end - a].col(0).eval(), 1,
                       x.middleCols<1>(static_cast<Eigen::Index>(7 + p)));
    slopes_.middleRows(first, count) = x.rightCols<9>();
    for (Eigen::Index s = 0; s < count; ++s)
      entries_.put(slots[static_cast<std::size_t>(s)], x(s, 0));
  };
  read(&StateTable::even, w.even, layout.even, 0);
  read(&StateTable::odd, w.odd, layout.odd, static_cast<Eigen::Index>(layout.even.size()));
  mirror_.setOnes();
  if (at.mirrored) {
    mirror_ = layout.mirror;
    slopes_.leftCols<3>() *= -1;
  }

  F_inverse_ = entries_.F.inverse();
  X_.noalias() = F_inverse_ * entries_.G;
  factor_ = entries_.k;
  [[maybe_unused]] const bool positive = factorise(factor_);
  assert(positive);
  static_ << entries_.g, entries_.G.transpose();
  solve_factorised(factor_, static_);
}

DynamicsForm::Motion DynamicsForm::motion(const Rates& r) const {
  Motion found;
  found.r = mirror_.cwiseProduct(r);
  found.x = X_ * found.r.tail<P>();
  // the rates of the fields (D4)
  found.fields = found.r;
  found.fields.segment<3>(9) -= found.x;
  found.fields.tail<P>() += static_ * found.r.segment<6>(6);
  found.moved = entries_.mass * found.fields;
  return found;
}

// Covectors of K, then of −μM through what the fields take from the entries.
DynamicsForm::Covector DynamicsForm::covector(const Motion& m, double mu) const {
  const auto eta = m.r.tail<P>();
  const auto along = m.r.segment<6>(6);  // s′, f′
  DynamicsEntries of;
  of.k = eta * eta.transpose();
  of.G = 2 * m.x * eta.transpose();
  of.F = -m.x * m.x.transpose();
  Eigen::Matrix<double, P, 1> pulled = -2 * mu * m.moved.tail<P>();
  solve_factorised(factor_, pulled);
  const Vector3d held = 2 * mu * F_inverse_ * m.moved.segment<3>(9);
  of.g = pulled * along.head<3>().transpose();
  of.G += along.tail<3>() * pulled.transpose() + held * eta.transpose();
  of.k -= pulled * (static_ * along).transpose();
  of.F -= held * m.x.transpose();
  const Rates weighted = -mu * m.fields;
  const DynamicsLayout& layout = DynamicsLayout::get();
  Covector covector(slopes_.rows());
  Eigen::Index n = 0;
  for (const auto* slots : {&layout.even, &layout.odd})
    for (const DynamicsEntries::Slot& slot : *slots)
      covector[n++] =
          slot.matrix == DynamicsEntries::mass_part
              ? (slot.row == slot.column ? 1 : 2) * m.fields[slot.row] * weighted[slot.column]
              : of.taken(slot);
  return covector;
}

auto DynamicsForm::at(const Rates& r, double mu) const -> Value {
  const Motion m = motion(r);
  const auto eta = m.r.tail<P>();
  Value value;
  value.stiffness = eta.dot(entries_.k * eta) + m.x.dot(entries_.G * eta);
  value.mass = m.fields.dot(m.moved);
  value.along_mass = m.moved;
  value.along_mass.segment<6>(6) += static_.transpose() * m.moved.tail<P>();
  value.along_mass.tail<P>() -= X_.transpose() * m.moved.segment<3>(9);
  value.along_mass = mirror_.cwiseProduct(value.along_mass).eval();
  const Eigen::Matrix<double, 9, 1> by = slopes_.transpose() * covector(m, mu);
  value.state = by.head<6>();
  value.shape = by.tail<3>();
  return value;
}

VectorXd DynamicsForm::by_numbers(const Rates& r, double mu) const {
  return covector(motion(r), mu);
}

}  // namespace flexopt
